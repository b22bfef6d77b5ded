#include "calot/device/controls.h"

#include <algorithm>

namespace calot {
namespace {

constexpr std::array<ActionInfo, action_count> actions = {{
    {Action::move_left, "move_left", "move the tip to the left", true},
    {Action::move_right, "move_right", "move the tip to the right", true},
    {Action::move_up, "move_up", "move the tip up", true},
    {Action::move_down, "move_down", "move the tip down", true},
    {Action::deeper, "deeper", "push the tip deeper into the picture", true},
    {Action::nearer, "nearer", "pull the tip nearer", true},
    {Action::roll_left, "roll_left", "roll the instrument to the left", true},
    {Action::roll_right, "roll_right", "roll the instrument to the right", true},
    {Action::close_jaws, "close_jaws", "close the jaws; held longer, they grip harder", true},
    {Action::use, "use", "use the instrument: burn, suck, fire a clip", true},
    {Action::pedal, "pedal", "foot pedal", true},
    {Action::clutch, "clutch", "let the hand move without the instrument", true},
    {Action::ratchet, "ratchet", "lock the jaws, or let them open again", false},
    {Action::next_hand, "next_hand", "take the other hand; this one stays as it is", false},
    {Action::instrument_1, "instrument_1", "take instrument 1", false},
    {static_cast<Action>(15), "instrument_2", "take instrument 2", false},
    {static_cast<Action>(16), "instrument_3", "take instrument 3", false},
    {static_cast<Action>(17), "instrument_4", "take instrument 4", false},
    {static_cast<Action>(18), "instrument_5", "take instrument 5", false},
    {static_cast<Action>(19), "instrument_6", "take instrument 6", false},
    {static_cast<Action>(20), "instrument_7", "take instrument 7", false},
    {static_cast<Action>(21), "instrument_8", "take instrument 8", false},
    {Action::instrument_9, "instrument_9", "take instrument 9", false},
    {Action::next_instrument, "next_instrument", "take the next instrument", false},
    {Action::previous_instrument, "previous_instrument", "take the instrument before", false},
    {Action::pause, "pause", "pause, or go on", false},
    {Action::restart, "restart", "start again", false},
    {Action::spectator, "spectator", "look from outside, or through the endoscope", false},
    {Action::help, "help", "show or hide these keys", false},
    {Action::settings, "settings", "settings", false},
    {Action::picture, "picture", "save a picture", false},
    {Action::quit, "quit", "leave", false},
}};
static_assert(static_cast<int>(Action::instrument_1) == 14);

constexpr bool in_order() {
  for (std::size_t k = 0; k < actions.size(); ++k)
    if (actions[k].action != static_cast<Action>(k)) return false;
  return true;
}
static_assert(in_order());

std::string text_of(const std::vector<Key>& keys) {
  std::string text;
  for (const Key key : keys) {
    std::string name(name_of(key));
    if (name.size() == 1 || (name[0] == 'f' && name.size() <= 3)) name[0] = static_cast<char>(std::toupper(name[0]));
    text += (text.empty() ? "" : ", ") + name;
  }
  return text.empty() ? "–" : text;
}

bool is_instrument(Action action) {
  return action >= Action::instrument_1 && action <= Action::instrument_9;
}

}  // namespace

std::span<const ActionInfo> all_actions() {
  return actions;
}

const ActionInfo& info_of(Action action) {
  return actions[static_cast<std::size_t>(action)];
}

Bindings::Bindings() {
  set(Action::move_left, {Key::left});
  set(Action::move_right, {Key::right});
  set(Action::move_up, {Key::up});
  set(Action::move_down, {Key::down});
  set(Action::deeper, {key_of_letter('w')});
  set(Action::nearer, {key_of_letter('s')});
  set(Action::roll_left, {key_of_letter('q')});
  set(Action::roll_right, {key_of_letter('e')});
  set(Action::close_jaws, {Key::mouse_left, key_of_letter('j')});
  set(Action::use, {Key::mouse_right, key_of_letter('k')});
  set(Action::pedal, {Key::space});
  set(Action::clutch, {Key::mouse_middle, Key::left_shift});
  set(Action::ratchet, {key_of_letter('r')});
  set(Action::next_hand, {Key::tab});
  for (int k = 0; k < 9; ++k)
    set(static_cast<Action>(static_cast<int>(Action::instrument_1) + k), {key_of_digit(k + 1)});
  set(Action::next_instrument, {Key::period});
  set(Action::previous_instrument, {Key::comma});
  set(Action::pause, {Key::escape});
  set(Action::restart, {Key::backspace});
  set(Action::spectator, {key_of_letter('f')});
  set(Action::help, {key_of_letter('h'), function_key(1)});
  set(Action::settings, {key_of_letter('o')});
  set(Action::picture, {key_of_letter('p')});
  set(Action::quit, {function_key(10)});
}

std::optional<Action> Bindings::action_of(Key key) const {
  if (key == Key::none) return {};
  for (std::size_t k = 0; k < keys_.size(); ++k)
    if (std::find(keys_[k].begin(), keys_[k].end(), key) != keys_[k].end()) return static_cast<Action>(k);
  return {};
}

std::vector<BindingRow> Bindings::rows() const {
  std::vector<BindingRow> rows = {{"mouse", "move the tip in the picture"},
                                  {"wheel", "push the tip deeper, or pull it nearer"}};
  std::vector<Key> numbers;
  for (const ActionInfo& info : actions) {
    const std::vector<Key>& keys = keys_of(info.action);
    if (!is_instrument(info.action)) {
      rows.push_back({text_of(keys), std::string(info.words)});
      continue;
    }
    numbers.insert(numbers.end(), keys.begin(), keys.end());
    if (info.action != Action::instrument_9) continue;
    bool plain = numbers.size() == 9;
    for (std::size_t k = 0; plain && k < 9; ++k) plain = numbers[k] == key_of_digit(static_cast<int>(k) + 1);
    rows.push_back({plain ? "1 … 9" : text_of(numbers), "take instrument 1 … 9"});
  }
  return rows;
}

std::vector<BindingRow> bindings() {
  return Bindings().rows();
}

}  // namespace calot
