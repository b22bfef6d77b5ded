// Middle lines of ducts and arteries, with radii.
#pragma once
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// A curve along the middle of a tube.
struct Centreline {
  std::string name;
  std::vector<Vec3> points;   ///< p, in order [m], RAS
  std::vector<double> radii;  ///< p [m]
};

/// Arc length [m].
double length(const Centreline& line);
/// The place [m] and unit direction at an arc length from the first point, clamped to the ends; radius by
/// interpolation.
struct LinePlace {
  Vec3 point, direction;
  double radius;
};
LinePlace place_at(const Centreline& line, double arc_length);

}  // namespace calot
