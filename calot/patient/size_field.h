// How large the tets should be, everywhere.
#pragma once
#include <array>
#include <vector>

#include "calot/patient/label_field.h"

namespace calot {

/// Wanted edge lengths: each region's own, growing from small ones to large ones by `growth` per unit of distance, so
/// that neighbouring tets differ little. Kept on a grid of its own, coarser than the labels' where those are many.
class SizeField {
 public:
  /// @param edges   one a region [m], > 0
  /// @param growth  edge length gained per distance, > 0; 0.4 makes each tet at most about half as large again as its
  /// neighbour
  SizeField(const LabelField& field, const std::vector<double>& edges, double growth = 0.4);
  /// Wanted edge length [m] at a local point.
  [[nodiscard]] double at(const Vec3& point) const;

 private:
  void fill(const LabelField& field, const std::vector<double>& edges);
  void grow(double growth);

  std::size_t coarseness_;  // voxels along each edge of a cell
  std::array<std::size_t, 3> size_{};
  Vec3 cell_;                // [m]
  std::vector<float> edge_;  // of every cell [m]
};

/// Volume [m³] and surface [m²] of a region, from its voxels.
struct RegionExtent {
  double volume = 0, surface = 0;
  std::vector<double> contact;  ///< of it, with each region from 0, the outside [m²]
  /// The diameter of the cylinder with this volume per surface [m]: a duct's is its diameter.
  [[nodiscard]] double thickness() const { return 4 * volume / surface; }
};
/// One a region, from region 1.
std::vector<RegionExtent> region_extents(const LabelField& field);

/// About how many vertices a mesh with these edge lengths (one a region) will have; good to a factor of two.
double estimated_vertices(const std::vector<RegionExtent>& regions, const std::vector<double>& edges);

}  // namespace calot
