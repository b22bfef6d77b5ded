// One or two gamepads: one alone steers the active hand, of two each has its own.
#pragma once
#include <atomic>
#include <memory>

#include "calot/device/desktop.h"

union SDL_Event;
struct _SDL_GameController;

namespace calot {

/// How gamepads are used, for the help overlay.
std::vector<BindingRow> gamepad_rows();

/// A stick's way (−1 … 1 each) without its dead zone, finer near the middle.
Eigen::Vector2d stick_way(double x, double y, double dead_zone);

/// All calls but `controls` and the devices' own on one thread, that of the events. Plugging in and out is seen by
/// `poll`; a hand without a gamepad is not connected.
class Gamepads {
 public:
  /// Throws FailedError where SDL has no gamepads at all, InputError for hands out of 1 … 4.
  explicit Gamepads(const ControlSettings& settings = {}, int hands = 2, const DeviceClock& clock = steady_clock());
  ~Gamepads();
  Gamepads(const Gamepads&) = delete;
  Gamepads& operator=(const Gamepads&) = delete;

  /// The device of a hand, for a Hand with HandMap::tip; lives as long as this.
  [[nodiscard]] HapticDevice& device(int hand) { return *at(hand).device; }
  [[nodiscard]] HandControls controls(int hand) const;
  [[nodiscard]] int active() const { return active_; }
  /// Names of what is plugged in and used, in the order of hands; empty where there is none.
  [[nodiscard]] std::vector<std::string> names() const;

  void look(const PictureView& view) { view_ = view; }
  void hold(int hand, const InstrumentGeometry& geometry);
  void take(int hand);

  /// Reads all gamepads; call it once a frame. @return what was pressed, as Desktop::key
  std::vector<Action> poll();

 private:
  struct Slot {
    std::unique_ptr<SteeredHand> device;
    _SDL_GameController* pad = nullptr;
    InstrumentKind kind = InstrumentKind::bowel_grasper;
    std::uint32_t buttons = 0;  // that were down at the last poll
    double kept = 0;            // the trigger when the hand was left; pulled as far again, it takes over
    std::atomic<bool> clutch = false, ratchet = false;
  };
  [[nodiscard]] Slot& at(int hand);
  [[nodiscard]] Slot& slot_of_hand(int hand);
  void find_pads();
  void park(Slot& hand);
  void steer(Slot& hand, const Slot& pad);
  void press(Slot& hand, int button, std::vector<Action>& pressed);

  ControlSettings settings_;
  PictureView view_;
  std::vector<std::unique_ptr<Slot>> slots_;
  int active_ = 0;
  bool several_ = false;  // each hand has its own
};

}  // namespace calot
