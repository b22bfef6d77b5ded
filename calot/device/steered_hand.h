// A device without force that keys, mice and gamepads steer: a virtual handle that moves as they ask.
#pragma once
#include <functional>

#include "calot/base/triple_buffer.h"
#include "calot/sim/haptic_device.h"
#include "calot/sim/instrument.h"

namespace calot {

/// Seconds by a clock that never goes back.
using DeviceClock = std::function<double()>;
DeviceClock steady_clock();

/// What is asked of the handle; totals only ever add up, so that a wish that nobody fetched isn't lost.
struct SteeringWish {
  bool connected = true;
  Vec3 moved = Vec3::Zero();     ///< total of what it moved at once, world axes [m]
  Vec3 velocity = Vec3::Zero();  ///< [m/s]
  double roll_rate = 0;          ///< about the handle's own z [rad/s]
  bool closing = false;          ///< the jaws close, then the grip grows
  bool frozen = false;           ///< jaws and grip stay as they are
  double trigger = 0;            ///< 0 … 1: the first part of its way closes the jaws, the rest grips
  bool pedal = false, button = false;
  std::uint32_t pedal_presses = 0, button_presses = 0;   ///< totals
  double max_opening = 0, usual_grip = 0, max_grip = 0;  ///< of the instrument held [rad], [N]
};

/// `wish` and `publish` on the thread of the events, `read` on another. A press lasts at least 50 ms, so that a world
/// with 60 steps a second sees it. Made for HandMap::tip.
class SteeredHand final : public HapticDevice {
 public:
  explicit SteeredHand(DeviceClock clock = steady_clock());

  [[nodiscard]] DeviceLimits limits() const override { return {0, 0, 1}; }
  DeviceState read() noexcept override;
  void write(const Vec3&, const Vec3&) noexcept override {}

  /// The current wish, to change and publish.
  SteeringWish& wish() { return wish_; }
  void publish();
  void hold(const InstrumentGeometry& geometry);

 private:
  struct Press {
    std::uint32_t seen = 0;
    double until = 0;  // [s]
    bool at(bool down, std::uint32_t presses, double now);
  };
  void move_fingers(const SteeringWish& wish, double elapsed);

  DeviceClock clock_;
  SteeringWish wish_;
  TripleBuffer<SteeringWish> wishes_;
  // The reader's alone:
  DeviceState state_;
  Vec3 seen_ = Vec3::Zero();
  double roll_ = 0, closed_ = 0, grip_ = 0;  // [rad]; share 0 … 1; [N]
  Press pedal_, button_;
  bool started_ = false;
};

}  // namespace calot
