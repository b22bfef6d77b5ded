// Constraint sets with known answers, and a world that publishes them late.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "calot/sim/haptic_tick.h"
#include "tests/support/meshes.h"

namespace calot::test {

/// A wall of tissue below z = height; each point [m, in the tool's frame, not turned] touches it on its own.
/// @param stiffness  of the wall under each point [N/m]
inline HapticConstraints wall_set(const Pose& tool, double stiffness, double friction,
                                  const std::vector<Vec3>& points = {Vec3::Zero()}, double height = 0) {
  HapticConstraints set;
  const auto rows = static_cast<Eigen::Index>(3 * points.size());
  set.pose = tool;
  set.problem.friction.assign(points.size(), friction);
  set.problem.delassus = Eigen::MatrixXd::Identity(rows, rows) / stiffness;
  set.problem.free_motion.setZero(rows);
  set.motion.setZero(rows, 6);
  Eigen::Matrix3d axes;  // rows: normal from the tool to the tissue, tangents
  axes << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 * i);
    const Vec3 arm = tool.rotation * points[i];
    set.problem.free_motion[row] = (tool.position + arm).z() - height;
    Eigen::Matrix3d cross;  // arm ×
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    set.motion.block<3, 3>(row, 0) = -axes;
    set.motion.block<3, 3>(row, 3) = axes * cross;  // the point moves by turn × arm = −arm × turn
  }
  set.wrench = set.motion.transpose();
  return set;
}

inline DeviceState sample_at(double time, const Pose& handle) {
  DeviceState sample;
  sample.time = time;
  sample.connected = true;
  sample.handle = handle;
  return sample;
}

inline Pose at(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), Vec3(x, y, z)};
}

/// Loose limits, so that nothing but the contact shapes the force.
inline HapticOptions free_options() {
  HapticOptions options;
  options.limits = {1e3, 1e2, 1e6, 1e6, 1e3, 1e6, 1e3};
  options.damping = options.turning_damping = 0;
  return options;
}
inline DeviceLimits strong_device() {
  return {1e3, 1e2, 1e9};
}

/// Holds the device still at a pose until everything has settled.
inline HapticOutput settled(HapticTick& tick, const Pose& handle, double& time, int ticks = 400) {
  HapticOutput out;
  for (int i = 0; i < ticks; ++i, time += 1e-3) out = tick.run(sample_at(time, handle), time);
  return out;
}

/// Publishes a wall's set every `every` ticks, `late` ticks after the pose it is for.
class LateWorld {
 public:
  LateWorld(double stiffness, double friction, int every, int late)
      : stiffness_(stiffness), friction_(friction), every_(every), late_(late) {}
  /// Called after each tick.
  void follow(HapticTick& tick, const HapticOutput& out) {
    if (out.has_pose && ++count_ % every_ == 0)
      waiting_.push_back({count_ + late_, wall_set(out.input.pose, stiffness_, friction_)});
    while (!waiting_.empty() && waiting_.front().due <= count_ && tick.wants_set()) {
      waiting_.front().set.step = ++step_;
      EXPECT_TRUE(tick.take(waiting_.front().set));
      waiting_.pop_front();
    }
  }

 private:
  struct Waiting {
    int due;
    HapticConstraints set;
  };
  double stiffness_, friction_;
  int every_, late_, count_ = 0;
  std::uint64_t step_ = 0;
  std::deque<Waiting> waiting_;
};

}  // namespace calot::test
