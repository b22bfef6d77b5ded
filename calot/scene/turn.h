// Inside this room only: the shortest rotation between directions.
#pragma once
#include <Eigen/Geometry>

namespace calot::detail {

/// Takes unit vector a to unit vector b by the shortest way; half a turn about some axis where they are opposite.
inline Eigen::Quaterniond shortest_turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double cosine = a.dot(b);
  if (!(cosine > -1 + 1e-12)) {
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const Eigen::Vector3d axis = a.cross(b);
  return Eigen::Quaterniond(1 + cosine, axis.x(), axis.y(), axis.z()).normalized();
}

}  // namespace calot::detail
