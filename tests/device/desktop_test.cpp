// Mouse and keyboard as sequences of events; the table of keys and its file.
#include "calot/device/desktop.h"

#include <SDL.h>
#include <gtest/gtest.h>

#include <set>

#include "calot/device/sdl_events.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

/// A desktop whose time the test moves on.
struct Table {
  double now = 0;
  Desktop desktop{ControlSettings{}, 2, [this] { return now; }};
  Table() {
    for (int hand = 0; hand < 2; ++hand) desktop.hold(hand, instrument_geometry(InstrumentKind::bowel_grasper));
    (void)read(0);
    (void)read(1);
  }
  DeviceState read(int hand) { return desktop.device(hand).read(); }
  /// Reads a hand 100 times a second.
  DeviceState run(int hand, double seconds) {
    DeviceState state;
    for (int k = 0; k < static_cast<int>(std::lround(seconds * 100)); ++k) {
      now += 0.01;
      state = read(hand);
    }
    return state;
  }
  std::optional<Action> press(Key key) { return desktop.key({key, true}); }
  void release(Key key) { (void)desktop.key({key, false}); }
};

const InstrumentGeometry grasper = instrument_geometry(InstrumentKind::bowel_grasper);

TEST(Desktop, MouseMovesTheTipInThePicture) {
  Table table;
  PictureView view;
  view.axes = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));  // up in the picture is the world's z
  view.height = 0.2;
  table.desktop.look(view);
  table.desktop.pointer({0.1, 0, 0});
  EXPECT_NEAR((table.read(0).handle.position - Vec3(0.02, 0, 0)).norm(), 0, 1e-15);
  table.desktop.pointer({0, -0.1, 0});
  EXPECT_NEAR((table.read(0).handle.position - Vec3(0.02, 0, 0.02)).norm(), 0, 1e-15);
  table.desktop.pointer({0, 0, 2});  // away from the viewer: the world's y
  EXPECT_NEAR((table.read(0).handle.position - Vec3(0.02, 0.01, 0.02)).norm(), 0, 1e-15);
  EXPECT_EQ(table.read(1).handle.position.norm(), 0);
  table.desktop.pointer({NAN, 0, 0});
  EXPECT_TRUE(table.read(0).handle.position.allFinite());
  EXPECT_TRUE(table.read(0).connected);
}

TEST(Desktop, HeldKeysMoveAndRollEvenly) {
  Table table;
  (void)table.press(Key::right);
  (void)table.press(key_of_letter('w'));
  (void)table.press(key_of_letter('e'));
  const double v = table.desktop.settings().key_speed;
  DeviceState state = table.run(0, 0.5);
  EXPECT_NEAR((state.handle.position - Vec3(0.5 * v, 0, -0.5 * v)).norm(), 0, 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(state.handle.rotation).angle(), 0.5 * table.desktop.settings().roll_speed, 1e-12);
  table.release(Key::right);
  table.release(key_of_letter('w'));
  table.release(key_of_letter('e'));
  const Vec3 there = table.read(0).handle.position;
  EXPECT_EQ((table.run(0, 1).handle.position - there).norm(), 0);
}

TEST(Desktop, JawsCloseThenGripGrows) {
  Table table;
  EXPECT_EQ(table.run(0, 1).opening, grasper.max_opening);
  (void)table.press(Key::mouse_left);
  DeviceState state = table.run(0, 0.12);
  EXPECT_LT(state.opening, grasper.max_opening);
  EXPECT_GT(state.opening, 0);
  EXPECT_EQ(state.grip, 0);
  state = table.run(0, 0.2);
  EXPECT_EQ(state.opening, 0);
  const double early = state.grip;
  EXPECT_GT(early, 0);
  EXPECT_LT(early, grasper.usual_grip);
  state = table.run(0, 0.7);
  EXPECT_GT(state.grip, 0.99 * grasper.usual_grip);
  EXPECT_LT(state.grip, grasper.usual_grip + 0.2 * (grasper.max_grip - grasper.usual_grip));
  EXPECT_EQ(table.run(0, 20).grip, grasper.max_grip);
  table.release(Key::mouse_left);
  state = table.run(0, 0.3);
  EXPECT_EQ(state.opening, grasper.max_opening);
  EXPECT_EQ(state.grip, 0);
}

TEST(Desktop, TheParkedHandHoldsWhatItHas) {
  Table table;
  (void)table.press(Key::mouse_left);
  const double grip = table.run(0, 1).grip;
  EXPECT_EQ(table.press(Key::tab), Action::next_hand);
  table.release(Key::tab);
  EXPECT_EQ(table.desktop.active(), 1);
  table.release(Key::mouse_left);
  EXPECT_EQ(table.run(0, 30).grip, grip);
  EXPECT_EQ(table.run(1, 1).opening, grasper.max_opening);  // the press was for the other hand
  (void)table.press(key_of_letter('j'));
  EXPECT_EQ(table.run(1, 1).opening, 0);
  table.desktop.pointer({0.1, 0, 0});
  EXPECT_EQ(table.read(0).handle.position.norm(), 0);
  EXPECT_GT(table.read(1).handle.position.norm(), 0);
  // Back again: it still holds, until the key is pressed and let go.
  (void)table.press(Key::tab);
  table.release(key_of_letter('j'));
  EXPECT_EQ(table.run(0, 1).grip, grip);
  (void)table.press(Key::mouse_left);
  EXPECT_GE(table.run(0, 0.1).grip, grip);
  table.release(Key::mouse_left);
  EXPECT_EQ(table.run(0, 1).opening, grasper.max_opening);
  EXPECT_EQ(table.run(1, 1).opening, 0);
}

TEST(Desktop, UseBurnsOrFires) {
  Table table;
  table.desktop.hold(0, instrument_geometry(InstrumentKind::hook));
  (void)table.press(Key::mouse_right);
  EXPECT_TRUE(table.read(0).pedal && !table.read(0).button);
  table.release(Key::mouse_right);
  EXPECT_FALSE(table.run(0, 0.2).pedal);
  table.desktop.hold(0, instrument_geometry(InstrumentKind::clip_applier));
  (void)table.press(Key::mouse_right);
  EXPECT_TRUE(table.read(0).button && !table.read(0).pedal);
  table.release(Key::mouse_right);
  EXPECT_FALSE(table.run(0, 0.2).button);
  (void)table.press(Key::space);
  EXPECT_TRUE(table.read(0).pedal);
  (void)table.press(Key::tab);  // the pedal goes along
  EXPECT_FALSE(table.run(0, 0.2).pedal);
  EXPECT_TRUE(table.read(1).pedal);
}

TEST(Desktop, ShortPressesAreNotLost) {
  Table table;
  table.desktop.hold(0, instrument_geometry(InstrumentKind::clip_applier));
  (void)table.press(Key::mouse_right);
  table.release(Key::mouse_right);
  EXPECT_TRUE(table.read(0).button);
  table.now += 0.04;
  EXPECT_TRUE(table.read(0).button);
  table.now += 0.02;
  EXPECT_FALSE(table.read(0).button);
}

TEST(Desktop, TwoKeysOfOneActionAreOne) {
  Table table;
  (void)table.press(Key::mouse_left);
  (void)table.press(key_of_letter('j'));
  table.release(Key::mouse_left);
  EXPECT_EQ(table.run(0, 1).opening, 0);
  table.release(key_of_letter('j'));
  EXPECT_EQ(table.run(0, 1).opening, grasper.max_opening);
}

TEST(Desktop, RatchetAndClutchAreOfTheActiveHand) {
  Table table;
  EXPECT_EQ(table.press(key_of_letter('r')), Action::ratchet);
  EXPECT_TRUE(table.desktop.controls(0).ratchet);
  EXPECT_FALSE(table.desktop.controls(1).ratchet);
  (void)table.press(Key::left_shift);
  EXPECT_TRUE(table.desktop.controls(0).clutch);
  table.release(Key::left_shift);
  EXPECT_FALSE(table.desktop.controls(0).clutch);
}

TEST(Desktop, LostFocusLetsGoOfTheKeysNotOfTheTissue) {
  Table table;
  (void)table.press(Key::mouse_left);
  (void)table.press(Key::right);
  (void)table.press(Key::space);
  const double grip = table.run(0, 1).grip;
  table.desktop.let_go();
  const Vec3 there = table.run(0, 0.1).handle.position;
  const DeviceState state = table.run(0, 5);
  EXPECT_EQ((state.handle.position - there).norm(), 0);
  EXPECT_FALSE(state.pedal);
  EXPECT_EQ(state.grip, grip);
}

TEST(Desktop, OtherActionsAreReturnedOnce) {
  Table table;
  EXPECT_EQ(table.press(key_of_digit(3)), static_cast<Action>(static_cast<int>(Action::instrument_1) + 2));
  EXPECT_EQ(table.press(key_of_digit(3)), std::nullopt);  // still down
  EXPECT_EQ(table.press(Key::escape), Action::pause);
  EXPECT_EQ(table.press(key_of_letter('f')), Action::spectator);
  EXPECT_EQ(table.press(key_of_letter('h')), Action::help);
  EXPECT_EQ(table.press(function_key(1)), std::nullopt);  // help's other key while the first is down
  EXPECT_EQ(table.press(key_of_letter('y')), std::nullopt);
}

// The mouse through a Hand: the tip goes where the pointer went.
TEST(Desktop, SteersAnInstrumentThroughItsPort) {
  Table table;
  HandOptions options;
  options.port = {0, 0, 0.15};
  Hand hand(grasper, options, {Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Vec3::UnitX())), Vec3(0, 0, 0.02)});
  const auto step = [&] {
    table.now += 1.0 / 60;
    (void)hand.update(table.read(0), table.desktop.controls(0), 1.0 / 60);
  };
  step();
  const Vec3 from = hand.tip();
  table.desktop.pointer({0.2, 0, 0});
  for (int k = 0; k < 20; ++k) step();
  EXPECT_NEAR((hand.tip() - from - Vec3(0.03, 0, 0)).norm(), 0, 1e-12);
}

TEST(Controls, EveryKeyDoesOneThingAndEveryActionHasAKey) {
  const Bindings usual;
  std::set<Key> seen;
  for (const ActionInfo& info : all_actions()) {
    EXPECT_FALSE(usual.keys_of(info.action).empty()) << info.name;
    bool keyboard = false;
    for (const Key key : usual.keys_of(info.action)) {
      EXPECT_TRUE(seen.insert(key).second) << name_of(key);
      EXPECT_EQ(usual.action_of(key), info.action);
      keyboard = keyboard || key < Key::mouse_left;
    }
    EXPECT_TRUE(keyboard) << info.name;
  }
  for (int k = 1; k < key_count; ++k) EXPECT_EQ(key_of(name_of(static_cast<Key>(k))), static_cast<Key>(k));
  const std::vector<BindingRow> rows = bindings();
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(action_count) - 8 + 2);
  EXPECT_EQ(rows[2].keys, "left");
}

TEST(Controls, AreReadFromAFile) {
  const TempFolder folder;
  write_bytes(folder / "keys.toml",
              "[keys]\nclose_jaws = [\"Space\", \"mouse left\"]\npause = \"F5\"\nhelp = []\n"
              "[mouse]\nspeed = 2\nwheel = 3.0\n[keyboard]\nspeed = 80\nroll = 90\n"
              "[gamepad]\nspeed = 100\ndead_zone = 0.2\nfulcrum = true\n");
  const ControlSettings read = read_controls(folder / "keys.toml");
  EXPECT_EQ(read.bindings.action_of(Key::space), Action::close_jaws);
  EXPECT_EQ(read.bindings.action_of(function_key(5)), Action::pause);
  EXPECT_EQ(read.bindings.action_of(Key::escape), std::nullopt);
  EXPECT_EQ(read.bindings.action_of(key_of_letter('h')), std::nullopt);
  EXPECT_TRUE(read.bindings.keys_of(Action::pedal).empty());  // its key was taken
  EXPECT_EQ(read.pointer_speed, 2);
  EXPECT_DOUBLE_EQ(read.wheel_step, 3e-3);
  EXPECT_DOUBLE_EQ(read.key_speed, 0.08);
  EXPECT_DOUBLE_EQ(read.roll_speed, M_PI / 2);
  EXPECT_DOUBLE_EQ(read.pad_speed, 0.1);
  EXPECT_EQ(read.pad_dead_zone, 0.2);
  EXPECT_TRUE(read.pad_fulcrum);
}

TEST(Controls, BadFilesAreToldByFileAndLine) {
  const TempFolder folder;
  const auto message = [&](const std::string& text) {
    write_bytes(folder / "k.toml", text);
    std::string said = message_of([&] { (void)read_controls(folder / "k.toml"); });
    const auto at = said.find("k.toml");
    return at == std::string::npos ? said : said.substr(at);
  };
  EXPECT_EQ(message("[keys]\npaus = \"a\"\n"), "k.toml:2: unknown key \"paus\"; did you mean pause?");
  EXPECT_EQ(message("[keys]\npause = \"escap\"\n"), "k.toml:2: there is no key \"escap\"; did you mean escape?");
  EXPECT_EQ(message("[keys]\npause = 3\n"), "k.toml:2: pause must be a list; write it in [ ]");
  EXPECT_EQ(message("[keys]\npause = [3]\n"), "k.toml:2: pause must be text; write it in quotes");
  EXPECT_EQ(message("[keys]\npause = \"a\"\n\nhelp = [\"b\", \"A\"]\n"),
            "k.toml:4: \"a\" is bound twice, to pause and help; leave it to one of them");
  EXPECT_EQ(message("[mouse]\nspeed = 100\n"), "k.toml:2: speed = 100 is out of range; give 0.1 to 10");
  EXPECT_EQ(message("[mouse]\nspeed = nan\n"), "k.toml:2: speed is not a finite number; give a finite number");
  EXPECT_EQ(message("mouse = 3\n"), "k.toml:1: mouse must be a section; write [mouse]");
  EXPECT_EQ(message("[mose]\n"), "k.toml:1: unknown key \"mose\"; did you mean mouse?");
  EXPECT_EQ(message("[gamepad]\nfulcrum = 1\n"), "k.toml:2: fulcrum must be true or false; write fulcrum = true");
  EXPECT_NE(message("[keys\n").find("k.toml:1: not TOML"), std::string::npos);
  EXPECT_NE(message("[keys]\npause = [\"a\",\"b\",\"c\",\"d\",\"e\",\"f\",\"g\",\"i\",\"l\"]\n").find("8 at most"),
            std::string::npos);
}

TEST(SdlEvents, AreTranslated) {
  EXPECT_EQ(key_of_sdl(SDLK_q, SDL_SCANCODE_A), key_of_letter('q'));  // by what is printed on it
  EXPECT_EQ(key_of_sdl(0x44f, SDL_SCANCODE_Z), key_of_letter('z'));   // a Cyrillic letter: by its place
  EXPECT_EQ(key_of_sdl(SDLK_F12, 0), function_key(12));
  EXPECT_EQ(key_of_sdl(SDLK_SYSREQ, 0), Key::none);
  Table table;
  SDL_Event event{};
  event.type = SDL_MOUSEMOTION;
  event.motion.xrel = 36;
  event.motion.yrel = -72;
  EXPECT_EQ(feed(table.desktop, event, 720), std::nullopt);
  const double height = PictureView().height;
  EXPECT_NEAR((table.read(0).handle.position - height * Vec3(0.05, 0.1, 0)).norm(), 0, 1e-15);
  event = {};
  event.type = SDL_KEYDOWN;
  event.key.keysym.sym = SDLK_ESCAPE;
  EXPECT_EQ(feed(table.desktop, event, 720), Action::pause);
  event.key.repeat = 1;
  EXPECT_FALSE(key_event(event).has_value());
  event = {};
  event.type = SDL_MOUSEBUTTONDOWN;
  event.button.button = SDL_BUTTON_LEFT;
  (void)feed(table.desktop, event, 720);
  EXPECT_EQ(table.run(0, 1).opening, 0);
  event = {};
  event.type = SDL_WINDOWEVENT;
  event.window.event = SDL_WINDOWEVENT_FOCUS_LOST;
  (void)feed(table.desktop, event, 720);
  EXPECT_EQ(table.run(0, 1).opening, 0);
}

}  // namespace
}  // namespace calot::test
