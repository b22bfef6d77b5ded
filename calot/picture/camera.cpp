#include "calot/picture/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot::detail {
namespace {

constexpr double half_view_tangent = 0.22;  // 25° across the larger side: close to how a drawing shows an organ

void set_axes(Camera& camera, const Vec3& direction, const Vec3& up) {
  camera.forward = direction.normalized();
  const Vec3 right = camera.forward.cross(up);
  if (!direction.allFinite() || !up.allFinite() || !(right.norm() > 1e-6 * up.norm()))
    throw InputError("picture", "the view direction has no length or lies along `up`", "choose another direction");
  camera.right = right.normalized();
  camera.up = camera.right.cross(camera.forward);
}

}  // namespace

Camera frame_camera(std::span<const Vec3> points, const Vec3& direction, const Vec3& up, const Viewport& viewport) {
  Camera camera;
  set_axes(camera, direction, up);
  Vec3 low = Vec3::Constant(1e300), high = -low;
  const auto in_axes = [&](const Vec3& p) {
    return Vec3{p.dot(camera.right), p.dot(camera.up), p.dot(camera.forward)};
  };
  for (const Vec3& p : points) {
    low = low.cwiseMin(in_axes(p));
    high = high.cwiseMax(in_axes(p));
  }
  const Vec3 middle = (low + high) / 2;
  const double tangent_x = half_view_tangent * viewport.width / std::max(viewport.width, viewport.height);
  const double tangent_y = half_view_tangent * viewport.height / std::max(viewport.width, viewport.height);
  double distance = 0.51 * (high - low).z() + 1e-9;  // every point in front of the eye
  for (const Vec3& p : points) {
    const Vec3 q = in_axes(p) - middle;
    distance = std::max({distance, std::abs(q.x()) / tangent_x - q.z(), std::abs(q.y()) / tangent_y - q.z()});
  }
  camera.eye = camera.right * middle.x() + camera.up * middle.y() + camera.forward * (middle.z() - distance);
  camera.middle_depth = distance;
  camera.focal = viewport.width / (2 * tangent_x);
  camera.centre_x = viewport.left + viewport.width / 2;
  camera.centre_y = viewport.top + viewport.height / 2;
  return camera;
}

}  // namespace calot::detail
