// What a manipulator must do to be felt through: the one seam between a real device and the haptic loop.
#pragma once
#include "calot/contact/rigid_shape.h"

namespace calot {

/// One sample of a device. Everything in world axes; a driver turns its own axes into them.
struct DeviceState {
  double time = 0;         ///< of the sample by any clock that only grows with new samples [s]
  bool connected = false;  ///< false: the rest means nothing
  Pose handle;             ///< of the handle [m]
  double opening = 0;      ///< angle that the fingers ask of the jaws, ≥ 0 [rad]
  double grip = 0;         ///< closing force that they ask, ≥ 0 [N]
  bool pedal = false;      ///< cautery
  bool button = false;     ///< fires a clip when it goes down
};

/// What a device can bear. The haptic loop never asks for more.
struct DeviceLimits {
  double max_force = 0;      ///< ≥ 0 [N]
  double max_torque = 0;     ///< ≥ 0 [N·m]; 0 for one that moves freely about its handle
  double max_stiffness = 0;  ///< > 0 [N/m], of a wall that it renders without humming
};

/// A device. The loop calls `read` and `write` in turn from its own thread, about 1000 times a second, and nothing else
/// while it runs; neither may wait, allocate or throw. A driver whose bus is slower answers with its last sample.
/// Whatever `read` gives is guarded: numbers that aren't finite, jumps, silence (`time` stands still), disconnection.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// The same for as long as the device lives.
  [[nodiscard]] virtual DeviceLimits limits() const = 0;
  /// The last sample.
  virtual DeviceState read() noexcept = 0;
  /// Shows a force [N] and a torque about the handle [N·m] to the hand, until the next call. Always finite and within
  /// the limits. A driver should let go by itself when no call comes for some milliseconds.
  virtual void write(const Vec3& force, const Vec3& torque) noexcept = 0;
};

}  // namespace calot
