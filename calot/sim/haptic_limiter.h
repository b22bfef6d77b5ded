// What keeps the hand safe whatever was computed: limits on energy, size and rate of change.
#pragma once
#include "calot/sim/haptic_constraints.h"

namespace calot {

struct LimiterOptions {
  double max_force = 6.0;    ///< ≥ 0 [N]; the device's own limit counts too
  double max_torque = 1.0;   ///< ≥ 0 [N·m], about the handle
  double force_rate = 1000;  ///< > 0 [N/s]
  double torque_rate = 100;  ///< > 0 [N·m/s]
  double reserve = 0.02;     ///< energy that may be given out before any was taken in, > 0 [J]
  double bank = 0.5;         ///< most of what was taken in that counts, ≥ reserve [J]
  double refill = 0.01;      ///< power at which an empty account fills up to the reserve, ≥ 0 [W]
};

/// Force on the hand and torque about the handle, then the same with rates.
/// The energy that goes out is counted exactly, as the force that is shown stays the same between two ticks: Σ w·Δx. As
/// the account runs out, the part of the wrench that gives out more is taken away along the motion, which is a damper
/// that adapts ([Hannaford2002]); what resists the hand stays.
class HapticLimiter {
 public:
  HapticLimiter(const LimiterOptions& options, double device_force, double device_torque);
  struct Answer {
    Vector6 wrench = Vector6::Zero();
    bool force_limited = false, rate_limited = false, energy_limited = false;
  };
  /// @param wrench  to be shown; anything, NaN counts as zero
  /// @param motion  of the handle since the last call; finite
  Answer limit(Vector6 wrench, const Vector6& motion, double elapsed);
  [[nodiscard]] double account() const { return account_; }  ///< [J]

 private:
  bool spend_less(Vector6& wrench) const;
  void count(const Vector6& motion, double elapsed);

  LimiterOptions options_;
  double account_;
  Vector6 shown_ = Vector6::Zero();
  Vector6 velocity_ = Vector6::Zero();
};

}  // namespace calot
