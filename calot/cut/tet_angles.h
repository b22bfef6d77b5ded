// Inside this room only: the smallest dihedral angle of a tet, quickly.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// The smallest dihedral angle [°]; 0 for a tet that is flat or inside out.
inline double smallest_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a, p = c - b, q = d - b;
  if (!(u.cross(v).dot(w) > 0)) return 0;
  const std::array<Vec3, 4> outward{p.cross(q), w.cross(v), u.cross(w), v.cross(u)};
  std::array<double, 4> inverse;
  for (std::size_t i = 0; i < 4; ++i) {
    const double size = outward[i].squaredNorm();
    if (!(size > 0)) return 0;
    inverse[i] = 1 / std::sqrt(size);
  }
  double cosine = -1;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      cosine = std::max(cosine, -outward[i].dot(outward[j]) * inverse[i] * inverse[j]);
  return std::acos(std::min(cosine, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace calot::detail
