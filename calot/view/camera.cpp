#include "calot/view/camera.h"

#include <Eigen/Geometry>
#include <cmath>

#include "calot/base/error.h"

namespace calot {

Camera camera_looking(const Eigen::Vector3f& eye, const Eigen::Vector3f& target, const Eigen::Vector3f& up) {
  Camera camera;
  const Eigen::Vector3f gaze = target - eye;
  const Eigen::Vector3f across = gaze.cross(up);
  if (!(gaze.norm() > 1e-6F) || !(across.norm() > 1e-4F * gaze.norm() * up.norm()))
    throw InputError("camera", "it looks at itself, or straight along its up direction",
                     "give a target away from the eye, and an up direction across the view");
  camera.eye = eye;
  camera.forward = gaze.normalized();
  camera.up = across.normalized().cross(camera.forward);
  return camera;
}

Camera laparoscope(const Pose& tip, float oblique, float turn) {
  const Eigen::Matrix3f axes = tip.rotation.toRotationMatrix().cast<float>();
  const Eigen::AngleAxisf about_shaft(turn, axes.col(2));
  const Eigen::Vector3f side = about_shaft * axes.col(1);
  const Eigen::Vector3f gaze = std::cos(oblique) * axes.col(2) + std::sin(oblique) * side;
  const Eigen::Vector3f eye = tip.position.cast<float>();
  const float along = std::abs(gaze.dot(axes.col(1)));
  return camera_looking(eye, eye + 0.05F * gaze, along < 0.98F ? axes.col(1) : Eigen::Vector3f(-axes.col(2)));
}

float half_height(const Camera& camera) {
  const float middle = std::tan(0.5F * camera.field);
  return camera.scope ? 0.5F * middle / round_field_radius : middle;
}

Eigen::Matrix4f view_projection(const Camera& camera, float aspect) {
  const float h = half_height(camera), w = h * aspect, n = camera.nearest, f = camera.farthest;
  Eigen::Matrix4f view = Eigen::Matrix4f::Identity();
  view.block<1, 3>(0, 0) = camera.right().transpose();
  view.block<1, 3>(1, 0) = camera.up.transpose();
  view.block<1, 3>(2, 0) = -camera.forward.transpose();
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.eye;
  Eigen::Matrix4f projection = Eigen::Matrix4f::Zero();
  projection(0, 0) = 1 / w;
  projection(1, 1) = 1 / h;
  projection(2, 2) = (f + n) / (n - f);
  projection(2, 3) = 2 * f * n / (n - f);
  projection(3, 2) = -1;
  return projection * view;
}

Eigen::Vector3f ray_through(const Camera& camera, float aspect, float x, float y) {
  const float h = half_height(camera);
  return (camera.forward + h * aspect * x * camera.right() + h * y * camera.up).normalized();
}

}  // namespace calot
