// Inside this room only: a blade made ready for many queries.
#pragma once
#include <array>
#include <optional>
#include <string>

#include "calot/cut/cut.h"

namespace calot::detail {

/// The plane of a blade and, for a patch, its rectangle.
class ReadyBlade {
 public:
  /// @param name  for messages, e.g. "blade 2". Throws InputError for a degenerate blade.
  ReadyBlade(const Blade& blade, const std::string& name);

  /// −1 below the plane, 0 on it, 1 above; exact.
  [[nodiscard]] int side(const Vec3& x) const { return side_of_plane(x, plane_.point, plane_.normal); }

  /// Whether the section of a tet with this plane overlaps the blade in more than a point or a line. True for planes.
  /// @param sides  of the four corners; some must be −1 and some 1
  [[nodiscard]] bool reaches_section(const std::array<Vec3, 4>& corners, const std::array<int, 4>& sides) const;
  /// The same for a triangle that lies in the plane.
  [[nodiscard]] bool reaches_triangle(const std::array<Vec3, 3>& corners) const;

 private:
  struct Rectangle {
    Vec3 along, across;              // unit, orthogonal to each other and to the normal
    double half_length, half_width;  // [m]
  };
  struct Section;  // up to four points in the rectangle's coordinates
  [[nodiscard]] Eigen::Vector2d flat(const Vec3& x) const;
  [[nodiscard]] bool overlaps(const Section& section) const;

  Plane plane_;
  std::optional<Rectangle> rectangle_;
};

}  // namespace calot::detail
