#include "calot/device/desktop.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot {

Desktop::Desktop(ControlSettings settings, int hands, const DeviceClock& clock) : settings_(std::move(settings)) {
  if (hands < 1 || hands > 4) throw InputError("mouse", std::to_string(hands) + " hands", "give 1 to 4");
  for (int k = 0; k < hands; ++k) {
    hands_.push_back(std::make_unique<HandState>());
    hands_.back()->device = std::make_unique<SteeredHand>(clock);
  }
}

Desktop::HandState& Desktop::at(int hand) {
  if (hand < 0 || hand >= hands()) throw InputError("mouse", "there is no hand " + std::to_string(hand));
  return *hands_[static_cast<std::size_t>(hand)];
}

HandControls Desktop::controls(int hand) const {
  const HandState& state = *hands_.at(static_cast<std::size_t>(hand));
  return {state.clutch, state.ratchet};
}

void Desktop::use(ControlSettings settings) {
  let_go();
  settings_ = std::move(settings);
}

void Desktop::look(const PictureView& view) {
  view_ = view;
  steer();
}

void Desktop::hold(int hand, const InstrumentGeometry& geometry) {
  HandState& state = at(hand);
  state.kind = geometry.kind;
  state.ratchet = false;
  state.device->wish().closing = state.device->wish().frozen = false;
  state.device->hold(geometry);
  steer();
}

bool Desktop::is_held(Action action) const {
  const std::vector<Key>& keys = settings_.bindings.keys_of(action);
  return std::any_of(keys.begin(), keys.end(), [&](Key key) { return down_[static_cast<std::size_t>(key)]; });
}

/// Brings the active hand's wish to the keys that are down.
void Desktop::steer() {
  HandState& hand = at(active_);
  const auto way = [&](Action plus, Action minus) {
    return (is_held(plus) ? 1.0 : 0.0) - (is_held(minus) ? 1.0 : 0.0);
  };
  const Vec3 in_picture(way(Action::move_right, Action::move_left), way(Action::move_up, Action::move_down),
                        way(Action::nearer, Action::deeper));
  const bool used = is_held(Action::use), fires = hand.kind == InstrumentKind::clip_applier;
  const bool pedal = is_held(Action::pedal) || (used && !fires), button = used && fires;
  SteeringWish& wish = hand.device->wish();
  wish.velocity = settings_.key_speed * (view_.axes * in_picture);
  wish.roll_rate = settings_.roll_speed * way(Action::roll_right, Action::roll_left);
  wish.pedal_presses += pedal && !wish.pedal ? 1 : 0;
  wish.button_presses += button && !wish.button ? 1 : 0;
  wish.pedal = pedal;
  wish.button = button;
  hand.clutch = is_held(Action::clutch);
  hand.device->publish();
}

/// A hand that is left while its jaws are closed keeps them so, as firm as they are; the next press takes over.
void Desktop::close_or_open(bool down) {
  if (down) {
    closer_ = active_;
    at(active_).device->wish().frozen = false;
  } else if (closer_ != active_) {
    return;
  }
  at(active_).device->wish().closing = down;
}

void Desktop::take(int hand) {
  (void)at(hand);
  if (hand == active_) return;
  SteeringWish& left = at(active_).device->wish();
  left.velocity.setZero();
  left.roll_rate = 0;
  left.pedal = left.button = false;
  left.frozen = left.closing;
  at(active_).clutch = false;
  at(active_).device->publish();
  active_ = hand;
  if (closer_ == active_ && is_held(Action::close_jaws)) at(active_).device->wish().frozen = false;
  steer();
}

void Desktop::press(Action action) {
  if (action == Action::next_hand) take((active_ + 1) % hands());
  if (action == Action::ratchet) at(active_).ratchet = !at(active_).ratchet;
}

std::optional<Action> Desktop::key(const KeyEvent& event) {
  const auto index = static_cast<std::size_t>(event.key);
  if (event.key == Key::none || index >= down_.size() || down_[index] == event.down) return {};
  const std::optional<Action> action = settings_.bindings.action_of(event.key);
  const bool was = action && is_held(*action);
  down_[index] = event.down;
  if (!action) return {};
  const bool is = is_held(*action), changed = is != was;
  if (*action == Action::close_jaws && changed) close_or_open(is);
  if (info_of(*action).held) {
    steer();
    return {};
  }
  if (!is || !changed) return {};
  press(*action);
  return action;
}

void Desktop::pointer(const PointerEvent& event) {
  if (!std::isfinite(event.right) || !std::isfinite(event.down) || !std::isfinite(event.wheel)) return;
  const double scale = settings_.pointer_speed * view_.height;
  const Vec3 in_picture(scale * event.right, -scale * event.down, -settings_.wheel_step * event.wheel);
  SteeredHand& hand = *at(active_).device;
  hand.wish().moved += view_.axes * in_picture;
  hand.publish();
}

// Tissue in the jaws stays there: the next press of the closing key takes over.
void Desktop::let_go() {
  if (is_held(Action::close_jaws) && closer_ == active_) at(active_).device->wish().frozen = true;
  down_.reset();
  steer();
}

}  // namespace calot
