#include "calot/patient/centreline.h"

#include <algorithm>

namespace calot {

double length(const Centreline& line) {
  double sum = 0;
  for (std::size_t p = 1; p < line.points.size(); ++p) sum += (line.points[p] - line.points[p - 1]).norm();
  return sum;
}

LinePlace place_at(const Centreline& line, double arc_length) {
  double before = 0;
  for (std::size_t p = 1;; ++p) {
    const Vec3 step = line.points[p] - line.points[p - 1];
    const double size = step.norm();
    if (before + size < arc_length && p + 1 < line.points.size()) {
      before += size;
      continue;
    }
    const double t = size > 0 ? std::clamp((arc_length - before) / size, 0.0, 1.0) : 0;
    return {line.points[p - 1] + t * step, size > 0 ? Vec3(step / size) : Vec3::Zero(),
            (1 - t) * line.radii[p - 1] + t * line.radii[p]};
  }
}

}  // namespace calot
