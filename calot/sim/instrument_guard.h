// Keeps bad input of a device away from the simulation: the instrument holds still, and says why.
#pragma once
#include <optional>
#include <string>

#include "calot/sim/instrument.h"

namespace calot {

enum class InputStatus : std::uint8_t {
  good,
  missing,         ///< nothing came: stopped sending or disconnected
  not_a_number,    ///< NaN or infinite
  not_a_rotation,  ///< a quaternion that isn't of length 1 (within 1 %)
  jumped,          ///< further or more turned within a step than a hand moves
  opening_out_of_range,
  grip_out_of_range,
  recovering,  ///< input is good again; the instrument is on its way there
};
/// In words for the screen: "the device sends nothing; the instrument holds".
std::string_view words_of(InputStatus status);

struct GuardLimits {
  double jump = 0.05;             ///< between two inputs, ≥ this is refused [m]
  double turn = 1.0;              ///< the same of the rotation [rad]
  double recovery_speed = 1.0;    ///< [m/s]
  double recovery_turn = 6.0;     ///< [rad/s]
  double recovery_opening = 3.0;  ///< [rad/s]
  int trust_after = 3;            ///< so many good inputs in a row end a fault
};

/// One for each instrument. A plain value.
class InstrumentGuard {
 public:
  InstrumentGuard(const InstrumentGeometry& geometry, const InstrumentInput& start, const GuardLimits& limits = {});

  /// Takes what came for this step (nothing: empty) and gives what the instrument does. While a fault lasts, pose,
  /// opening and grip stay as they were, and energy and fire are off; afterwards the instrument catches up no faster
  /// than the limits allow.
  const InstrumentInput& accept(const std::optional<InstrumentInput>& input, double step);

  [[nodiscard]] const InstrumentInput& accepted() const { return accepted_; }
  [[nodiscard]] InputStatus status() const { return status_; }
  void append_state(std::string& bytes) const;

 private:
  [[nodiscard]] InputStatus judge(const std::optional<InstrumentInput>& input) const;
  void approach(const InstrumentInput& input, double step);

  GuardLimits limits_;
  double max_opening_, max_grip_;
  InstrumentInput accepted_;
  InstrumentInput heard_;  // the last input that was a sound pose, for jumps
  InputStatus status_ = InputStatus::good;
  int good_in_a_row_ = 0;
};

}  // namespace calot
