#include "calot/device/steered_hand.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace calot {
namespace {

constexpr double shortest_press = 0.05;   // s
constexpr double closing_time = 0.25;     // s, of fully open jaws
constexpr double first_grip = 0.25;       // of the usual one, when the jaws have closed
constexpr double usual_after = 0.6;       // s of holding on until the grip is the usual one
constexpr double strongest_after = 10.0;  // s from there to all that the instrument can
constexpr double trigger_closes = 0.6;    // share of a trigger's way

}  // namespace

DeviceClock steady_clock() {
  return [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); };
}

SteeredHand::SteeredHand(DeviceClock clock) : clock_(std::move(clock)) {
  publish();
}

void SteeredHand::publish() {
  wishes_.writing() = wish_;
  wishes_.publish();
}

void SteeredHand::hold(const InstrumentGeometry& geometry) {
  wish_.max_opening = geometry.max_opening;
  wish_.usual_grip = geometry.usual_grip;
  wish_.max_grip = geometry.max_grip;
  publish();
}

bool SteeredHand::Press::at(bool down, std::uint32_t presses, double now) {
  if (presses != seen) until = now + shortest_press;
  seen = presses;
  return down || now < until;
}

void SteeredHand::move_fingers(const SteeringWish& wish, double elapsed) {
  if (!wish.frozen) {
    const double step = elapsed / closing_time;
    closed_ = std::clamp(closed_ + (wish.closing ? step : -step), 0.0, 1.0);
    if (!wish.closing || closed_ < 1) {
      grip_ = 0;
    } else {
      const double least = std::min(first_grip * wish.usual_grip, wish.max_grip);
      const double rate = grip_ < wish.usual_grip ? (1 - first_grip) * wish.usual_grip / usual_after
                                                  : (wish.max_grip - wish.usual_grip) / strongest_after;
      grip_ = std::min(std::max(grip_ + std::max(rate, 0.0) * elapsed, least), wish.max_grip);
    }
  }
  const double pulled = std::clamp(wish.trigger, 0.0, 1.0);
  const double shut = std::max(closed_, std::min(1.0, pulled / trigger_closes));
  const double squeeze = std::max(0.0, pulled - trigger_closes) / (1 - trigger_closes);
  state_.opening = wish.max_opening * (1 - shut);
  state_.grip = std::max(grip_, squeeze * wish.max_grip);
}

DeviceState SteeredHand::read() noexcept {
  constexpr double longest = 0.1;  // s; nobody steered through a longer gap
  const double now = clock_();
  const double elapsed = started_ ? std::clamp(now - state_.time, 0.0, longest) : 0.0;
  started_ = true;
  (void)wishes_.fetch();
  const SteeringWish& wish = wishes_.reading();
  state_.time = now;
  state_.connected = wish.connected;
  state_.handle.position += wish.moved - seen_ + elapsed * wish.velocity;
  seen_ = wish.moved;
  roll_ = std::remainder(roll_ + elapsed * wish.roll_rate, 2 * M_PI);
  state_.handle.rotation = Eigen::AngleAxisd(roll_, Vec3::UnitZ());
  move_fingers(wish, elapsed);
  state_.pedal = pedal_.at(wish.pedal, wish.pedal_presses, now);
  state_.button = button_.at(wish.button, wish.button_presses, now);
  return state_;
}

}  // namespace calot
