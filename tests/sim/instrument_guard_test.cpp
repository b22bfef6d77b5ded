#include "calot/sim/instrument_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace calot {
namespace {

constexpr double step = 0.01;

InstrumentInput at(double x, double opening = 0.2) {
  InstrumentInput input;
  input.pose.position.x() = x;
  input.opening = opening;
  input.grip = 3;
  input.energy = true;
  return input;
}

InstrumentGuard guard() {
  return InstrumentGuard(instrument_geometry(InstrumentKind::bowel_grasper), at(0));
}

TEST(InstrumentGuard, LetsGoodInputThroughAsItIs) {
  InstrumentGuard g = guard();
  const InstrumentInput& out = g.accept(at(0.02, 0.5), step);
  EXPECT_EQ(out.pose.position.x(), 0.02);
  EXPECT_EQ(out.opening, 0.5);
  EXPECT_TRUE(out.energy);
  EXPECT_EQ(g.status(), InputStatus::good);
}

TEST(InstrumentGuard, HoldsThroughEveryKindOfFault) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  InstrumentInput bad_place = at(nan), bad_grip = at(0), bad_turn = at(0), far = at(1.0), wide = at(0, 2.0),
                  narrow = at(0, -0.1), hard = at(0), endless = at(0, inf), spun = at(0);
  bad_grip.grip = nan;
  bad_turn.pose.rotation.coeffs() *= 2;
  hard.grip = 1000;
  spun.pose.rotation = Eigen::AngleAxisd(2.0, Vec3::UnitY());
  const std::vector<std::pair<std::optional<InstrumentInput>, InputStatus>> cases{
      {std::nullopt, InputStatus::missing},
      {bad_place, InputStatus::not_a_number},
      {bad_grip, InputStatus::not_a_number},
      {endless, InputStatus::not_a_number},
      {bad_turn, InputStatus::not_a_rotation},
      {far, InputStatus::jumped},
      {spun, InputStatus::jumped},
      {wide, InputStatus::opening_out_of_range},
      {narrow, InputStatus::opening_out_of_range},
      {hard, InputStatus::grip_out_of_range}};
  for (const auto& [input, status] : cases) {
    InstrumentGuard g = guard();
    g.accept(at(0.01), step);
    const InstrumentInput& out = g.accept(input, step);
    EXPECT_EQ(g.status(), status);
    EXPECT_FALSE(words_of(g.status()).empty());
    EXPECT_EQ(out.pose.position.x(), 0.01);
    EXPECT_EQ(out.opening, 0.2);
    EXPECT_EQ(out.grip, 3);
    EXPECT_FALSE(out.energy);  // no pedal without a hand
  }
}

TEST(InstrumentGuard, CatchesUpNoFasterThanItMay) {
  InstrumentGuard g = guard();
  const GuardLimits limits;
  double before = 0;
  int steps = 0;
  for (; steps < 100; ++steps) {
    const InstrumentInput& out = g.accept(at(0.3), step);  // the device came back 300 mm away and stays there
    EXPECT_LE(out.pose.position.x() - before, limits.recovery_speed * step + 1e-12);
    EXPECT_EQ(out.energy, g.status() == InputStatus::good);
    before = out.pose.position.x();
    if (g.status() == InputStatus::good) break;
  }
  EXPECT_EQ(before, 0.3);
  EXPECT_NEAR(steps, 30 + limits.trust_after, 3);  // 0.3 m at 1 m/s
  EXPECT_EQ(g.accept(at(0.31), step).pose.position.x(), 0.31);
}

TEST(InstrumentGuard, ADeviceThatKeepsJumpingIsNeverFollowed) {
  InstrumentGuard g = guard();
  for (int k = 0; k < 50; ++k) EXPECT_EQ(g.accept(at(k % 2 == 0 ? 0.5 : 0.0), step).pose.position.x(), 0);
}

TEST(InstrumentGuard, ARepeatOfTheSameFaultsGivesTheSameBytes) {
  std::string a, b;
  for (std::string* bytes : {&a, &b}) {
    InstrumentGuard g = guard();
    for (int k = 0; k < 40; ++k) {
      g.accept(k % 7 == 3 ? std::nullopt : std::optional(at(0.01 * k)), step);
      g.append_state(*bytes);
    }
  }
  EXPECT_EQ(a, b);
}

TEST(InstrumentGuard, AsksNoOpeningOfAHook) {
  InstrumentGuard g(instrument_geometry(InstrumentKind::hook), at(0));
  g.accept(at(0.01, 0.7), step);
  EXPECT_EQ(g.status(), InputStatus::good);
}

}  // namespace
}  // namespace calot
