#include "calot/sim/hook.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot {
namespace {

/// The weights of the triangle's point nearest to p. Voronoi regions of corners, edges and face; [Ericson2005] §5.1.5.
Vec3 nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return Vec3::UnitX();
  if (d3 >= 0 && d4 <= d3) return Vec3::UnitY();
  if (d6 >= 0 && d5 <= d6) return Vec3::UnitZ();
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - share, share};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

/// The foot is looked at in this many places.
constexpr int sample_count = 17;

struct Samples {
  std::array<double, sample_count> distance;
  std::array<Vec3, sample_count> on_foot, on_tissue;
};

}  // namespace

std::optional<HookContact> hook_contact(const InstrumentGeometry& geometry, const Pose& pose,
                                        const TissueSurface& surface, double reach) {
  if (!(geometry.hook_radius > 0))
    throw InputError(std::string(name_of(geometry.kind)), "has no hook", "ask hooks only");
  const Vec3 heel = pose * geometry.hook_heel, tip = pose * geometry.hook_tip;
  const double limit = geometry.hook_radius + reach;
  const Vec3 low = heel.cwiseMin(tip).array() - limit, high = heel.cwiseMax(tip).array() + limit;
  Samples samples;
  for (int k = 0; k < sample_count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    samples.distance[i] = limit;
    samples.on_foot[i] = samples.on_tissue[i] = heel + (tip - heel) * k / (sample_count - 1);
  }
  HookContact contact;
  double least = limit;
  bool found = false;
  for (const auto& triangle : surface.triangles) {
    const Vec3 &a = surface.positions[triangle[0].index()], &b = surface.positions[triangle[1].index()],
               &c = surface.positions[triangle[2].index()];
    bool misses = false;
    for (int axis = 0; axis < 3; ++axis)
      misses |= std::min({a[axis], b[axis], c[axis]}) > high[axis] || std::max({a[axis], b[axis], c[axis]}) < low[axis];
    if (misses) continue;
    for (std::size_t i = 0; i < sample_count; ++i) {
      const Vec3 weights = nearest_weights(samples.on_foot[i], a, b, c);
      const Vec3 point = weights.x() * a + weights.y() * b + weights.z() * c;
      const double distance = (point - samples.on_foot[i]).norm();
      if (distance > samples.distance[i]) continue;
      samples.distance[i] = distance;
      samples.on_tissue[i] = point;
      if (found && distance >= least) continue;
      least = distance;
      found = true;
      contact.nearest = {triangle, weights, TetId::none()};
    }
  }
  if (!found) return std::nullopt;
  std::size_t first = sample_count, last = 0;
  Vec3 sum = Vec3::Zero();
  int touching = 0;
  for (std::size_t i = 0; i < sample_count; ++i) {
    if (samples.distance[i] >= limit) continue;
    first = std::min(first, i);
    last = i;
    sum += samples.on_tissue[i];
    ++touching;
  }
  if (touching == 0) return std::nullopt;
  contact.place = sum / touching;
  contact.begin = samples.on_foot[first];
  contact.end = samples.on_foot[last];
  contact.length = (contact.end - contact.begin).norm();
  contact.radius = std::max(geometry.hook_radius, contact.length / 2);
  contact.gap = least - geometry.hook_radius;
  return contact;
}

}  // namespace calot
