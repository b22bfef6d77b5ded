// A haptic device without hardware: a hand that follows a script, and faults on command.
#pragma once
#include <atomic>
#include <functional>

#include "calot/sim/haptic_device.h"

namespace calot {

enum class MockFault {
  none,
  not_a_number,  ///< the position is NaN
  jump,          ///< the handle is 1 m away
  silent,        ///< samples stop coming; the hand moves on
  disconnected,
};

/// The hand and the handle that it holds: a mass on a spring and a damper to the place where the hand wants to be.
/// Light, soft and little damped is what shakes first; the defaults are on that side.
struct MockHand {
  double mass = 0.15;          ///< [kg]
  double stiffness = 300;      ///< [N/m]
  double damping = 3;          ///< [N·s/m]
  double friction = 1;         ///< viscous, of the device [N·s/m]
  double inertia = 3e-4;       ///< [kg·m²]
  double turning = 1.0;        ///< stiffness of rotation [N·m/rad]
  double turn_damping = 5e-3;  ///< [N·m·s/rad]
};

/// Each read advances the mock's own time by `period`. `set_fault` may be called from any thread.
class MockHapticDevice final : public HapticDevice {
 public:
  /// Where the hand wants the handle at a time [s].
  using Script = std::function<Pose(double)>;
  explicit MockHapticDevice(Script wanted, MockHand hand = {}, DeviceLimits limits = {8.0, 0.3, 3000.0},
                            double period = 1e-3);

  [[nodiscard]] DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override;
  void write(const Vec3& force, const Vec3& torque) noexcept override;

  void set_fault(MockFault fault) { fault_ = fault; }
  /// What the fingers do from the next read on.
  void set_fingers(double opening, double grip, bool pedal, bool button);

  // For tests, while no loop runs.
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] const Pose& handle() const { return handle_; }
  [[nodiscard]] const Vec3& velocity() const { return velocity_; }
  [[nodiscard]] const Vec3& force() const { return force_; }
  [[nodiscard]] const Vec3& torque() const { return torque_; }

 private:
  void advance(double seconds);

  Script wanted_;
  MockHand hand_;
  DeviceLimits limits_;
  double period_;
  std::atomic<MockFault> fault_ = MockFault::none;
  std::atomic<double> opening_ = 0, grip_ = 0;
  std::atomic<bool> pedal_ = false, button_ = false;
  double time_ = 0;
  Pose handle_;
  DeviceState last_;
  Vec3 velocity_ = Vec3::Zero(), spin_ = Vec3::Zero();  // [m/s], [rad/s]
  Vec3 force_ = Vec3::Zero(), torque_ = Vec3::Zero();   // shown by the loop
};

}  // namespace calot
