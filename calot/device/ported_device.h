// A device whose handle is the instrument itself, through its port: for the haptic loop.
#pragma once
#include <atomic>

#include "calot/device/hand.h"

namespace calot {

/// Puts a Hand between a device and the haptic loop: `read` gives the instrument's frame as the handle (the loop's
/// tool_in_handle stays the identity), `write` brings the force through the port's lever to the real handle, within
/// what the device bears. Owns neither thread nor device.
class PortedDevice final : public HapticDevice {
 public:
  PortedDevice(HapticDevice& device, const InstrumentGeometry& geometry, const HandOptions& options, const Pose& start)
      : device_(device), hand_(geometry, options, start) {}

  [[nodiscard]] DeviceLimits limits() const override {
    const DeviceLimits own = device_.limits();
    return {own.max_force, own.max_torque, hand_.stiffness_through(own.max_stiffness)};
  }
  DeviceState read() noexcept override;
  void write(const Vec3& force, const Vec3& torque) noexcept override;

  // From any thread.
  void set_clutch(bool on) { clutch_ = on; }
  void set_ratchet(bool on) { ratchet_ = on; }

 private:
  HapticDevice& device_;
  Hand hand_;
  std::atomic<bool> clutch_ = false, ratchet_ = false;
  bool started_ = false;
  double last_ = 0;  // time of the last sample [s]
};

}  // namespace calot
