#include "calot/sim/haptic_limiter.h"

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

/// Shortens a vector to a length. @return whether it was longer
bool shorten(Eigen::Ref<Vec3> vector, double longest) {
  const double length = vector.stableNorm();
  if (length <= longest) return false;
  vector *= longest / length;
  // Rounding must not leave it a bit too long.
  while (vector.norm() > longest) vector *= 1 - 1e-15;
  return true;
}

/// Takes the share 1 − keep of what `force` gives out along `velocity` away.
bool take_away(Eigen::Ref<Vec3> force, const Vec3& velocity, double keep) {
  const double power = force.dot(velocity), square = velocity.squaredNorm();
  if (power <= 0 || square < 1e-12) return false;
  force -= (1 - keep) * power / square * velocity;
  return true;
}

}  // namespace

HapticLimiter::HapticLimiter(const LimiterOptions& options, double device_force, double device_torque)
    : options_(options), account_(options.reserve) {
  options_.max_force = std::min(options.max_force, device_force);
  options_.max_torque = std::min(options.max_torque, device_torque);
}

void HapticLimiter::count(const Vector6& motion, double elapsed) {
  account_ = std::min(account_ - shown_.dot(motion), options_.bank);
  if (account_ < options_.reserve) account_ = std::min(options_.reserve, account_ + elapsed * options_.refill);
  constexpr double smoothing = 2e-3;  // s; samples are rounded to a device's resolution
  velocity_ += elapsed / (elapsed + smoothing) * (motion / elapsed - velocity_);
}

bool HapticLimiter::spend_less(Vector6& wrench) const {
  const double keep = std::clamp(2 * account_ / options_.reserve, 0.0, 1.0);
  if (keep == 1) return false;
  const bool force = take_away(wrench.head<3>(), velocity_.head<3>(), keep);
  const bool torque = take_away(wrench.tail<3>(), velocity_.tail<3>(), keep);
  return force || torque;
}

HapticLimiter::Answer HapticLimiter::limit(Vector6 wrench, const Vector6& motion, double elapsed) {
  count(motion, elapsed);
  Answer answer;
  if (!wrench.allFinite()) wrench.setZero();
  answer.energy_limited = spend_less(wrench);
  answer.force_limited = shorten(wrench.head<3>(), options_.max_force);
  answer.force_limited |= shorten(wrench.tail<3>(), options_.max_torque);
  Vector6 change = wrench - shown_;
  answer.rate_limited = shorten(change.head<3>(), options_.force_rate * elapsed);
  answer.rate_limited |= shorten(change.tail<3>(), options_.torque_rate * elapsed);
  shown_ += change;
  // Within both balls, so on the line between them too; but for the last bit.
  shorten(shown_.head<3>(), options_.max_force);
  shorten(shown_.tail<3>(), options_.max_torque);
  answer.wrench = shown_;
  return answer;
}

}  // namespace calot
