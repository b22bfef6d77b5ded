#include "app/view_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace calot {
namespace {

using Vec3f = Eigen::Vector3f;
constexpr double nearest = 0.05, farthest = 0.14, patient_distance = 0.13;  // from what is looked at [m]

Vec3f single(const Vec3& v) {
  return v.cast<float>();
}

/// A direction across `view` that is as upright as can be.
Vec3 upright(const Vec3& view, const Vec3& gravity) {
  const Vec3 against = gravity.norm() > 0 ? Vec3(-gravity.normalized()) : Vec3(Vec3::UnitZ());
  for (const Vec3& up : {against, Vec3(Vec3::UnitY()), Vec3(Vec3::UnitX())})
    if (up.cross(view).norm() > 0.35) return up;
  return Vec3::UnitZ();
}

Camera patient_camera(const CameraPose& pose) {
  const Vec3 back = pose.tip - pose.target;
  const Vec3 eye = pose.target + std::min(back.norm(), patient_distance) * back.normalized();
  return camera_looking(single(eye), single(pose.target), single(pose.up));
}

/// What the instruments work on: where their tips come in the run, and the tissue.
Camera found_camera(const Scene& scene, const SceneRun& run) {
  Eigen::AlignedBox3d tissue, work;
  for (const Vec3& x : run.world().model().mesh().positions) tissue.extend(x);
  Vec3 outward = Vec3::Zero();
  const double end = scene.time_step * static_cast<double>(scene.steps);
  for (std::size_t k = 0; k < scene.instruments.size(); ++k)
    for (int moment = 0; moment <= 20; ++moment) {
      const InstrumentInput input = run.asked(k, end * moment / 20);
      const Vec3 tip = input.pose * Vec3(0, 0, run.world().instruments()[k].geometry().jaw_length);
      if (tissue.exteriorDistance(tip) < 0.01) work.extend(tip);
      outward -= input.pose.rotation * Vec3::UnitZ();
    }
  if (work.isEmpty()) work = tissue;
  const Vec3 target = 0.5 * (work.center() + tissue.center());
  Vec3 back = outward.norm() > 1e-6 ? Vec3(outward.normalized()) : Vec3(0, -0.8, 0.6);
  const Vec3 up = upright(back, scene.gravity);
  back = (back - 0.5 * (up - up.dot(back) * back)).normalized();
  const double distance = std::clamp(0.8 * tissue.sizes().norm(), nearest, farthest);
  return camera_looking(single(target + distance * back), single(target), single(up));
}

}  // namespace

Camera scene_camera(const Scene& scene, const SceneRun& run) {
  if (scene.camera)
    return camera_looking(single(scene.camera->eye), single(scene.camera->target), single(scene.camera->up));
  if (run.patient()) {
    const CameraPose& pose = run.patient()->landmarks.camera;
    const Vec3 gaze = pose.target - pose.tip;
    if (gaze.norm() > 0 && pose.up.cross(gaze).norm() > 1e-3 * gaze.norm()) return patient_camera(pose);
  }
  return found_camera(scene, run);
}

Camera orbited(const Camera& camera, float distance, float right, float up, float closer) {
  const Eigen::Vector3f target = camera.eye + distance * camera.forward;
  const Eigen::AngleAxisf about_up(right, camera.up), about_right(up, camera.right());
  const Eigen::Vector3f back = about_up * (about_right * Eigen::Vector3f(-camera.forward));
  Camera turned = camera;
  turned.eye = target + distance / closer * back;
  turned.forward = -back;
  turned.up = about_up * (about_right * camera.up);
  return turned;
}

}  // namespace calot
