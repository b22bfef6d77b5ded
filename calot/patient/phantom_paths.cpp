#include "calot/patient/phantom_paths.h"

#include <algorithm>
#include <cmath>

namespace calot {

double clearance(const Curve& path, double radius, const Obstacles& obstacles) {
  double least = 1;
  for (const Vec3& p : path) {
    const double from_start = (p - path.front()).norm(), from_end = (p - path.back()).norm();
    for (const Obstacles::Tube& tube : obstacles.tubes)
      if (from_start >= tube.ignored_near_start && from_end >= tube.ignored_near_end)
        least = std::min(least, distance_to_tube(*tube.curve, tube.radius, p) - radius);
    if (obstacles.liver && from_start >= obstacles.liver_ignored_near_start &&
        from_end >= obstacles.liver_ignored_near_end)
      least = std::min(least, obstacles.liver->at(p));
    if (obstacles.gallbladder && from_end >= obstacles.gallbladder_ignored_near_end)
      least = std::min(least, distance_to(*obstacles.gallbladder, p) - radius);
  }
  return least;
}

Curve bowed(const Vec3& from, const Vec3& to, const Vec3& side, double height) {
  const Vec3 chord = to - from;
  const Vec3 out = (side - side.dot(chord) / chord.squaredNorm() * chord).normalized();
  const Vec3 across = chord.normalized().cross(out);
  Curve curve;
  constexpr int pieces = 40;
  for (int i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    curve.push_back(from + t * chord + height * (4 * t * (1 - t) * out + 0.25 * std::sin(2 * M_PI * t) * across));
  }
  return curve;
}

}  // namespace calot
