// The interface keeps off the picture, can be read, obeys mouse and keys, and draws without a window.
#include "calot/view/interface/interface.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calot/view/gl/context.h"
#include "calot/view/interface/style.h"
#include "tests/support/files.h"

namespace calot {
namespace {

InterfaceState usual_state() {
  InterfaceState s;
  s.step_number = 3;
  s.step_count = 7;
  s.step = "Free the cystic duct";
  s.hint =
      "Stay close to the gallbladder. Spread along the duct, never across it, until it can be seen from both sides.";
  HandState left, right;
  left.opening = 0.2;
  left.holds_tissue = true;
  left.force = 3.4;
  right.kind = InstrumentKind::hook;
  right.energy = true;
  s.left = left;
  s.right = right;
  s.blood = 12.4e-6;
  s.bile = 0.3e-6;
  s.time = 754;
  s.clips = 2;
  s.command_keys = {"p", "r", "f2", "f1", "v", "f12", "escape"};
  s.devices = {{"Mouse and keyboard", true}, {"Gamepad", false}};
  s.controls = {{"", {"mouse"}, "move the tip in the picture"}, {"", {"space, mouse left"}, "close the jaws"}};
  return s;
}

struct Size {
  int width, height;
};
constexpr Size sizes[] = {{640, 360}, {1280, 720}, {3840, 2160}, {1024, 768}};

InterfaceActions press(Interface& interface, const InterfaceState& state, InterfaceCommand command) {
  InterfaceInput input;
  input.commands = {command};
  return interface.lay_out(state, input, 1280, 720);
}

TEST(Interface, StaysOutOfTheRoundField) {
  for (const Size& size : {sizes[0], sizes[1], sizes[2]}) {
    Interface interface(TextTable::english());
    for (const double force : {0.0, 30.0}) {
      InterfaceState state = usual_state();
      state.left->force = state.right->force = force;
      interface.lay_out(state, {}, size.width, size.height);
      const double width = size.width, height = size.height, radius = round_field_radius * height;
      ASSERT_GT(interface.corners().size(), 300U);
      for (const auto& [x, y, opacity] : interface.corners()) {
        EXPECT_TRUE(x >= -1 && y >= -1 && x <= width + 1 && y <= height + 1) << x << ' ' << y;
        EXPECT_GT(std::hypot(x - 0.5 * width, y - 0.5 * height), radius) << x << ' ' << y;
      }
    }
  }
}

TEST(Interface, CanBeReadAtEverySize) {
  Interface interface(TextTable::english());
  const auto height = [&](int width, int rows, double ratio, double scale) {
    InterfaceState state = usual_state();
    state.settings.text_scale = scale;
    interface.lay_out(state, {}, width, rows, ratio);
    return interface.layout().text_height;
  };
  EXPECT_GE(height(640, 360, 1, 1), 11);
  EXPECT_GE(height(1280, 720, 1, 1), 16);
  EXPECT_GE(height(3840, 2160, 1, 1), 48);
  EXPECT_GE(height(1280, 720, 2, 1), 22);
  EXPECT_NEAR(height(1280, 720, 1, 1.5), 1.5 * height(1280, 720, 1, 1), 1.01);
}

TEST(Interface, SameStateSameTriangles) {
  for (const Size& size : sizes) {
    Interface one(TextTable::english());
    one.lay_out(usual_state(), {}, size.width, size.height);
    const auto first = one.corners();
    Interface other(TextTable::english());
    other.lay_out(usual_state(), {}, size.width, size.height);
    EXPECT_EQ(first, other.corners());
  }
}

TEST(Interface, TooMuchForceIsNotSaidByColourAlone) {
  Interface interface(TextTable::english());
  InterfaceState state = usual_state();
  state.left->force = 9.9;
  interface.lay_out(state, {}, 1280, 720);
  const auto before = interface.layout().triangles;
  state.left->force_limit = 9.8;  // the same number, now beyond
  interface.lay_out(state, {}, 1280, 720);
  EXPECT_GT(interface.layout().triangles, before + 4);
}

TEST(Interface, EachCommandHasAKey) {
  Interface interface(TextTable::english());
  InterfaceState state = usual_state();
  EXPECT_TRUE(press(interface, state, InterfaceCommand::pause).pause);
  EXPECT_TRUE(press(interface, state, InterfaceCommand::spectator).spectator);
  EXPECT_TRUE(press(interface, state, InterfaceCommand::picture).picture);
  const InterfaceActions quiet = interface.lay_out(state, {}, 1280, 720);
  EXPECT_FALSE(quiet.pause || quiet.spectator || quiet.picture || quiet.restart || quiet.quit || quiet.modal);

  EXPECT_FALSE(press(interface, state, InterfaceCommand::restart).restart) << "it asks first";
  EXPECT_TRUE(interface.lay_out(state, {}, 1280, 720).modal);
  EXPECT_TRUE(press(interface, state, InterfaceCommand::restart).restart);
  press(interface, state, InterfaceCommand::restart);
  EXPECT_FALSE(press(interface, state, InterfaceCommand::quit).modal) << "not after all";

  for (const InterfaceCommand page : {InterfaceCommand::settings, InterfaceCommand::help}) {
    EXPECT_TRUE(press(interface, state, page).modal);
    EXPECT_FALSE(press(interface, state, page).modal);
  }
  interface.show_help();
  EXPECT_TRUE(interface.lay_out(state, {}, 1280, 720).modal);
  EXPECT_TRUE(press(interface, state, InterfaceCommand::quit).help_closed);

  const InterfaceActions first = press(interface, state, InterfaceCommand::quit);
  EXPECT_TRUE(first.pause && !first.quit) << "leaving begins with a pause";
  state.paused = true;
  EXPECT_TRUE(press(interface, state, InterfaceCommand::quit).quit);
}

TEST(Interface, SettingsChangeByKeyboard) {
  Interface interface(TextTable::english());
  InterfaceState state = usual_state();
  press(interface, state, InterfaceCommand::settings);
  std::set<int> changed;
  const auto frame = [&](bool InterfaceInput::*key) {
    InterfaceInput input;
    if (key != nullptr) input.*key = true;
    const InterfaceActions actions = interface.lay_out(state, input, 1280, 720);
    if (!actions.settings) return;
    const InterfaceSettings &now = *actions.settings, &was = state.settings;
    if (now.quality != was.quality) changed.insert(0);
    if (now.volume != was.volume) changed.insert(1);
    if (now.colors != was.colors) changed.insert(2);
    if (now.text_scale != was.text_scale) changed.insert(3);
    state.settings = now;
  };
  const auto tap = [&](bool InterfaceInput::*key) {
    frame(key);
    frame(nullptr);
  };
  frame(nullptr);
  for (int row = 0; row < 8; ++row) {
    tap(&InterfaceInput::up);
    for (auto key : {&InterfaceInput::accept, &InterfaceInput::right, &InterfaceInput::accept}) tap(key);
  }
  EXPECT_EQ(changed, (std::set<int>{0, 1, 2, 3}));
  EXPECT_TRUE(state.settings.volume >= 0 && state.settings.volume <= 1);
  EXPECT_TRUE(state.settings.text_scale >= 0.75 && state.settings.text_scale <= 2);
}

TEST(Interface, ObeysTheMouse) {
  Interface interface(TextTable::english());
  const InterfaceState state = usual_state();
  const auto click = [&](double x, double y) {
    InterfaceInput input;
    input.pointer = {x, y};
    interface.lay_out(state, input, 1280, 720);
    input.pressed = true;
    return interface.lay_out(state, input, 1280, 720);
  };
  EXPECT_FALSE(click(640, 300).pause);
  interface.lay_out(state, {}, 1280, 720);
  EXPECT_TRUE(click(1250, 362).pause);  // at the right edge, half way down
  InterfaceInput hidden;                // the mouse drives an instrument
  hidden.pressed = true;
  interface.lay_out(state, {}, 1280, 720);
  const InterfaceActions actions = interface.lay_out(state, hidden, 1280, 720);
  EXPECT_FALSE(actions.pause || actions.modal);
}

TEST(Interface, WritesNoFiles) {
  const test::TempFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  {
    Interface interface(TextTable::english());
    InterfaceInput input;
    input.seconds = 1;
    interface.show_help();
    for (int k = 0; k < 20; ++k) interface.lay_out(usual_state(), input, 640, 360);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  std::filesystem::current_path(before);
}

TEST(Interface, RefusesImpossibleSizes) {
  Interface interface(TextTable::english());
  EXPECT_THROW(interface.lay_out(usual_state(), {}, 20, 360), InputError);
  EXPECT_THROW(interface.lay_out(usual_state(), {}, 640, 100000), InputError);
}

TEST(Interface, ColoursStandOutFromTheirGround) {
  for (const InterfaceColors colors : {InterfaceColors::usual, InterfaceColors::contrast}) {
    const detail::Palette p = detail::palette_of(colors);
    const double least = colors == InterfaceColors::contrast ? 7 : 4.5;
    for (const ImU32 color : {p.text, p.dim, p.left, p.right, p.caution, p.alarm, p.blood, p.bile})
      for (const ImU32 ground : {IM_COL32(0, 0, 0, 255), p.panel})
        EXPECT_GE(detail::contrast(color, ground), least) << std::hex << color;
  }
}

TEST(Interface, DrawsIntoAFramebufferWithoutAWindow) {
  OffscreenContext context;
  Interface interface(TextTable::english());
  for (const Size& size : {sizes[0], sizes[1]}) {
    const PictureCanvas canvas(size.width, size.height);
    glBindFramebuffer(GL_FRAMEBUFFER, canvas.canvas().framebuffer);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    interface.lay_out(usual_state(), {}, size.width, size.height);
    interface.draw();
    EXPECT_TRUE(glIsEnabled(GL_DEPTH_TEST));
    EXPECT_FALSE(glIsEnabled(GL_BLEND) || glIsEnabled(GL_SCISSOR_TEST));
    const Image image = canvas.read();
    const auto lit = [&](int x0, int y0, int x1, int y1) {  // from the top left
      int count = 0;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) count += image.rgb[static_cast<std::size_t>(3 * (y * size.width + x) + 1)] > 100;
      return count;
    };
    const int w = size.width, h = size.height;
    EXPECT_GT(lit(0, 0, w / 4, h / 4), 200) << "step";
    EXPECT_GT(lit(3 * w / 4, 0, w, h / 4), 150) << "counts";
    EXPECT_GT(lit(0, 3 * h / 4, w / 4, h), 150) << "left hand";
    EXPECT_GT(lit(3 * w / 4, 3 * h / 4, w, h), 100) << "right hand";
    EXPECT_EQ(lit(w / 2 - h / 2, h / 4, w / 2 + h / 2, 3 * h / 4), 0) << "field";
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  }
  EXPECT_TRUE(context.log().silent()) << context.log().messages().front();
}

}  // namespace
}  // namespace calot
