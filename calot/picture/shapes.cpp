#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/picture/picture.h"

namespace calot {
namespace {

constexpr std::uint32_t sides = 24;

/// Sweeps a profile of (distance along the axis, radius) around an axis; first and last radius are 0.
void add_turned(Surface& surface, const Vec3& origin, const Vec3& axis,
                const std::vector<std::pair<double, double>>& profile) {
  const Vec3 a = axis.unitOrthogonal(), b = axis.cross(a);
  const auto first = static_cast<std::uint32_t>(surface.positions.size());
  for (const auto& [along, radius] : profile)
    for (std::uint32_t s = 0; s < sides; ++s) {
      const double angle = 2 * std::numbers::pi * s / sides;
      surface.positions.push_back(origin + along * axis + radius * (std::cos(angle) * a + std::sin(angle) * b));
    }
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring)
    for (std::uint32_t s = 0; s < sides; ++s) {
      const std::uint32_t next = (s + 1) % sides;
      const std::uint32_t p = first + ring * sides + s, q = first + ring * sides + next;
      if (profile[ring].second > 0) surface.triangles.push_back({p, q, q + sides});
      if (profile[ring + 1].second > 0) surface.triangles.push_back({p, q + sides, p + sides});
    }
}

}  // namespace

Surface arrow_surface(const Vec3& from, const Vec3& to, double radius) {
  Surface surface;
  const double length = (to - from).norm();
  if (!(length > 0)) return surface;
  const double head = std::min(6 * radius, 0.6 * length);
  const double neck = length - head;
  add_turned(surface, from, (to - from) / length,
             {{0, 0}, {0, radius}, {neck, radius}, {neck, 2.4 * radius}, {length, 0}});
  return surface;
}

Surface capsule_surface(const Vec3& from, const Vec3& to, double radius) {
  constexpr int rings = 6;
  Surface surface;
  const double length = (to - from).norm();
  std::vector<std::pair<double, double>> profile;
  for (int end = 0; end < 2; ++end)
    for (int r = 0; r <= rings; ++r) {
      const double angle = std::numbers::pi / 2 * (r + end * rings) / rings;
      const bool pole = r == (end == 0 ? 0 : rings);
      profile.emplace_back((end == 0 ? 0 : length) - radius * std::cos(angle), pole ? 0.0 : radius * std::sin(angle));
    }
  add_turned(surface, from, length > 0 ? Vec3((to - from) / length) : Vec3(Vec3::UnitZ()), profile);
  return surface;
}

Surface ball_surface(std::span<const Vec3> centres, double radius) {
  constexpr int rings = 12;
  std::vector<std::pair<double, double>> profile;
  for (int r = 0; r <= rings; ++r) {
    const double angle = std::numbers::pi * r / rings;
    profile.emplace_back(-radius * std::cos(angle), r == 0 || r == rings ? 0.0 : radius * std::sin(angle));
  }
  Surface surface;
  for (const Vec3& centre : centres) add_turned(surface, centre, Vec3::UnitZ(), profile);
  return surface;
}

}  // namespace calot
