#include "calot/cut/blade.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot::detail {
namespace {

void check_direction(const Vec3& direction, const std::string& name, const char* what) {
  if (!direction.allFinite())
    throw InputError(name, std::string("its ") + what + " is not finite", "give three numbers");
  if (direction == Vec3::Zero())
    throw InputError(name, std::string("its ") + what + " has length 0", "give a direction such as 1,0,0");
}

void check_extent(double extent, const std::string& name, const char* what) {
  if (!(extent > 0) || !std::isfinite(extent))
    throw InputError(name, std::string("its ") + what + " must be a length > 0", "give it in metres or with a unit");
}

/// A unit vector, also for lengths whose square over- or underflows.
Vec3 direction_of(const Vec3& v) {
  return (v / v.cwiseAbs().maxCoeff()).normalized();
}

Plane plane_of(const Blade& blade) {
  if (const auto* plane = std::get_if<Plane>(&blade)) return *plane;
  const auto& patch = std::get<BladePatch>(blade);
  return {patch.centre, patch.normal};
}

/// The least and greatest of axis·point over the points.
std::pair<double, double> extent_along(const Eigen::Vector2d& axis, const Eigen::Vector2d* points, int count) {
  std::pair<double, double> range{axis.dot(points[0]), axis.dot(points[0])};
  for (int i = 1; i < count; ++i) {
    const double value = axis.dot(points[i]);
    range = {std::min(range.first, value), std::max(range.second, value)};
  }
  return range;
}

}  // namespace

struct ReadyBlade::Section {
  std::array<Eigen::Vector2d, 4> points;
  int count = 0;
  void add(const Eigen::Vector2d& point) { points[static_cast<std::size_t>(count++)] = point; }
};

ReadyBlade::ReadyBlade(const Blade& blade, const std::string& name) : plane_(plane_of(blade)) {
  if (!plane_.point.allFinite()) throw InputError(name, "its point is not finite", "give three numbers");
  check_direction(plane_.normal, name, "normal");
  const auto* patch = std::get_if<BladePatch>(&blade);
  if (patch == nullptr) return;
  check_direction(patch->along, name, "direction of length");
  check_extent(patch->length, name, "length");
  check_extent(patch->width, name, "width");
  const Vec3 normal = direction_of(plane_.normal), wish = direction_of(patch->along);
  const Vec3 across = normal.cross(wish);
  if (across.norm() < 1e-6)
    throw InputError(name, "its direction of length is parallel to its normal",
                     "give a direction in the blade's plane");
  const Vec3 unit_across = across.normalized();
  rectangle_ = Rectangle{unit_across.cross(normal), unit_across, patch->length / 2, patch->width / 2};
}

Eigen::Vector2d ReadyBlade::flat(const Vec3& x) const {
  const Vec3 offset = x - plane_.point;
  return {offset.dot(rectangle_->along), offset.dot(rectangle_->across)};
}

bool ReadyBlade::reaches_section(const std::array<Vec3, 4>& corners, const std::array<int, 4>& sides) const {
  if (!rectangle_) return true;
  const Vec3 normal = direction_of(plane_.normal);
  std::array<double, 4> height;
  for (std::size_t i = 0; i < 4; ++i) height[i] = std::abs(normal.dot(corners[i] - plane_.point));
  Section section;
  for (std::size_t i = 0; i < 4; ++i) {
    if (sides[i] == 0) section.add(flat(corners[i]));
    for (std::size_t j = 0; j < 4; ++j) {
      if (sides[i] <= 0 || sides[j] >= 0) continue;
      const double sum = height[i] + height[j];  // can round to 0 though the exact signs differ
      const double share = sum > 0 ? height[i] / sum : 0.5;
      section.add(flat(corners[i] + share * (corners[j] - corners[i])));
    }
  }
  return overlaps(section);
}

bool ReadyBlade::reaches_triangle(const std::array<Vec3, 3>& corners) const {
  if (!rectangle_) return true;
  Section section;
  for (const Vec3& corner : corners) section.add(flat(corner));
  return overlaps(section);
}

// Two convex shapes overlap unless a line separates them, and then one along an edge of either does. The directions
// between all pairs of points include the edges, and a few more directions do no harm.
bool ReadyBlade::overlaps(const Section& section) const {
  const Eigen::Vector2d half(rectangle_->half_length, rectangle_->half_width);
  const auto separated_along = [&](const Eigen::Vector2d& axis) {
    const double reach = axis.cwiseAbs().dot(half);
    const auto [low, high] = extent_along(axis, section.points.data(), section.count);
    return low >= reach || high <= -reach;
  };
  if (separated_along({1, 0}) || separated_along({0, 1})) return false;
  for (int i = 0; i < section.count; ++i)
    for (int j = 0; j < i; ++j) {
      const Eigen::Vector2d edge =
          section.points[static_cast<std::size_t>(i)] - section.points[static_cast<std::size_t>(j)];
      if (edge != Eigen::Vector2d::Zero() && separated_along({-edge.y(), edge.x()})) return false;
    }
  return true;
}

}  // namespace calot::detail
