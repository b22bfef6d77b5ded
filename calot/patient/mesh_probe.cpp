#include "calot/patient/mesh_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace calot::detail {
namespace {

/// Distance along the segment, 0 … 1, where it crosses the triangle; empty where it doesn't.
std::optional<double> crossing(const Vec3& from, const Vec3& step, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  const double across = step.dot(normal), area = normal.squaredNorm();
  if (across == 0 || area == 0) return {};
  const double t = (a - from).dot(normal) / across;
  if (!(t >= 0 && t <= 1)) return {};
  const Vec3 p = from + t * step - a;
  const double v = p.cross(ac).dot(normal) / area, w = ab.cross(p).dot(normal) / area;
  constexpr double slack = 1e-9;  // a line through an edge meets one of its two triangles at least
  if (v < -slack || w < -slack || v + w > 1 + slack) return {};
  return t;
}

}  // namespace

std::int32_t MeshProbe::region_at(const Vec3& point) const {
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
    const Tet& tet = mesh_.tets[t];
    const Vec3 &a = mesh_.position(tet[0]), &b = mesh_.position(tet[1]), &c = mesh_.position(tet[2]),
               &d = mesh_.position(tet[3]);
    const Vec3 low = a.cwiseMin(b).cwiseMin(c).cwiseMin(d), high = a.cwiseMax(b).cwiseMax(c).cwiseMax(d);
    if ((point.array() < low.array()).any() || (point.array() > high.array()).any()) continue;
    const bool inside = signed_volume(point, b, c, d) >= 0 && signed_volume(a, point, c, d) >= 0 &&
                        signed_volume(a, b, point, d) >= 0 && signed_volume(a, b, c, point) >= 0;
    if (inside) return mesh_.regions[t];
  }
  return 0;
}

std::optional<MeshProbe::Hit> MeshProbe::first_hit(const Vec3& from, const Vec3& to) const {
  const Vec3 step = to - from;
  double nearest = std::numeric_limits<double>::infinity();
  std::int32_t region = 0;
  for (std::size_t k = 0; k < outer_.triangles.size(); ++k) {
    const Triangle& corner = outer_.triangles[k];
    const auto t =
        crossing(from, step, outer_.positions[corner[0]], outer_.positions[corner[1]], outer_.positions[corner[2]]);
    if (!t || *t >= nearest) continue;
    nearest = *t;
    region = outer_.regions[k];
  }
  if (!std::isfinite(nearest)) return {};
  return Hit{region, nearest * step.norm()};
}

double MeshProbe::nearest_vertex(const Vec3& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& p : outer_.positions) nearest = std::min(nearest, (p - point).norm());
  return nearest;
}

}  // namespace calot::detail
