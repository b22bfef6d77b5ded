// How tets are summed into blocks: in one place, so that a fresh assembly and a block summed anew after an edit agree
// to the last bit. Internal to the room.
#pragma once
#include <vector>

#include "calot/fem/model.h"

namespace calot::detail {

inline TetShape shape_of(const TetMesh& mesh, const Tet& v) {
  return tet_shape(mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2]), mesh.position(v[3]));
}

/// What one tet adds to a weighted sum of mass and stiffness. A block of the whole is the sum over its tets, ascending,
/// and, on the diagonal, the vertex's own mass last.
class ElementSum {
 public:
  ElementSum(const Model& model, double mass_factor, double stiffness_factor)
      : mass_factor_(mass_factor),
        stiffness_factor_(stiffness_factor),
        by_element_(model.dynamics().mass_lumping == MassLumping::element) {
    for (const auto& [region, material] : model.materials())
      regions_.push_back({region, lame(material), material.density});
  }

  struct Region {
    std::int32_t number;
    Lame lame;
    double density;
  };
  [[nodiscard]] const Region& region(std::int32_t number) const {
    for (const Region& region : regions_)  // a handful
      if (region.number == number) return region;
    return regions_.front();
  }

  /// The block between corners a and b.
  [[nodiscard]] Mat3 block(const Region& region, double scale, const TetShape& shape, int a, int b) const {
    Mat3 result = (stiffness_factor_ * scale) * stiffness_block(shape, region.lame, a, b);
    if (a == b && by_element_) result.diagonal().array() += mass_factor_ * (region.density * shape.volume / 4);
    return result;
  }
  /// What a vertex has whatever tets it keeps: its share [kg] under uniform lumping.
  [[nodiscard]] double own_diagonal(double share) const { return mass_factor_ * share; }

 private:
  double mass_factor_, stiffness_factor_;
  bool by_element_;
  std::vector<Region> regions_;
};

}  // namespace calot::detail
