#include "calot/sim/haptic_tick.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calot/base/error.h"
#include "calot/sim/haptic_twist.h"

namespace calot {
namespace {

void need(bool fine, const std::string& what, const std::string& what_to_do) {
  if (!fine) throw InputError("haptic options", what, what_to_do);
}

/// Comparisons are written so that NaN fails them.
HapticOptions checked(HapticOptions options, const DeviceLimits& device) {
  const LimiterOptions& limits = options.limits;
  need(options.period >= 1e-4 && options.period <= 0.01, "the period is out of range", "give 0.0001 to 0.01 s");
  need(device.max_force >= 0 && device.max_torque >= 0 && device.max_stiffness > 0,
       "the device's limits are negative or no numbers", "let its driver state them");
  options.coupling.stiffness = std::min(options.coupling.stiffness, device.max_stiffness);
  need(options.coupling.stiffness > 0 && options.coupling.turning_stiffness > 0, "the coupling has no stiffness",
       "give more than 0");
  need(options.damping >= 0 && options.turning_damping >= 0, "the coupling's damping is negative", "give 0 or more");
  need(options.iterations >= 1 && options.first_iterations >= 1, "the solver has no iterations", "give 1 or more");
  need(options.world_period > 0 && options.longest_blend > 0 && options.stale_after > 0, "a time is not above 0",
       "give seconds above 0");
  need(limits.max_force >= 0 && limits.max_torque >= 0 && limits.force_rate > 0 && limits.torque_rate > 0,
       "a limit of the force is negative or no number", "give a number above 0");
  need(limits.reserve > 0 && limits.bank >= limits.reserve && limits.refill >= 0, "the energy's limits make no sense",
       "give 0 < reserve ≤ bank and refill ≥ 0");
  const GuardOptions& guard = options.guard;
  for (const double value :
       {guard.largest_jump, guard.largest_turn, guard.silence, guard.fade, guard.glide_speed, guard.glide_turn})
    need(value > 0, "a limit of the guard is not above 0", "give a number above 0");
  need(guard.settle >= 0, "the guard's settling time is negative", "give 0 or more seconds");
  need(is_finite(options.tool_in_handle), "the tool's place in the handle is no number", "give a pose");
  return options;
}

}  // namespace

HapticTick::HapticTick(const HapticOptions& options, const DeviceLimits& device)
    : options_(checked(options, device)),
      guard_(options_.guard),
      limiter_(options_.limits, device.max_force, device.max_torque) {}

bool HapticTick::take(const HapticConstraints& set) {
  if (!wants_set()) return false;
  std::swap(contact_, before_);
  out_.refused_set = !contact_.take(set, options_.coupling);
  out_.step = set.step;
  blend_ = std::clamp(any_set_ ? since_set_ : options_.world_period, options_.period, options_.longest_blend);
  share_ = since_set_ = 0;
  any_set_ = new_set_ = true;
  return true;
}

double HapticTick::elapsed_since_last(double now) {
  const double elapsed = started_ ? now - last_time_ : options_.period;
  started_ = true;
  last_time_ = now;
  // A thread that slept too long makes one long tick, not a leap.
  return std::isfinite(elapsed) ? std::clamp(elapsed, 0.2 * options_.period, 10 * options_.period) : options_.period;
}

Vector6 HapticTick::offset_of_tool(const Pose& wanted) {
  const auto answer = contact_.solve(wanted, new_set_ ? options_.first_iterations : options_.iterations);
  new_set_ = false;
  out_.residual = answer.residual;
  if (share_ >= 1) return answer.offset;
  const auto before = before_.solve(wanted, options_.iterations);
  out_.residual = std::max(out_.residual, before.residual);
  return share_ * answer.offset + (1 - share_) * before.offset;
}

Vector6 HapticTick::wrench_of(const Vector6& offset, double elapsed) {
  constexpr double smoothing = 5e-3;  // s
  offset_rate_ += elapsed / (elapsed + smoothing) * ((offset - offset_) / elapsed - offset_rate_);
  offset_ = offset;
  Vector6 wrench;
  wrench << options_.coupling.stiffness * offset.head<3>() + options_.damping * offset_rate_.head<3>(),
      options_.coupling.turning_stiffness * offset.tail<3>() + options_.turning_damping * offset_rate_.tail<3>();
  return wrench;
}

double HapticTick::freshness(double elapsed) {
  out_.stale = any_set_ && since_set_ > options_.stale_after;
  const double step = elapsed / options_.guard.fade;
  return fresh_share_ = std::clamp(fresh_share_ + (out_.stale ? -step : step), 0.0, 1.0);
}

HapticOutput HapticTick::run(const DeviceState& sample, double now) {
  const double elapsed = elapsed_since_last(now);
  const GuardedInput input = guard_.check(sample, now, elapsed);
  ++out_.tick;
  since_set_ += elapsed;
  if (share_ < 1) share_ = std::min(1.0, share_ + elapsed / blend_);
  out_.status = input.status;
  out_.has_pose = input.has_pose;
  Vector6 wrench = Vector6::Zero();
  if (input.has_pose) {
    const Pose wanted = input.handle * options_.tool_in_handle;
    const Vector6 offset = offset_of_tool(wanted);
    wrench = input.share * freshness(elapsed) * wrench_of(offset, elapsed);
    const Vec3 lever = wanted.position - input.handle.position;
    wrench.tail<3>() += lever.cross(Vec3(wrench.head<3>()));
    out_.input = {moved(wanted, offset), input.opening, input.grip, input.pedal, input.button};
  }
  const HapticLimiter::Answer limited = limiter_.limit(wrench, input.motion, elapsed);
  out_.force = limited.wrench.head<3>();
  out_.torque = limited.wrench.tail<3>();
  out_.force_limited = limited.force_limited;
  out_.rate_limited = limited.rate_limited;
  out_.energy_limited = limited.energy_limited;
  out_.energy = limiter_.account();
  return out_;
}

}  // namespace calot
