#include "calot/contact/simplex_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

double closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  return length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
}

/// Keeps the closest of several pairs of points.
struct Least {
  Closest best;
  double squared = std::numeric_limits<double>::infinity();
  const Corners& a;
  const Corners& b;

  void offer(const Vec3& weights_a, const Vec3& weights_b) {
    const Vec3 x = weighted(a, weights_a), y = weighted(b, weights_b);
    const double d = (x - y).squaredNorm();
    if (d >= squared) return;
    squared = d;
    best = {weights_a, weights_b, x, y, 0};
  }
};

Vec3 on_edge(int edge, double share) {
  Vec3 weights = Vec3::Zero();
  weights(edge) = 1 - share;
  weights((edge + 1) % 3) = share;
  return weights;
}

/// Where the segment p q crosses a triangle's inside: share along it and weights.
bool crosses(const Vec3& p, const Vec3& q, const Corners& t, double& share, Vec3& weights) {
  const Vec3 u = t[1] - t[0], v = t[2] - t[0], normal = u.cross(v);
  const double at_p = normal.dot(p - t[0]), at_q = normal.dot(q - t[0]);
  if ((at_p > 0) == (at_q > 0) || at_p == at_q) return false;
  share = at_p / (at_p - at_q);
  const Vec3 x = p + share * (q - p) - t[0];
  const double area = normal.squaredNorm();
  const double y = x.cross(v).dot(normal) / area, z = u.cross(x).dot(normal) / area;
  if (!(y >= 0 && z >= 0 && y + z <= 1)) return false;
  weights = {1 - y - z, y, z};
  return true;
}

}  // namespace

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  // The inside where p lies over it, else the best of the edges.
  const Vec3 u = b - a, v = c - a, w = p - a, normal = u.cross(v);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const double y = w.cross(v).dot(normal) / area, z = u.cross(w).dot(normal) / area;
    if (y >= 0 && z >= 0 && y + z <= 1) return {1 - y - z, y, z};
  }
  const std::array<const Vec3*, 3> corners{&a, &b, &c};
  Vec3 best = Vec3::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int e = 0; e < 3; ++e) {
    const Vec3 &from = *corners[e], &to = *corners[(e + 1) % 3];
    const double share = closest_on_segment(p, from, to);
    const double d = (from + share * (to - from) - p).squaredNorm();
    if (d >= least) continue;
    least = d;
    best = on_edge(e, share);
  }
  return best;
}

std::array<double, 2> closest_on_segments(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) {
  const Vec3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm(), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  if (determinant > 1e-12 * uu * vv) {
    const double s = (uv * vw - vv * uw) / determinant, t = (uu * vw - uv * uw) / determinant;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return {s, t};
  }
  // Else one of the four ends is closest.
  std::array<double, 2> best{0, 0};
  double least = std::numeric_limits<double>::infinity();
  const auto offer = [&](double s, double t) {
    const double d = (p0 + s * u - q0 - t * v).squaredNorm();
    if (d >= least) return;
    least = d;
    best = {s, t};
  };
  offer(0, closest_on_segment(p0, q0, q1));
  offer(1, closest_on_segment(p1, q0, q1));
  offer(closest_on_segment(q0, p0, p1), 0);
  offer(closest_on_segment(q1, p0, p1), 1);
  return best;
}

Vec3 closest_on_simplex(const Vec3& p, const Corners& a, int count) {
  if (count == 1) return Vec3::UnitX();
  if (count == 2) return on_edge(0, closest_on_segment(p, a[0], a[1]));
  return closest_on_triangle(p, a[0], a[1], a[2]);
}

Closest closest_points(const Corners& a, int count, const Corners& b) {
  Least least{{}, std::numeric_limits<double>::infinity(), a, b};
  const int edges = count == 3 ? 3 : count - 1;
  double share = 0;
  Vec3 weights;
  for (int e = 0; e < edges; ++e)
    if (crosses(a[e], a[(e + 1) % 3], b, share, weights)) {
      least.offer(on_edge(e, share), weights);
      least.best.distance = 0;
      return least.best;
    }
  if (count == 3)
    for (int e = 0; e < 3; ++e)
      if (crosses(b[e], b[(e + 1) % 3], a, share, weights)) {
        least.offer(weights, on_edge(e, share));
        least.best.distance = 0;
        return least.best;
      }
  for (int c = 0; c < count; ++c) least.offer(Vec3::Unit(c), closest_on_triangle(a[c], b[0], b[1], b[2]));
  if (count == 3)
    for (int c = 0; c < 3; ++c) least.offer(closest_on_simplex(b[c], a, count), Vec3::Unit(c));
  for (int e = 0; e < edges; ++e)
    for (int f = 0; f < 3; ++f) {
      const auto [s, t] = closest_on_segments(a[e], a[(e + 1) % 3], b[f], b[(f + 1) % 3]);
      least.offer(on_edge(e, s), on_edge(f, t));
    }
  least.best.distance = std::sqrt(least.squared);
  return least.best;
}

}  // namespace calot::detail
