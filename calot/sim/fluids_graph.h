// The tubes of a mesh as a graph, to find what feeds an opening.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "calot/sim/tissue_properties.h"

namespace calot::detail {

constexpr bool has_lumen(VesselKind kind) {
  return kind != VesselKind::none && kind != VesselKind::parenchyma;
}
/// Whether two tets that share a face share a lumen: both carry the same fluid, and not both are wall only.
constexpr bool share_lumen(VesselKind a, VesselKind b) {
  return has_lumen(a) && has_lumen(b) && fluid_of(a) == fluid_of(b) &&
         !(a == VesselKind::gallbladder_wall && b == VesselKind::gallbladder_wall);
}

/// The tets across each face of a tet, none() on the boundary; face f lies opposite corner f.
using Neighbours = std::array<TetId, 4>;

/// Tets with a lumen, joined through faces within the same fluid; not from one tet of a sac to the next, which is all
/// one reservoir.
class VesselGraph {
 public:
  /// @param neighbours, kind_of_tet  m each; kinds are numbers in `kinds`
  void build(const TetMesh& mesh, std::span<const Neighbours> neighbours, std::span<const std::uint8_t> kind_of_tet,
             std::span<const TissueProperties> kinds);
  /// Resistance to laminar flow (Hagen–Poiseuille, 8 μ L / (π r⁴)) of the easiest way from any seed tet to each tet
  /// [Pa s/m³]; infinite where every way is blocked by a closed tet. `seed` and `closed` have a flag a tet.
  void resistances(std::span<const std::uint8_t> seed, std::span<const std::uint8_t> closed,
                   std::vector<double>& out) const;
  /// Tets in connected components; of each, ascending.
  [[nodiscard]] std::vector<std::vector<TetId>> components() const;

 private:
  std::size_t tet_count_ = 0;
  std::vector<TetId> tets_;            // k, ascending
  std::vector<std::uint32_t> number_;  // m, place in tets_, or none
  std::vector<std::uint32_t> start_;   // k + 1
  std::vector<std::uint32_t> next_;    // neighbours, as places in tets_
  std::vector<double> cost_;           // of each step [Pa s/m³]
};

}  // namespace calot::detail
