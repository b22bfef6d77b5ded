#include "calot/sim/instrument_guard.h"

#include <algorithm>
#include <cmath>

#include "calot/sim/instrument_state.h"

namespace calot {
namespace {

bool finite(const InstrumentInput& input) {
  return input.pose.position.allFinite() && input.pose.rotation.coeffs().allFinite() && std::isfinite(input.opening) &&
         std::isfinite(input.grip);
}

/// Angle between two rotations, 0 … π.
double turn_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond d = a.conjugate() * b;
  return 2 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

double towards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

}  // namespace

std::string_view words_of(InputStatus status) {
  switch (status) {
    case InputStatus::good:
      return "good";
    case InputStatus::missing:
      return "the device sends nothing; the instrument holds";
    case InputStatus::not_a_number:
      return "the device sends what is no number; the instrument holds";
    case InputStatus::not_a_rotation:
      return "the device sends a rotation that is none; the instrument holds";
    case InputStatus::jumped:
      return "the device jumped; the instrument holds";
    case InputStatus::opening_out_of_range:
      return "the device opens the jaws further than they go; the instrument holds";
    case InputStatus::grip_out_of_range:
      return "the device asks for a grip out of range; the instrument holds";
    case InputStatus::recovering:
      return "the device is back; the instrument catches up";
  }
  return "";
}

InstrumentGuard::InstrumentGuard(const InstrumentGeometry& geometry, const InstrumentInput& start,
                                 const GuardLimits& limits)
    : limits_(limits),
      max_opening_(geometry.max_opening),
      max_grip_(geometry.max_grip),
      accepted_(start),
      heard_(start) {}

InputStatus InstrumentGuard::judge(const std::optional<InstrumentInput>& input) const {
  if (!input) return InputStatus::missing;
  if (!finite(*input)) return InputStatus::not_a_number;
  if (std::abs(input->pose.rotation.norm() - 1) > 0.01) return InputStatus::not_a_rotation;
  const double tiny = 1e-9;
  if (max_opening_ > 0) {  // without jaws nobody looks at these
    if (input->opening < -tiny || input->opening > max_opening_ + tiny) return InputStatus::opening_out_of_range;
    if (input->grip < 0 || input->grip > max_grip_ + tiny) return InputStatus::grip_out_of_range;
  }
  if ((input->pose.position - heard_.pose.position).norm() >= limits_.jump ||
      turn_between(heard_.pose.rotation, input->pose.rotation.normalized()) >= limits_.turn)
    return InputStatus::jumped;
  return InputStatus::good;
}

/// Towards the input, no faster than the limits; there at once when it is near enough.
void InstrumentGuard::approach(const InstrumentInput& input, double step) {
  const Vec3 way = input.pose.position - accepted_.pose.position;
  const double far = way.norm(), turn = turn_between(accepted_.pose.rotation, input.pose.rotation);
  const double share = std::min(
      {1.0, far > 0 ? limits_.recovery_speed * step / far : 1.0, turn > 0 ? limits_.recovery_turn * step / turn : 1.0});
  accepted_.pose.position = share < 1 ? Vec3(accepted_.pose.position + share * way) : input.pose.position;
  accepted_.pose.rotation =
      share < 1 ? accepted_.pose.rotation.slerp(share, input.pose.rotation).normalized() : input.pose.rotation;
  accepted_.opening = towards(accepted_.opening, input.opening, limits_.recovery_opening * step);
  accepted_.grip = input.grip;
  const bool there = share >= 1 && accepted_.opening == input.opening;
  status_ = there ? InputStatus::good : InputStatus::recovering;
  accepted_.energy = there && input.energy;  // no pedal counts before the tip is where the hand is
  accepted_.fire = there && input.fire;
}

const InstrumentInput& InstrumentGuard::accept(const std::optional<InstrumentInput>& input, double step) {
  const InputStatus judged = judge(input);
  // A pose that jumped is still where the device is now: the next one is measured from there.
  const bool sound_pose = judged == InputStatus::good || judged == InputStatus::jumped;
  if (sound_pose) {
    heard_ = *input;
    heard_.pose.rotation.normalize();
  }
  if (judged != InputStatus::good) {
    status_ = judged;
    good_in_a_row_ = 0;
    accepted_.energy = accepted_.fire = false;
    return accepted_;
  }
  InstrumentInput wanted = heard_;
  wanted.opening = std::clamp(wanted.opening, 0.0, max_opening_);
  wanted.grip = std::min(wanted.grip, max_grip_);
  if (status_ == InputStatus::good) {
    accepted_ = wanted;
    return accepted_;
  }
  if (++good_in_a_row_ >= limits_.trust_after) approach(wanted, step);
  return accepted_;
}

void InstrumentGuard::append_state(std::string& bytes) const {
  for (const InstrumentInput* input : {&accepted_, &heard_}) {
    detail::append_bytes(bytes, input->pose);
    detail::append_bytes(bytes, input->opening);
    detail::append_bytes(bytes, input->grip);
    detail::append_bytes(bytes, input->energy);
    detail::append_bytes(bytes, input->fire);
  }
  detail::append_bytes(bytes, status_);
  detail::append_bytes(bytes, good_in_a_row_);
}

}  // namespace calot
