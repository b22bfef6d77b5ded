// Inside this room only: a perspective camera that frames what it is shown.
#pragma once
#include <span>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// A rectangle of pixels.
struct Viewport {
  double left, top, width, height;
};

struct Camera {
  Vec3 eye, right, up, forward;  ///< [m]; the axes are orthonormal
  double focal = 1;              ///< pixels at depth 1
  double centre_x = 0, centre_y = 0;
  double middle_depth = 1;  ///< [m], of the middle of what is framed

  /// Pixel x, y (y down) and 1/depth [1/m].
  [[nodiscard]] Vec3 project(const Vec3& point) const {
    const Vec3 from_eye = point - eye;
    const double inverse = 1 / from_eye.dot(forward);
    return {centre_x + focal * inverse * from_eye.dot(right), centre_y - focal * inverse * from_eye.dot(up), inverse};
  }
};

/// The camera that looks along `direction` and shows all points as large as fits.
Camera frame_camera(std::span<const Vec3> points, const Vec3& direction, const Vec3& up, const Viewport& viewport);

}  // namespace calot::detail
