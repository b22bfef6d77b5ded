#include "calot/device/gamepads.h"

#include <SDL.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calot/base/error.h"

namespace calot {
namespace {

struct PadButton {
  SDL_GameControllerButton button;
  Action action;
  const char* name;
};
constexpr PadButton pad_buttons[] = {
    {SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, Action::use, "right shoulder"},
    {SDL_CONTROLLER_BUTTON_LEFTSHOULDER, Action::pedal, "left shoulder"},
    {SDL_CONTROLLER_BUTTON_X, Action::clutch, "X"},
    {SDL_CONTROLLER_BUTTON_A, Action::ratchet, "A"},
    {SDL_CONTROLLER_BUTTON_Y, Action::next_hand, "Y"},
    {SDL_CONTROLLER_BUTTON_DPAD_RIGHT, Action::next_instrument, "right on the cross"},
    {SDL_CONTROLLER_BUTTON_DPAD_LEFT, Action::previous_instrument, "left on the cross"},
    {SDL_CONTROLLER_BUTTON_DPAD_UP, Action::spectator, "up on the cross"},
    {SDL_CONTROLLER_BUTTON_DPAD_DOWN, Action::picture, "down on the cross"},
    {SDL_CONTROLLER_BUTTON_START, Action::pause, "start"},
    {SDL_CONTROLLER_BUTTON_BACK, Action::help, "back"},
};

std::uint32_t buttons_of(SDL_GameController* pad) {
  std::uint32_t down = 0;
  for (const PadButton& b : pad_buttons)
    if (SDL_GameControllerGetButton(pad, b.button) != 0) down |= 1U << b.button;
  return down;
}

double axis_of(SDL_GameController* pad, SDL_GameControllerAxis axis) {
  return std::clamp(SDL_GameControllerGetAxis(pad, axis) / 32767.0, -1.0, 1.0);
}

bool is_down(std::uint32_t buttons, Action action) {
  return std::any_of(std::begin(pad_buttons), std::end(pad_buttons),
                     [&](const PadButton& b) { return b.action == action && (buttons >> b.button & 1U) != 0; });
}

}  // namespace

std::vector<BindingRow> gamepad_rows() {
  std::vector<BindingRow> rows = {{"left stick", "tilt: move the tip in the picture"},
                                  {"right stick", "up and down: deeper and nearer; sideways: roll"},
                                  {"left trigger", "push the tip deeper"},
                                  {"right trigger", "close the jaws; further, they grip harder"}};
  for (const PadButton& b : pad_buttons) rows.push_back({b.name, std::string(info_of(b.action).words)});
  return rows;
}

Eigen::Vector2d stick_way(double x, double y, double dead_zone) {
  const double way = std::min(std::hypot(x, y), 1.0);
  if (!(way > dead_zone)) return Eigen::Vector2d::Zero();
  const double beyond = (way - dead_zone) / (1 - dead_zone);
  return beyond * beyond * Eigen::Vector2d(x, y).normalized();
}

Gamepads::Gamepads(const ControlSettings& settings, int hands, const DeviceClock& clock) : settings_(settings) {
  if (hands < 1 || hands > 4) throw InputError("gamepad", std::to_string(hands) + " hands", "give 1 to 4");
  SDL_SetMainReady();
  // Without it a pad says nothing while the window has no focus, as under a display without a window manager.
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0)
    throw FailedError("gamepad", std::string("gamepads can't be used: ") + SDL_GetError(), "use the mouse");
  for (int k = 0; k < hands; ++k) {
    slots_.push_back(std::make_unique<Slot>());
    slots_.back()->device = std::make_unique<SteeredHand>(clock);
    slots_.back()->device->wish().connected = false;
    slots_.back()->device->publish();
  }
  (void)poll();
}

Gamepads::~Gamepads() {
  for (const auto& slot : slots_)
    if (slot->pad != nullptr) SDL_GameControllerClose(slot->pad);
  SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
}

Gamepads::Slot& Gamepads::at(int hand) {
  if (hand < 0 || hand >= static_cast<int>(slots_.size()))
    throw InputError("gamepad", "there is no hand " + std::to_string(hand));
  return *slots_[static_cast<std::size_t>(hand)];
}

HandControls Gamepads::controls(int hand) const {
  const Slot& slot = *slots_.at(static_cast<std::size_t>(hand));
  return {slot.clutch, slot.ratchet};
}

std::vector<std::string> Gamepads::names() const {
  std::vector<std::string> names;
  for (const auto& slot : slots_) {
    const char* name = slot->pad == nullptr ? "" : SDL_GameControllerName(slot->pad);
    names.emplace_back(name == nullptr ? "gamepad" : name);
  }
  return names;
}

void Gamepads::hold(int hand, const InstrumentGeometry& geometry) {
  Slot& slot = at(hand);
  slot.kind = geometry.kind;
  slot.ratchet = false;
  slot.device->hold(geometry);
}

/// A hand that is left stays as it is, its jaws too.
void Gamepads::park(Slot& hand) {
  SteeringWish& wish = hand.device->wish();
  wish.velocity.setZero();
  wish.roll_rate = 0;
  wish.pedal = wish.button = false;
  hand.clutch = false;
  hand.kept = wish.trigger;
  hand.device->publish();
}

void Gamepads::take(int hand) {
  (void)at(hand);
  if (hand == active_) return;
  park(at(active_));
  active_ = hand;
}

/// The slot whose gamepad steers a hand.
Gamepads::Slot& Gamepads::slot_of_hand(int hand) {
  if (several_) return at(hand);
  const auto found = std::find_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->pad != nullptr; });
  return found == slots_.end() ? at(0) : **found;
}

void Gamepads::find_pads() {
  for (const auto& slot : slots_) {
    if (slot->pad == nullptr || SDL_GameControllerGetAttached(slot->pad) == SDL_TRUE) continue;
    SDL_GameControllerClose(slot->pad);
    slot->pad = nullptr;
    slot->buttons = 0;
  }
  for (int k = 0; k < SDL_NumJoysticks(); ++k) {
    if (SDL_IsGameController(k) == SDL_FALSE) continue;
    SDL_GameController* known = SDL_GameControllerFromInstanceID(SDL_JoystickGetDeviceInstanceID(k));
    const auto has = [&](const auto& slot) { return slot->pad != nullptr && slot->pad == known; };
    if (std::any_of(slots_.begin(), slots_.end(), has)) continue;
    const auto free = std::find_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->pad == nullptr; });
    if (free != slots_.end()) (*free)->pad = SDL_GameControllerOpen(k);
  }
  const auto pads = std::count_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->pad != nullptr; });
  if (pads > 1) several_ = true;
}

void Gamepads::steer(Slot& hand, const Slot& pad) {
  const double dead = settings_.pad_dead_zone, deepest = axis_of(pad.pad, SDL_CONTROLLER_AXIS_TRIGGERLEFT);
  const Eigen::Vector2d left =
      stick_way(axis_of(pad.pad, SDL_CONTROLLER_AXIS_LEFTX), axis_of(pad.pad, SDL_CONTROLLER_AXIS_LEFTY), dead);
  const Eigen::Vector2d right =
      stick_way(axis_of(pad.pad, SDL_CONTROLLER_AXIS_RIGHTX), axis_of(pad.pad, SDL_CONTROLLER_AXIS_RIGHTY), dead);
  const double push = std::clamp(stick_way(deepest, 0, dead).x() - right.y(), -1.0, 1.0);
  const double sign = settings_.pad_fulcrum ? -1 : 1;
  const bool used = is_down(pad.buttons, Action::use), fires = hand.kind == InstrumentKind::clip_applier;
  const bool pedal = is_down(pad.buttons, Action::pedal) || (used && !fires), button = used && fires;
  SteeringWish& wish = hand.device->wish();
  wish.velocity = settings_.pad_speed * (view_.axes * Vec3(sign * left.x(), -sign * left.y(), -push));
  wish.roll_rate = settings_.roll_speed * right.x();
  const double trigger = axis_of(pad.pad, SDL_CONTROLLER_AXIS_TRIGGERRIGHT);
  if (trigger >= hand.kept) hand.kept = 0;
  wish.trigger = std::max(trigger, hand.kept);
  wish.pedal_presses += pedal && !wish.pedal ? 1 : 0;
  wish.button_presses += button && !wish.button ? 1 : 0;
  wish.pedal = pedal;
  wish.button = button;
  hand.clutch = is_down(pad.buttons, Action::clutch);
}

void Gamepads::press(Slot& hand, int button, std::vector<Action>& pressed) {
  const auto found = std::find_if(std::begin(pad_buttons), std::end(pad_buttons),
                                  [&](const PadButton& b) { return b.button == button; });
  if (found == std::end(pad_buttons) || info_of(found->action).held) return;
  if (found->action == Action::ratchet) hand.ratchet = !hand.ratchet;
  if (found->action == Action::next_hand) {
    // With a gamepad for each there is nothing to change over; a single one that is left serves all.
    const auto pads =
        std::count_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->pad != nullptr; });
    if (pads > 1) return;
    several_ = false;
    take((active_ + 1) % static_cast<int>(slots_.size()));
  }
  pressed.push_back(found->action);
}

std::vector<Action> Gamepads::poll() {
  SDL_GameControllerUpdate();
  find_pads();
  std::vector<Action> pressed;
  for (int hand = 0; hand < static_cast<int>(slots_.size()); ++hand) {
    Slot& slot = slot_of_hand(hand);
    at(hand).device->wish().connected = slot.pad != nullptr;
    if (slot.pad == nullptr) {
      park(at(hand));
      continue;
    }
    if (!several_ && hand != active_) {
      at(hand).device->publish();
      continue;
    }
    const std::uint32_t before = std::exchange(slot.buttons, buttons_of(slot.pad));
    for (const PadButton& b : pad_buttons)
      if ((slot.buttons & ~before) >> b.button & 1U) press(at(hand), b.button, pressed);
    if (several_ || hand == active_) steer(at(hand), slot);
    at(hand).device->publish();
  }
  return pressed;
}

}  // namespace calot
