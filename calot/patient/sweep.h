// Curves, and the bodies that balls of varying radius sweep along them.
#pragma once
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "calot/image/volume.h"
#include "calot/mesh/tet_mesh.h"

namespace calot {

using Curve = std::vector<Vec3>;  ///< points in order [m]

struct Ball {
  Vec3 centre;    ///< [m]
  double radius;  ///< [m]
};
/// A body: the union of balls that follow each other closely.
using BallChain = std::vector<Ball>;

/// A smooth curve (Catmull-Rom) through at least two points, forty pieces between each two.
Curve spline(const std::vector<Vec3>& through);
/// The curve scaled about its first point to an arc length [m].
Curve scaled_to_length(Curve curve, double length);
/// Points at equal steps of arc length, about `step` [m] apart, ends kept.
Curve resampled(const Curve& curve, double step);
/// Distance [m] of a point from the nearest segment of the curve.
double distance_to(const Curve& curve, const Vec3& point);

BallChain balls_along(const Curve& curve, const std::vector<double>& radii);
Eigen::AlignedBox3d bounds(const BallChain& balls);
/// Volume [m³] of the body around its axis taken straight; exact where the axis is.
double volume_of_revolution(const BallChain& balls);

/// Lowers `distance` (one slice k of the grid, size[0]·size[1] values) to the signed distance [m] from the body,
/// negative inside, wherever that is below `reach`. The grid must be axis-parallel.
void lower_to_distance(const BallChain& balls, const VoxelGrid& grid, std::size_t k, double reach,
                       std::span<float> distance);

}  // namespace calot
