// One thousandth of a second of touch, without thread or clock.
#pragma once
#include "calot/sim/haptic_contact.h"
#include "calot/sim/haptic_guard.h"
#include "calot/sim/haptic_limiter.h"
#include "calot/sim/instrument.h"

namespace calot {

struct HapticOptions {
  double period = 1e-3;             ///< > 0 [s]
  Coupling coupling;                ///< the force's stiffness is at most the device's
  double damping = 1.0;             ///< of the coupling, ≥ 0 [N·s/m]
  double turning_damping = 1e-3;    ///< ≥ 0 [N·m·s/rad]
  Pose tool_in_handle;              ///< the instrument's frame as seen from the handle's
  int iterations = 20;              ///< of the friction solver in a tick, ≥ 1
  int first_iterations = 100;       ///< … against a new constraint set
  double world_period = 1.0 / 60;   ///< of constraint sets, until their own rhythm is known, > 0 [s]
  double longest_blend = 1.0 / 30;  ///< from one set to the next [s]
  double stale_after = 0.25;        ///< the force fades when no new set came for so long [s]
  GuardOptions guard;
  LimiterOptions limits;
};

/// What the world reads.
struct HapticOutput {
  std::uint64_t tick = 0;
  std::uint64_t step = 0;      ///< of the newest constraint set in use
  bool has_pose = false;       ///< false: the device hasn't said anything yet
  InstrumentInput input;       ///< for the world; its pose doesn't enter the constraints
  Vec3 force = Vec3::Zero();   ///< shown [N]
  Vec3 torque = Vec3::Zero();  ///< shown, about the handle [N·m]
  HapticStatus status = HapticStatus::waiting;
  bool stale = false;        ///< no new constraint set for too long
  bool refused_set = false;  ///< the last one made no sense; nothing is felt of it
  bool force_limited = false, rate_limited = false, energy_limited = false;
  double energy = 0;    ///< that may still be given out [J]
  double residual = 0;  ///< of the friction problem
};

class HapticTick {
 public:
  /// Throws InputError for options out of range.
  HapticTick(const HapticOptions& options, const DeviceLimits& device);

  /// A new set may be taken: the way to the last one is done.
  [[nodiscard]] bool wants_set() const { return share_ >= 1; }
  /// From the last set to this one the force goes gradually, over the time between them, so that it has no kick.
  /// @return false, and nothing is taken, while on the way to the last one
  bool take(const HapticConstraints& set);

  /// @param now  [s], by a clock that never goes back; the first call may have any time
  HapticOutput run(const DeviceState& sample, double now);

  [[nodiscard]] const HapticContact& contact() const { return contact_; }

 private:
  double elapsed_since_last(double now);
  Vector6 offset_of_tool(const Pose& wanted);
  Vector6 wrench_of(const Vector6& offset, double elapsed);
  double freshness(double elapsed);

  HapticOptions options_;
  HapticGuard guard_;
  HapticLimiter limiter_;
  HapticContact contact_, before_;  // the last set, the one before
  HapticOutput out_;
  double share_ = 1;      // of the last set, the rest is the one before's
  double blend_ = 0;      // how long from one to the other [s]
  double since_set_ = 0;  // [s]
  double fresh_share_ = 1;
  bool any_set_ = false, new_set_ = false;
  bool started_ = false;
  double last_time_ = 0;
  Vector6 offset_ = Vector6::Zero(), offset_rate_ = Vector6::Zero();
};

}  // namespace calot
