// Inside this room only: the plane that a blade moved in, and how far it reached there.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "calot/cut/split.h"

namespace calot::detail {

/// A plane with the part of it that was swept: everything, or triangles.
class SweptPlane {
 public:
  /// The mean plane of the triangles; `area` is 0 if there is none.
  SweptPlane(const Sweep& sweep, double margin);
  SweptPlane(const Blade& blade, double margin);

  [[nodiscard]] bool empty() const { return empty_; }                                        ///< nothing was swept
  [[nodiscard]] int side(const Vec3& x) const { return side_of_plane(x, point_, normal_); }  ///< exact
  [[nodiscard]] double height(const Vec3& x) const { return normal_.dot(x - point_); }       ///< [m]
  [[nodiscard]] const Vec3& normal() const { return normal_; }                               ///< unit
  [[nodiscard]] Eigen::Vector2d flat(const Vec3& x) const { return {along_.dot(x - point_), across_.dot(x - point_)}; }
  /// Whether the foot of x lies in the swept part, or within the margin of it.
  [[nodiscard]] bool covers(const Vec3& x) const;
  /// Whether a box in the plane's coordinates meets the box around the swept part.
  [[nodiscard]] bool may_cover(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
    return unbounded_ || ((low.array() <= high_.array()).all() && (high.array() >= low_.array()).all());
  }
  /// The farthest that a corner of the triangles lies off the plane [m].
  [[nodiscard]] double unevenness() const { return unevenness_; }

 private:
  void set_axes(const Vec3& along);
  void set_triangles(std::span<const std::array<Vec3, 3>> triangles);

  Vec3 point_ = Vec3::Zero(), normal_ = Vec3::UnitZ(), along_, across_;
  std::vector<std::array<Eigen::Vector2d, 3>> triangles_;  // counter-clockwise
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), high_ = Eigen::Vector2d::Zero();
  double margin_ = 0, unevenness_ = 0;
  bool unbounded_ = false, empty_ = false;
};

}  // namespace calot::detail
