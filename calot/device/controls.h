// What keys and buttons do: one table for the input, the help overlay and the file that changes it.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calot/device/keys.h"

namespace calot {

enum class Action : std::uint8_t {
  // of the active hand, while held
  move_left,
  move_right,
  move_up,
  move_down,
  deeper,
  nearer,
  roll_left,
  roll_right,
  close_jaws,
  use,
  pedal,
  clutch,
  // when pressed
  ratchet,
  next_hand,
  instrument_1,
  instrument_9 = instrument_1 + 8,
  next_instrument,
  previous_instrument,
  pause,
  restart,
  spectator,
  help,
  settings,
  picture,
  quit,
};
constexpr int action_count = static_cast<int>(Action::quit) + 1;

struct ActionInfo {
  Action action;
  std::string_view name;   ///< in files: "close_jaws"
  std::string_view words;  ///< for people: "close the jaws; longer is firmer"
  bool held;               ///< lasts as long as its key is down
};
/// Every action, in the order of the enum.
std::span<const ActionInfo> all_actions();
const ActionInfo& info_of(Action action);

/// A line of the help overlay.
struct BindingRow {
  std::string keys, words;
};

/// Which keys do what; each key does one thing.
class Bindings {
 public:
  /// The usual ones.
  Bindings();
  [[nodiscard]] std::optional<Action> action_of(Key key) const;
  [[nodiscard]] const std::vector<Key>& keys_of(Action action) const { return keys_[static_cast<std::size_t>(action)]; }
  /// What was bound to the action before is free.
  void set(Action action, std::vector<Key> keys) { keys_[static_cast<std::size_t>(action)] = std::move(keys); }
  /// The whole table for people, with the mouse's motions; instruments share one line.
  [[nodiscard]] std::vector<BindingRow> rows() const;

 private:
  std::array<std::vector<Key>, action_count> keys_;
};

struct ControlSettings {
  Bindings bindings;
  double pointer_speed = 1;     ///< of the tip in the picture, per that of the mouse
  double wheel_step = 5e-3;     ///< of depth, a notch [m]
  double key_speed = 0.05;      ///< of the tip by held keys [m/s]
  double roll_speed = 2.5;      ///< by held keys or a stick [rad/s]
  double pad_speed = 0.08;      ///< of the tip by a stick at its end [m/s]
  double pad_dead_zone = 0.15;  ///< of a stick's way
  bool pad_fulcrum = false;     ///< sticks move the handle outside: the tip goes the other way
};

/// The usual bindings, as a table. Same as ControlSettings().bindings.rows().
std::vector<BindingRow> bindings();

/// Reads what differs from the usual settings ([keys], [mouse], [keyboard], [gamepad]; docs/devices.md). Throws
/// InputError naming file and line.
ControlSettings read_controls(const std::filesystem::path& file);

}  // namespace calot
