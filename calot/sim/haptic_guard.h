// What a device says, made safe: faults hold the instrument where it was, and the way back is smooth.
#pragma once
#include <string_view>

#include "calot/sim/haptic_constraints.h"
#include "calot/sim/haptic_device.h"

namespace calot {

enum class HapticStatus : std::uint8_t {
  waiting,  ///< no good sample yet
  working,
  recovering,    ///< good samples again; the instrument glides to the device, then the force comes back
  not_a_number,  ///< from here on: holding, force fading or gone
  jump,
  silent,
  disconnected,
};
std::string_view name_of(HapticStatus status);

struct GuardOptions {
  double largest_jump = 0.02;  ///< between two samples [m]; a hand moves at 5 m/s at most, 5 mm in a tick
  double largest_turn = 0.5;   ///< [rad]
  double silence = 0.02;       ///< longest time without a new sample [s]
  double settle = 0.02;        ///< good samples needed after a fault [s]
  double fade = 0.1;           ///< of the force, out and in [s]
  double glide_speed = 0.1;    ///< of the instrument on its way back to the device [m/s]
  double glide_turn = 1.0;     ///< [rad/s]
};

struct GuardedInput {
  bool has_pose = false;  ///< false until the first good sample
  Pose handle;            ///< never jumps
  double opening = 0, grip = 0;
  bool pedal = false, button = false;  ///< off from a fault on until let go and pressed again
  double share = 0;                    ///< of the force to be shown, 0 … 1
  Vector6 motion = Vector6::Zero();    ///< of the real handle since the last tick; zero where unknown
  HapticStatus status = HapticStatus::waiting;
};

class HapticGuard {
 public:
  explicit HapticGuard(const GuardOptions& options) : options_(options) {}
  /// @param now  [s], by the loop's clock; `elapsed` since the last call [s]
  GuardedInput check(const DeviceState& sample, double now, double elapsed);

 private:
  enum class Mode : std::uint8_t { holding, gliding, following };
  [[nodiscard]] HapticStatus fault_of(const DeviceState& sample, double now) const;
  void hold(HapticStatus fault);
  void follow(const DeviceState& sample, double elapsed);
  void glide(double elapsed);

  GuardOptions options_;
  GuardedInput out_;
  Mode mode_ = Mode::holding;
  bool seen_ = false;            // a raw pose to compare with
  Pose raw_;                     // the last finite one
  double sample_time_ = 0;       // the last sample's
  double fresh_ = 0, good_ = 0;  // loop's time of the last new sample; seconds of good ones since the last fault
  bool started_ = false;
  Vector6 behind_ = Vector6::Zero();  // twist from the device to where the instrument still is
  bool pedal_armed_ = false, button_armed_ = false;
};

}  // namespace calot
