// Virtual gamepads: sticks, triggers, buttons; plugged in, pulled out, two of them.
#include <SDL.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calot/device/gamepads.h"

namespace calot::test {
namespace {

const InstrumentGeometry grasper = instrument_geometry(InstrumentKind::bowel_grasper);

/// A gamepad that the test presses.
class VirtualPad {
 public:
  VirtualPad() { plug_in(); }
  ~VirtualPad() { pull_out(); }
  VirtualPad(const VirtualPad&) = delete;
  VirtualPad& operator=(const VirtualPad&) = delete;
  void plug_in() {
    const int index = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, SDL_CONTROLLER_AXIS_MAX,
                                                SDL_CONTROLLER_BUTTON_MAX, 0);
    ASSERT_GE(index, 0) << SDL_GetError();
    stick_ = SDL_JoystickOpen(index);
    ASSERT_NE(stick_, nullptr);
    for (const int trigger : {SDL_CONTROLLER_AXIS_TRIGGERLEFT, SDL_CONTROLLER_AXIS_TRIGGERRIGHT}) axis(trigger, -1);
  }
  void pull_out() {
    if (stick_ == nullptr) return;
    for (int k = 0; k < SDL_NumJoysticks(); ++k)
      if (SDL_JoystickGetDeviceInstanceID(k) == SDL_JoystickInstanceID(stick_)) SDL_JoystickDetachVirtual(k);
    SDL_JoystickClose(stick_);
    stick_ = nullptr;
  }
  void axis(int which, double way) { SDL_JoystickSetVirtualAxis(stick_, which, static_cast<Sint16>(32767 * way)); }
  /// 0 … 1; SDL maps a trigger from the whole range of its axis.
  void trigger(int which, double way) { axis(which, 2 * way - 1); }
  void button(int which, bool down) { SDL_JoystickSetVirtualButton(stick_, which, down ? 1 : 0); }

 private:
  SDL_Joystick* stick_ = nullptr;
};

struct Pads : testing::Test {
  double now = 0;
  Gamepads pads{ControlSettings{}, 2, [this] { return now; }};
  void SetUp() override {
    for (int hand = 0; hand < 2; ++hand) pads.hold(hand, grasper);
  }
  DeviceState run(int hand, double seconds) {
    (void)pads.poll();
    DeviceState state = pads.device(hand).read();
    for (int k = 0; k < static_cast<int>(std::lround(seconds * 100)); ++k) {
      now += 0.01;
      state = pads.device(hand).read();
    }
    return state;
  }
  /// Presses a button for one poll.
  std::vector<Action> tap(VirtualPad& pad, int button) {
    pad.button(button, true);
    const std::vector<Action> pressed = pads.poll();
    pad.button(button, false);
    (void)pads.poll();
    return pressed;
  }
};

TEST(Stick, HasADeadZoneAndIsFinerInTheMiddle) {
  EXPECT_EQ(stick_way(0.1, 0.1, 0.15), Eigen::Vector2d::Zero());
  EXPECT_NEAR((stick_way(1, 0, 0.15) - Eigen::Vector2d(1, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR(stick_way(0.6, 0, 0.2).x(), 0.25, 1e-15);
  EXPECT_NEAR(stick_way(1, 1, 0.15).norm(), 1, 1e-15);
  EXPECT_EQ(stick_way(0.1, 0, 0.9).norm(), 0);
}

TEST_F(Pads, NoneIsNotConnected) {
  EXPECT_FALSE(run(0, 0.1).connected || run(1, 0.1).connected);
  EXPECT_EQ(pads.names(), (std::vector<std::string>{"", ""}));
}

TEST_F(Pads, SticksTiltAndRoll) {
  VirtualPad pad;
  const double speed = ControlSettings().pad_speed;
  EXPECT_TRUE(run(0, 0).connected);
  EXPECT_EQ(run(0, 0.3).handle.position.norm(), 0);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 0.1);  // within the dead zone
  EXPECT_EQ(run(0, 0.3).handle.position.norm(), 0);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 1);
  EXPECT_NEAR((run(0, 0.5).handle.position - Vec3(0.5 * speed, 0, 0)).norm(), 0, 1e-6);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 0);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, -1);  // up
  EXPECT_NEAR((run(0, 0.5).handle.position - Vec3(0.5 * speed, 0.5 * speed, 0)).norm(), 0, 1e-5);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, 0);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 1);  // deeper
  EXPECT_NEAR(run(0, 0.25).handle.position.z(), -0.25 * speed, 1e-5);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 0);
  pad.axis(SDL_CONTROLLER_AXIS_RIGHTY, 1);  // nearer
  EXPECT_NEAR(run(0, 0.25).handle.position.z(), 0, 1e-5);
  pad.axis(SDL_CONTROLLER_AXIS_RIGHTY, 0);
  pad.axis(SDL_CONTROLLER_AXIS_RIGHTX, 1);
  EXPECT_NEAR(Eigen::AngleAxisd(run(0, 0.4).handle.rotation).angle(), 0.4 * ControlSettings().roll_speed, 1e-3);
}

TEST_F(Pads, TriggerClosesAndGrips) {
  VirtualPad pad;
  EXPECT_NEAR(run(0, 0.1).opening, grasper.max_opening, 1e-4);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0.3);
  DeviceState state = run(0, 0.1);
  EXPECT_NEAR(state.opening, grasper.max_opening / 2, 1e-3);
  EXPECT_EQ(state.grip, 0);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0.8);
  state = run(0, 0.1);
  EXPECT_EQ(state.opening, 0);
  EXPECT_NEAR(state.grip, grasper.max_grip / 2, 1e-2);
}

TEST_F(Pads, ShouldersUseAndPedal) {
  VirtualPad pad;
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  EXPECT_TRUE(run(0, 0.1).pedal);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, false);
  EXPECT_FALSE(run(0, 0.1).pedal);
  pads.hold(0, instrument_geometry(InstrumentKind::clip_applier));
  pad.button(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, true);
  EXPECT_TRUE(run(0, 0.1).button);
  EXPECT_FALSE(run(0, 0.1).pedal);
  pad.button(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, false);
  EXPECT_FALSE(run(0, 0.1).button);
  EXPECT_EQ(tap(pad, SDL_CONTROLLER_BUTTON_START), std::vector<Action>{Action::pause});
  EXPECT_EQ(tap(pad, SDL_CONTROLLER_BUTTON_A), std::vector<Action>{Action::ratchet});
  EXPECT_TRUE(pads.controls(0).ratchet);
  pad.button(SDL_CONTROLLER_BUTTON_X, true);
  (void)pads.poll();
  EXPECT_TRUE(pads.controls(0).clutch);
}

TEST_F(Pads, OneServesBothHandsInTurn) {
  VirtualPad pad;
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0.8);
  const double grip = run(0, 0.1).grip;
  EXPECT_EQ(tap(pad, SDL_CONTROLLER_BUTTON_Y), std::vector<Action>{Action::next_hand});
  EXPECT_EQ(pads.active(), 1);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 1);
  EXPECT_GT(run(1, 0.2).handle.position.x(), 0.01);
  const DeviceState parked = run(0, 0.2);
  EXPECT_TRUE(parked.connected);
  EXPECT_EQ(parked.grip, grip);
  EXPECT_EQ(parked.handle.position.norm(), 0);
  // Back: it holds until the trigger has been where it was.
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 0);
  (void)tap(pad, SDL_CONTROLLER_BUTTON_Y);
  EXPECT_EQ(run(0, 0.1).grip, grip);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0.9);
  EXPECT_GT(run(0, 0.1).grip, grip);
  pad.trigger(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0);
  EXPECT_EQ(run(0, 0.1).grip, 0);
}

TEST_F(Pads, TwoHaveAHandEachAndOneCanBeLost) {
  VirtualPad first, second;
  (void)pads.poll();
  EXPECT_NE(pads.names()[0], "");
  EXPECT_NE(pads.names()[1], "");
  second.axis(SDL_CONTROLLER_AXIS_LEFTX, 1);
  EXPECT_GT(run(1, 0.2).handle.position.x(), 0.01);
  EXPECT_EQ(run(0, 0.2).handle.position.norm(), 0);
  EXPECT_TRUE(tap(first, SDL_CONTROLLER_BUTTON_Y).empty());
  second.pull_out();
  EXPECT_FALSE(run(1, 0.1).connected);
  EXPECT_TRUE(run(0, 0.1).connected);
  const Vec3 there = run(1, 0).handle.position;
  EXPECT_EQ((run(1, 0.5).handle.position - there).norm(), 0);
  second.plug_in();
  second.axis(SDL_CONTROLLER_AXIS_LEFTX, -1);
  const DeviceState again = run(1, 0.2);
  EXPECT_TRUE(again.connected);
  EXPECT_LT(again.handle.position.x(), there.x());
  // The one that is left can take over the other hand.
  second.pull_out();
  (void)pads.poll();
  EXPECT_EQ(tap(first, SDL_CONTROLLER_BUTTON_Y), std::vector<Action>{Action::next_hand});
  EXPECT_EQ(pads.active(), 1);
  EXPECT_TRUE(run(1, 0.1).connected);
}

}  // namespace
}  // namespace calot::test
