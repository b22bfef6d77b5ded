#include "calot/sim/haptic_guard.h"

#include <algorithm>
#include <cmath>

#include "calot/sim/haptic_twist.h"

namespace calot {
namespace {

bool is_sound(const DeviceState& sample) {
  const double norm = sample.handle.rotation.norm();
  return std::isfinite(sample.time) && is_finite(sample.handle) && norm > 0.9 && norm < 1.1 &&
         sample.handle.position.cwiseAbs().maxCoeff() < 1e3 && std::isfinite(sample.opening) &&
         std::isfinite(sample.grip);
}

/// Shortens a vector at a speed; slower at the end.
Vec3 shortened(const Vec3& vector, double speed, double elapsed) {
  constexpr double ending = 0.02;  // s
  const double length = vector.norm();
  if (length < 1e-6) return Vec3::Zero();
  const double step = elapsed * std::min(speed, length / ending + 1e-3 * speed);
  return step >= length ? Vec3(Vec3::Zero()) : Vec3((1 - step / length) * vector);
}

}  // namespace

std::string_view name_of(HapticStatus status) {
  switch (status) {
    case HapticStatus::waiting:
      return "waiting for the device";
    case HapticStatus::working:
      return "working";
    case HapticStatus::recovering:
      return "recovering";
    case HapticStatus::not_a_number:
      return "holding: the device sends numbers that are none";
    case HapticStatus::jump:
      return "holding: the device jumps";
    case HapticStatus::silent:
      return "holding: the device sends nothing";
    case HapticStatus::disconnected:
      return "holding: the device is disconnected";
  }
  return "";
}

HapticStatus HapticGuard::fault_of(const DeviceState& sample, double now) const {
  if (!sample.connected) return HapticStatus::disconnected;
  if (!is_sound(sample)) return HapticStatus::not_a_number;
  if (started_ && sample.time == sample_time_)
    return now - fresh_ > options_.silence ? HapticStatus::silent : HapticStatus::working;
  if (!seen_) return HapticStatus::working;
  const Vector6 motion = twist_between(raw_, sample.handle);
  const bool jumped =
      motion.head<3>().norm() > options_.largest_jump || motion.tail<3>().norm() > options_.largest_turn;
  return jumped ? HapticStatus::jump : HapticStatus::working;
}

void HapticGuard::hold(HapticStatus fault) {
  mode_ = Mode::holding;
  good_ = 0;
  // After a gap nothing says how far the handle may have come.
  if (fault == HapticStatus::silent || fault == HapticStatus::disconnected) seen_ = false;
  if (out_.has_pose) out_.status = fault;
  out_.pedal = out_.button = pedal_armed_ = button_armed_ = false;
}

void HapticGuard::glide(double elapsed) {
  behind_.head<3>() = shortened(behind_.head<3>(), options_.glide_speed, elapsed);
  behind_.tail<3>() = shortened(behind_.tail<3>(), options_.glide_turn, elapsed);
  out_.handle = moved(raw_, behind_);
  if (behind_.isZero(0)) mode_ = Mode::following;
}

void HapticGuard::follow(const DeviceState& sample, double elapsed) {
  good_ += elapsed;
  if (mode_ == Mode::holding && good_ >= options_.settle) {
    mode_ = Mode::gliding;
    behind_ = out_.has_pose ? twist_between(raw_, out_.handle) : Vector6(Vector6::Zero());
    out_.has_pose = true;
    out_.status = HapticStatus::recovering;
  }
  if (mode_ == Mode::gliding) glide(elapsed);
  if (mode_ != Mode::following) return;
  out_.handle = raw_;
  out_.opening = std::clamp(sample.opening, 0.0, M_PI);
  out_.grip = std::max(sample.grip, 0.0);
  pedal_armed_ = pedal_armed_ || !sample.pedal;
  button_armed_ = button_armed_ || !sample.button;
  out_.pedal = sample.pedal && pedal_armed_;
  out_.button = sample.button && button_armed_;
}

GuardedInput HapticGuard::check(const DeviceState& sample, double now, double elapsed) {
  out_.motion.setZero();
  const HapticStatus fault = fault_of(sample, now);
  const bool fresh = sample.connected && is_sound(sample) && (!started_ || sample.time != sample_time_);
  if (fresh) {
    Pose handle = sample.handle;
    handle.rotation.normalize();
    if (seen_ && fault == HapticStatus::working) out_.motion = twist_between(raw_, handle);
    raw_ = handle;
    sample_time_ = sample.time;
    fresh_ = now;
    seen_ = started_ = true;
  }
  if (fault == HapticStatus::working && seen_)
    follow(sample, elapsed);
  else if (fault != HapticStatus::working)
    hold(fault);
  const double step = elapsed / options_.fade;
  out_.share = std::clamp(out_.share + (mode_ == Mode::following ? step : -step), 0.0, 1.0);
  if (mode_ == Mode::following) out_.status = out_.share < 1 ? HapticStatus::recovering : HapticStatus::working;
  return out_;
}

}  // namespace calot
