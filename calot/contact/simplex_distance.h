// Inside this room only: the closest points of points, segments and triangles.
#pragma once
#include <array>
#include <span>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

using Corners = std::array<Vec3, 3>;

/// Where two simplices are closest: weights of their corners (≥ 0, sum 1), the points, and their distance.
struct Closest {
  Vec3 weights_a = Vec3::Zero(), weights_b = Vec3::Zero();
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double distance = 0;  ///< 0 where they cross
};

/// Weights of the point of triangle abc closest to p. A triangle without area is taken as its edges.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Shares along the segments p0 p1 and q0 q1 of their closest points.
std::array<double, 2> closest_on_segments(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1);

/// Closest points of a point, segment or triangle a (its first `count` corners) and a triangle b.
Closest closest_points(const Corners& a, int count, const Corners& b);

/// The point of a (first `count` corners) closest to p, as weights.
Vec3 closest_on_simplex(const Vec3& p, const Corners& a, int count);

inline Vec3 weighted(const Corners& corners, const Vec3& weights) {
  return weights(0) * corners[0] + weights(1) * corners[1] + weights(2) * corners[2];
}

}  // namespace calot::detail
