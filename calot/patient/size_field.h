// How large the tets should be, everywhere.
#pragma once
#include <vector>

#include "calot/patient/label_field.h"

namespace calot {

/// Wanted edge lengths: each region's own, growing from small ones to large ones by `growth` per unit of distance, so
/// that neighbouring tets differ little.
class SizeField {
 public:
  /// @param edges   one a region [m], > 0
  /// @param growth  edge length gained per distance, > 0; 0.4 makes each tet at most about half as large again as its
  /// neighbour
  SizeField(const LabelField& field, const std::vector<double>& edges, double growth = 0.4);
  /// Wanted edge length [m] at a local point.
  [[nodiscard]] double at(const Vec3& point) const;

 private:
  const LabelField& field_;
  std::vector<float> edge_;  // at every voxel [m]
};

/// Thickness [m] of each region, as the diameter of the cylinder with its volume per surface: a duct's is its diameter.
std::vector<double> region_thickness(const LabelField& field);

/// About how many vertices a mesh with these edge lengths will have; good to a factor of two.
double estimated_vertices(const LabelField& field, const std::vector<double>& edges);

}  // namespace calot
