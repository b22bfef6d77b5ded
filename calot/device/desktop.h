// Mouse and keyboard: one hand is steered, the others stay as they were left.
#pragma once
#include <atomic>
#include <bitset>
#include <memory>

#include "calot/device/controls.h"
#include "calot/device/hand.h"
#include "calot/device/steered_hand.h"

namespace calot {

/// A key or a mouse button goes down or up. Repeats of a held key are no events.
struct KeyEvent {
  Key key = Key::none;
  bool down = false;
};

/// The pointer moves, or the wheel turns.
struct PointerEvent {
  double right = 0, down = 0;  ///< of the picture's height
  double wheel = 0;            ///< notches, > 0 away from the user: deeper
};

/// How the picture lies in the world.
struct PictureView {
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();  ///< x to the picture's right, y up, z towards the viewer
  double height = 0.15;                                      ///< of what the picture shows where the tips are [m]
};

/// All calls but `controls` and the devices' own on one thread, that of the events.
class Desktop {
 public:
  /// @param hands  1 … 4; the first is active. Throws InputError
  explicit Desktop(ControlSettings settings = {}, int hands = 2, const DeviceClock& clock = steady_clock());

  /// The device of a hand, for a Hand with HandMap::tip; lives as long as this.
  [[nodiscard]] HapticDevice& device(int hand) { return *at(hand).device; }
  /// What the hand's ratchet and clutch are set to; from any thread.
  [[nodiscard]] HandControls controls(int hand) const;
  [[nodiscard]] int active() const { return active_; }
  [[nodiscard]] int hands() const { return static_cast<int>(hands_.size()); }
  [[nodiscard]] const ControlSettings& settings() const { return settings_; }
  /// Lets go of everything first.
  void use(ControlSettings settings);

  /// The picture from now on.
  void look(const PictureView& view);
  /// What a hand holds from now on.
  void hold(int hand, const InstrumentGeometry& geometry);
  void take(int hand);  ///< makes it the active one

  /// @return what was pressed, where that isn't a matter of the hand alone (next_hand and ratchet are done already)
  std::optional<Action> key(const KeyEvent& event);
  void pointer(const PointerEvent& event);
  /// All keys up: the window lost the focus.
  void let_go();

 private:
  struct HandState {
    std::unique_ptr<SteeredHand> device;
    InstrumentKind kind = InstrumentKind::bowel_grasper;
    std::atomic<bool> clutch = false, ratchet = false;
  };
  [[nodiscard]] HandState& at(int hand);
  [[nodiscard]] bool is_held(Action action) const;
  void press(Action action);
  void close_or_open(bool down);
  void steer();

  ControlSettings settings_;
  PictureView view_;
  std::vector<std::unique_ptr<HandState>> hands_;
  int active_ = 0, closer_ = -1;  // closer_: the hand that the closing key was pressed for
  std::bitset<key_count> down_;
};

}  // namespace calot
