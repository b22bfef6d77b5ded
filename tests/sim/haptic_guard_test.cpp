// What a device may do wrong: the instrument holds, the force fades, a status says so, and the way back is smooth.
#include "calot/sim/haptic_guard.h"

#include <gtest/gtest.h>

#include "calot/sim/haptic_mock.h"
#include "calot/sim/haptic_twist.h"
#include "tests/sim/haptic_walls.h"

namespace calot::test {
namespace {

struct Step {
  HapticOutput out;
  double device_z;
};

/// A hand that presses 2 mm into a wall and moves slowly along it; a fault from 0.5 to 0.8 s.
std::vector<Step> run_with(MockFault fault, double seconds = 3.0) {
  MockHapticDevice device([](double t) { return at(0.01 * std::sin(t), 0, -0.004); });
  device.set_fingers(0.4, 2.0, true, false);
  HapticTick tick(HapticOptions(), device.limits());
  std::vector<Step> steps;
  for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
    const double now = 1e-3 * i;
    if (i == 100) device.set_fingers(0.4, 2.0, false, false);
    if (i == 200) device.set_fingers(0.4, 2.0, true, false);
    device.set_fault(i >= 500 && i < 800 ? fault : MockFault::none);
    if (i % 16 == 0 && tick.wants_set()) {
      EXPECT_TRUE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
    }
    const HapticOutput out = tick.run(device.read(), now);
    device.write(out.force, out.torque);
    steps.push_back({out, device.handle().position.z()});
  }
  return steps;
}

class Faults : public testing::TestWithParam<std::pair<MockFault, HapticStatus>> {};

TEST_P(Faults, HoldFadeSayAndRecover) {
  const auto [fault, status] = GetParam();
  const std::vector<Step> steps = run_with(fault);
  const auto& before = steps[499].out;
  EXPECT_EQ(before.status, HapticStatus::working);
  EXPECT_GT(before.force.z(), 0.3);
  EXPECT_TRUE(before.input.energy);
  // Holds, fades and says so.
  const HapticOutput held = steps[560].out;
  for (int i = 530; i < 800; ++i) {
    const HapticOutput& out = steps[static_cast<std::size_t>(i)].out;
    EXPECT_EQ(out.status, status) << i;
    EXPECT_LT((out.input.pose.position - before.input.pose.position).norm(), 5e-4) << i;
    EXPECT_FALSE(out.input.energy) << i;
    EXPECT_EQ(out.input.opening, 0.4);
    if (i > 560) {
      EXPECT_EQ(out.input.pose.position, held.input.pose.position) << i;
    }
    if (i > 640) {
      EXPECT_EQ(out.force, Vec3(Vec3::Zero())) << i;
    }
  }
  // Never a leap of the instrument or of the force, also on the way back.
  for (std::size_t i = 400; i + 1 < steps.size(); ++i) {
    EXPECT_LT((steps[i + 1].out.input.pose.position - steps[i].out.input.pose.position).norm(), 4e-4) << i;
    EXPECT_LT((steps[i + 1].out.force - steps[i].out.force).norm(), 0.06) << i;
  }
  const HapticOutput& after = steps.back().out;
  EXPECT_EQ(after.status, HapticStatus::working);
  EXPECT_GT(after.force.z(), 0.3);
  EXPECT_NEAR(after.input.pose.position.z(), steps.back().device_z + after.force.z() / 1000, 1e-4);
  // The pedal was down all the time: it works again only after it was let go.
  EXPECT_FALSE(after.input.energy);
}

INSTANTIATE_TEST_SUITE_P(Each, Faults,
                         testing::Values(std::pair{MockFault::not_a_number, HapticStatus::not_a_number},
                                         std::pair{MockFault::silent, HapticStatus::silent},
                                         std::pair{MockFault::disconnected, HapticStatus::disconnected}));

// A jump that stays is said for a moment; then the instrument glides to the new place, and the force comes back there.
TEST(Guard, AJumpOfAMetreHoldsThenGlides) {
  const std::vector<Step> steps = run_with(MockFault::jump, 4.0);
  EXPECT_EQ(steps[500].out.status, HapticStatus::jump);
  EXPECT_EQ(steps[515].out.status, HapticStatus::jump);
  EXPECT_EQ(steps[540].out.status, HapticStatus::recovering);
  bool told_again = false;
  for (std::size_t i = 400; i + 1 < steps.size(); ++i) {
    EXPECT_LT((steps[i + 1].out.input.pose.position - steps[i].out.input.pose.position).norm(), 4e-4) << i;
    EXPECT_LT((steps[i + 1].out.force - steps[i].out.force).norm(), 0.06) << i;
    if (i > 640 && i < 900) {
      EXPECT_EQ(steps[i].out.force, Vec3(Vec3::Zero())) << i;
    }
    told_again = told_again || (i >= 800 && steps[i].out.status == HapticStatus::jump);
  }
  EXPECT_TRUE(told_again);  // when it jumps back
  EXPECT_EQ(steps.back().out.status, HapticStatus::working);
  EXPECT_GT(steps.back().out.force.z(), 0.3);
}

TEST(Guard, OneBadSampleIsBridged) {
  HapticGuard guard({});
  GuardedInput out;
  for (int i = 0; i < 1000; ++i) {
    Pose handle = at(1e-4 * i, 0, 0);
    if (i == 600) handle.rotation.coeffs()[2] = std::nan("");
    out = guard.check(sample_at(1e-3 * i, handle), 1e-3 * i, 1e-3);
    if (i == 600) {
      EXPECT_EQ(out.status, HapticStatus::not_a_number);
    }
    if (i > 150) {
      EXPECT_NEAR(out.handle.position.x(), 1e-4 * i, 30e-4);
    }
  }
  EXPECT_EQ(out.status, HapticStatus::working);
  EXPECT_NEAR(out.handle.position.x(), 1e-4 * 999, 1e-12);
}

TEST(Guard, WaitsUntilTheFirstGoodSamples) {
  HapticGuard guard({});
  DeviceState nothing;
  for (int i = 0; i < 50; ++i) {
    const GuardedInput out = guard.check(nothing, 1e-3 * i, 1e-3);
    EXPECT_FALSE(out.has_pose);
    EXPECT_EQ(out.status, HapticStatus::waiting);
    EXPECT_EQ(out.share, 0);
  }
  GuardedInput out;
  for (int i = 50; i < 300; ++i) out = guard.check(sample_at(1e-3 * i, at(0.3, 0, 0)), 1e-3 * i, 1e-3);
  EXPECT_TRUE(out.has_pose);
  EXPECT_EQ(out.handle.position.x(), 0.3);  // no glide from nowhere
  EXPECT_EQ(out.status, HapticStatus::working);
}

TEST(Guard, ASlowDeviceIsNotSilent) {
  HapticGuard guard({});
  for (int i = 0; i < 1000; ++i) {
    const int sampled = i / 10 * 10;  // 100 Hz
    const GuardedInput out = guard.check(sample_at(1e-3 * sampled, at(1e-5 * sampled, 0, 0)), 1e-3 * i, 1e-3);
    if (i > 200) {
      EXPECT_EQ(out.status, HapticStatus::working) << i;
    }
    EXPECT_NEAR(out.motion[0], i % 10 == 0 && i > 0 ? 1e-4 : 0, 1e-12) << i;
  }
}

TEST(Guard, FingersAreKeptInRangeAndEveryStatusHasWords) {
  HapticGuard guard({});
  DeviceState sample;
  GuardedInput out;
  for (int i = 0; i < 300; ++i) {
    sample = sample_at(1e-3 * i, at(0, 0, 0));
    sample.opening = -2;
    sample.grip = -1;
    out = guard.check(sample, 1e-3 * i, 1e-3);
  }
  EXPECT_EQ(out.opening, 0);
  EXPECT_EQ(out.grip, 0);
  for (int s = 0; s <= static_cast<int>(HapticStatus::disconnected); ++s)
    EXPECT_FALSE(name_of(static_cast<HapticStatus>(s)).empty());
}

TEST(MockHand, WithoutForceItGoesWhereItWants) {
  MockHapticDevice device([](double t) { return at(t > 0.1 ? 0.02 : 0.0, 0, 0); });
  for (int i = 0; i < 3000; ++i) device.read();
  EXPECT_NEAR(device.handle().position.x(), 0.02, 1e-6);
  device.write({0, 1.5, 0}, {0, 0, 0.1});
  for (int i = 0; i < 3000; ++i) device.read();
  EXPECT_NEAR(device.handle().position.y(), 1.5 / 300, 1e-6);
  EXPECT_NEAR(twist_between(Pose(), device.handle())[5], 0.1, 1e-6);
}

}  // namespace
}  // namespace calot::test
