#include "calot/compliance/displacements.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "calot/base/error.h"

namespace calot {

Displacements multiply(const FullCompliance& compliance, const std::vector<PointForce>& forces) {
  for (const PointForce& force : forces)
    if (force.vertex.index() >= compliance.vertices)
      throw InputError("force", "vertex " + std::to_string(force.vertex.value) + " is not in the mesh");
  Displacements u(compliance.vertices, Vec3::Zero());
  for (std::size_t r = 0; r < compliance.size(); ++r)
    for (const PointForce& force : forces)
      u[r / 3][static_cast<int>(r % 3)] +=
          Eigen::Map<const Vec3>(compliance.row(r) + 3 * force.vertex.index()).dot(force.force);
  return u;
}

Distance distance_between(const Displacements& a, const Displacements& b) {
  Distance distance;
  if (a.empty()) return distance;
  double sum = 0, squares = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    const double d = (a[v] - b[v]).norm();
    distance.max = std::max(distance.max, d);
    sum += d;
    squares += d * d;
  }
  const auto count = static_cast<double>(a.size());
  distance.mean = sum / count;
  distance.std = std::sqrt(std::max(0.0, squares / count - distance.mean * distance.mean));
  return distance;
}

}  // namespace calot
