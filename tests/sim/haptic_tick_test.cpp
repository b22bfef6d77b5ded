// The whole tick, without a clock: what is shown, how sets follow each other, limits, passivity.
#include "calot/sim/haptic_tick.h"

#include <gtest/gtest.h>

#include "calot/sim/haptic_mock.h"
#include "calot/sim/haptic_twist.h"
#include "tests/sim/haptic_walls.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

TEST(HapticTick, PressingOnAWallGivesTheSeriesOfBothSprings) {
  HapticTick tick(free_options(), strong_device());
  double time = 0;
  ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 500, 0.1)));
  for (int i = 0; i < 3; ++i) {
    const HapticOutput out = settled(tick, at(0, 0, -0.003), time, 200);
    ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 500, 0.1)));
    EXPECT_NEAR(out.force.z(), 0.003 / (1 / 500.0 + 1 / 1000.0), 1e-6);
    EXPECT_NEAR(out.input.pose.position.z(), -0.003 + out.force.z() / 1000, 1e-9);
    EXPECT_EQ(out.status, HapticStatus::working);
  }
}

TEST(HapticTick, TorqueIsAboutTheHandle) {
  HapticOptions options = free_options();
  options.tool_in_handle = at(0.02, 0, -0.3);
  HapticTick tick(options, strong_device());
  double time = 0;
  ASSERT_TRUE(tick.take(wall_set(at(0.02, 0, 0), 500, 0)));
  const HapticOutput out = settled(tick, at(0, 0, 0.297), time, 200);
  EXPECT_NEAR(out.force.z(), 1.0, 1e-6);
  EXPECT_LT((out.torque - Vec3(0.02, 0, -0.3).cross(out.force)).norm(), 1e-9);
  EXPECT_NEAR(out.torque.y(), -0.02, 1e-8);
}

TEST(HapticTick, TheShownForceStaysInTheCone) {
  const double friction = 0.3;
  HapticTick tick(free_options(), strong_device());
  LateWorld world(800, friction, 16, 5);
  double time = 0;
  for (int i = 0; i < 3000; ++i, time += 1e-3) {
    const HapticOutput out = tick.run(sample_at(time, at(0.02 * std::sin(3 * time), 0.01 * time, -0.004)), time);
    world.follow(tick, out);
    EXPECT_LE(out.force.head<2>().norm(), friction * out.force.z() + 1e-9);
  }
}

// A set that says something else every time, at the pace of the world: the force changes gradually.
TEST(HapticTick, SuccessiveSetsGiveNoKick) {
  HapticTick tick(free_options(), strong_device());
  double time = 0, largest = 0;
  Vec3 before = Vec3::Zero();
  bool soft = false;
  for (int i = 0; i < 1000; ++i, time += 1e-3) {
    if (i % 17 == 0 && tick.wants_set()) {
      ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), (soft = !soft) ? 200 : 2000, 0)));
    }
    const HapticOutput out = tick.run(sample_at(time, at(0, 0, -0.006)), time);
    if (i > 200) largest = std::max(largest, (out.force - before).norm());
    before = out.force;
  }
  const double jump = 0.006 / (1 / 2000.0 + 1e-3) - 0.006 / (1 / 200.0 + 1e-3);
  EXPECT_GT(largest, jump / 40);
  EXPECT_LT(largest, 1.05 * jump / 16);
}

TEST(HapticTick, TheFirstSetComesInGraduallyAndABlendIsNotDisturbed) {
  HapticTick tick(free_options(), strong_device());
  double time = 0;
  settled(tick, at(0, 0, -0.006), time);
  ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
  EXPECT_FALSE(tick.wants_set());
  EXPECT_FALSE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
  const double first = settled(tick, at(0, 0, -0.006), time, 1).force.z();
  EXPECT_GT(first, 0);
  EXPECT_LT(first, 3.0 / 15);
  EXPECT_NEAR(settled(tick, at(0, 0, -0.006), time, 20).force.z(), 3.0, 1e-6);
  EXPECT_TRUE(tick.wants_set());
}

TEST(HapticTick, AWorldThatStopsIsSaidAndFades) {
  HapticTick tick(free_options(), strong_device());
  double time = 0;
  settled(tick, at(0, 0, -0.006), time);
  ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
  HapticOutput out = settled(tick, at(0, 0, -0.006), time, 200);
  EXPECT_FALSE(out.stale);
  EXPECT_NEAR(out.force.z(), 3.0, 1e-6);
  out = settled(tick, at(0, 0, -0.006), time, 200);
  EXPECT_TRUE(out.stale);
  EXPECT_EQ(out.force, Vec3(Vec3::Zero()));
  EXPECT_NEAR(out.input.pose.position.z(), -0.003, 1e-6);  // the instrument still doesn't enter the wall
  ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
  out = settled(tick, at(0, 0, -0.006), time, 200);
  EXPECT_FALSE(out.stale);
  EXPECT_NEAR(out.force.z(), 3.0, 1e-6);
}

TEST(HapticTick, ASetWithoutSenseIsRefusedAndSaid) {
  HapticTick tick(free_options(), strong_device());
  double time = 0;
  HapticConstraints wrong = wall_set(at(0, 0, 0), 1000, 0);
  wrong.problem.free_motion[0] = std::nan("");
  ASSERT_TRUE(tick.take(wrong));
  const HapticOutput out = settled(tick, at(0, 0, -0.006), time, 200);
  EXPECT_TRUE(out.refused_set);
  EXPECT_EQ(out.force, Vec3(Vec3::Zero()));
  ASSERT_TRUE(tick.take(wall_set(at(0, 0, 0), 1000, 0)));
  EXPECT_FALSE(settled(tick, at(0, 0, -0.006), time, 200).refused_set);
}

double anything(Random& random) {
  switch (random.below(12)) {
    case 0:
      return std::nan("");
    case 1:
      return HUGE_VAL;
    case 2:
      return -1e300;
    case 3:
      return random.between(-1e3, 1e3);
    default:
      return random.between(-0.01, 0.01);
  }
}

// Whatever device and world say: the limits hold, nothing that isn't finite goes out, and the rate too.
TEST(HapticTick, LimitsHoldForEveryInput) {
  Random random(9);
  for (int run = 0; run < 20; ++run) {
    HapticOptions options;
    options.limits = {random.between(0.5, 6),
                      random.between(0.01, 0.3),
                      random.between(100, 3000),
                      random.between(5, 100),
                      0.02,
                      0.5,
                      0.01};
    const DeviceLimits device{3.0, 0.1, 2000};
    HapticTick tick(options, device);
    const double most = std::min(options.limits.max_force, 3.0), turn = std::min(options.limits.max_torque, 0.1);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    bool any = false;
    for (int i = 0; i < 1000; ++i) {
      const double time = 1e-3 * i;
      const bool wild = i % 300 > 200 && random.below(4) == 0;
      Pose handle = at(0.01 * std::sin(40 * time), 0, -0.02 + 0.02 * std::sin(10 * time));
      if (wild) handle.position[static_cast<int>(random.below(3))] = anything(random);
      if (wild && random.below(8) == 0) handle.rotation.coeffs()[0] = anything(random);
      if (i % 10 == 0 && tick.wants_set()) {
        HapticConstraints set = wall_set(at(0, 0, 0), 3000, 0.5, {{0.01, 0, 0}, {-0.01, 0.01, 0}});
        if (random.below(4) == 0) set.problem.free_motion[0] = anything(random);
        if (random.below(4) == 0) set.held_wrench[static_cast<int>(random.below(6))] = anything(random);
        ASSERT_TRUE(tick.take(set));
      }
      const HapticOutput out =
          tick.run(sample_at(wild && random.below(8) == 0 ? anything(random) : time, handle), time);
      ASSERT_TRUE(out.force.allFinite() && out.torque.allFinite());
      ASSERT_LE(out.force.norm(), most);
      ASSERT_LE(out.torque.norm(), turn);
      ASSERT_LE((out.force - force).norm(), options.limits.force_rate * 1e-3 * (1 + 1e-9));
      ASSERT_LE((out.torque - torque).norm(), options.limits.torque_rate * 1e-3 * (1 + 1e-9));
      ASSERT_TRUE(is_finite(out.input.pose));
      force = out.force;
      torque = out.torque;
      any = any || force.norm() > 0.01;
    }
    EXPECT_TRUE(any);
  }
}

TEST(HapticTick, OptionsOutOfRangeAreRefused) {
  const auto message = [](const auto& spoil, DeviceLimits device = {3, 0.1, 2000}) {
    HapticOptions options;
    spoil(options);
    return message_of([&] { HapticTick tick(options, device); });
  };
  EXPECT_EQ(message([](auto&) {}), "");
  EXPECT_NE(message([](auto& o) { o.period = 0; }), "");
  EXPECT_NE(message([](auto& o) { o.coupling.stiffness = std::nan(""); }), "");
  EXPECT_NE(message([](auto& o) { o.damping = -1; }), "");
  EXPECT_NE(message([](auto& o) { o.iterations = 0; }), "");
  EXPECT_NE(message([](auto& o) { o.limits.max_force = -1; }), "");
  EXPECT_NE(message([](auto& o) { o.limits.bank = 0; }), "");
  EXPECT_NE(message([](auto& o) { o.guard.fade = 0; }), "");
  EXPECT_NE(message([](auto&) {}, {3, 0.1, 0}).find("haptic options"), std::string::npos);
}

/// Energy that a sequence of shown wrenches gave to a handle that was moved: each stays until the next tick.
class Meter {
 public:
  void tick(const Pose& handle, const HapticOutput& out) {
    const double given =
        !any_ ? 0
              : force_.dot(handle.position - handle_.position) + torque_.dot(twist_between(handle_, handle).tail<3>());
    energy_ += given;
    taken_ += std::max(0.0, -given);
    any_ = true;
    handle_ = handle;
    force_ = out.force;
    torque_ = out.torque;
  }
  [[nodiscard]] double out() const { return energy_; }  ///< less what was taken in [J]
  [[nodiscard]] double taken() const { return taken_; }

 private:
  bool any_ = false;
  Pose handle_;
  Vec3 force_, torque_;
  double energy_ = 0, taken_ = 0;
};

/// A smooth motion around a place, by a few sines.
class RandomMotion {
 public:
  RandomMotion(std::uint64_t seed, double size, double fastest) {
    Random random(seed);
    for (Wave& wave : waves_)
      for (int axis = 0; axis < 6; ++axis) {
        wave.rate[axis] = random.between(1, fastest);
        wave.phase[axis] = random.between(0, 6.28);
        wave.size[axis] = random.between(0, size) * (axis < 3 ? 1 : 10);
      }
  }
  [[nodiscard]] Pose operator()(double time) const {
    Vector6 twist = Vector6::Zero();
    for (const Wave& wave : waves_)
      twist.array() += wave.size.array() * (wave.rate.array() * time + wave.phase.array()).sin();
    return moved(Pose(), twist);
  }

 private:
  struct Wave {
    Vector6 rate, phase, size;
  };
  std::array<Wave, 3> waves_;
};

// Whatever the hand does, and however late the world is, no more energy comes out than went in and the reserve.
TEST(HapticPassivity, GivesOutNoMoreThanWasPutIn) {
  double gated = 0, taken = 0;
  for (std::uint64_t run = 0; run < 24; ++run) {
    const HapticOptions options;
    HapticTick tick(options, {8.0, 0.5, 3000});
    LateWorld world(run % 2 == 0 ? 3000 : 300, 0.1 * static_cast<double>(run % 5), 16, static_cast<int>(run * 7 % 60));
    const RandomMotion motion(run, 0.012, run % 3 == 0 ? 60 : 15);
    Meter meter;
    double largest = -1;
    for (int i = 0; i < 4000; ++i) {
      const double time = 1e-3 * i;
      const HapticOutput out = tick.run(sample_at(time, motion(time)), time);
      meter.tick(motion(time), out);
      world.follow(tick, out);
      gated += out.energy_limited ? 1 : 0;
      largest = std::max(largest, meter.out() - (options.limits.reserve + time * options.limits.refill));
    }
    EXPECT_LT(largest, 0.1 * options.limits.reserve) << run;
    taken += meter.taken();
  }
  EXPECT_GT(gated, 0);
  EXPECT_GT(taken, 5);  // there was much to give
}

// A world that pushes and pulls on its own has the reserve and its refill, not more.
TEST(HapticPassivity, AWorldThatFeedsEnergyInIsHeldBack) {
  const HapticOptions options;
  HapticTick tick(options, {8.0, 0.5, 3000});
  Meter meter;
  bool gated = false;
  double ungated = 0;
  Vec3 before = Vec3::Zero();
  for (int i = 0; i < 5000; ++i) {
    const double time = 1e-3 * i, x = 0.01 * std::sin(20 * time);
    const HapticOutput out = tick.run(sample_at(time, at(x, 0, 0)), time);
    meter.tick(at(x, 0, 0), out);
    // A force of 2 N along the motion, whichever way it goes.
    HapticConstraints set = wall_set(at(0, 0, 1), 100, 0);
    set.held_wrench[0] = 2.0 * (std::cos(20 * time) > 0 ? 1 : -1);
    ungated += set.held_wrench[0] * (x - before.x());
    before.x() = x;
    if (tick.wants_set()) {
      ASSERT_TRUE(tick.take(set));
    }
    gated = gated || out.energy_limited;
    ASSERT_LT(meter.out(), options.limits.reserve + 5 * options.limits.refill + 0.1 * options.limits.reserve) << i;
  }
  EXPECT_TRUE(gated);
  EXPECT_GT(ungated, 1.0);  // what it would have been: 2 N over 40 mm, 3.2 times a second
}

struct WallRun {
  double deepest = 0, last_speed = 0, last_force = 0, energy = 0;
};

WallRun push_on_wall(double wall, int late, double friction, const MockHand& hand = {}) {
  MockHapticDevice device([](double t) { return at(0, 0, 0.01 - 0.03 * std::min(1.0, 5 * t)); }, hand);
  HapticTick tick(HapticOptions(), device.limits());
  LateWorld world(wall, friction, 16, late);
  Meter meter;
  WallRun run;
  for (int i = 0; i < 4000; ++i) {
    const DeviceState sample = device.read();
    const HapticOutput out = tick.run(sample, sample.time);
    device.write(out.force, out.torque);
    meter.tick(sample.handle, out);
    world.follow(tick, out);
    run.deepest = std::max(run.deepest, -device.handle().position.z());
    if (i > 3000) run.last_speed = std::max(run.last_speed, device.velocity().norm());
    run.last_force = out.force.z();
  }
  run.energy = meter.out();
  return run;
}

// The hand pushes 20 mm into a wall: it comes to rest where hand, coupling and wall are in balance.
TEST(HapticPassivity, AHandOnAStiffWallComesToRest) {
  for (const double wall : {500.0, 3000.0, 1e5})
    for (const int late : {0, 16, 50}) {
      const WallRun run = push_on_wall(wall, late, 0.2);
      const double series = 1 / (1 / wall + 1 / 1000.0 + 1 / 300.0);
      EXPECT_NEAR(run.last_force, 0.02 * series, 0.02) << wall << ' ' << late;
      EXPECT_LT(run.deepest, 0.02) << wall << ' ' << late;
      EXPECT_LT(run.last_speed, 1e-3) << wall << ' ' << late;
      EXPECT_LT(run.energy, 0.001) << wall << ' ' << late;
    }
}

TEST(HapticPassivity, SoDoesAHandThatHardlyDamps) {
  MockHand hand;
  hand.damping = 0.3;
  hand.friction = 0.5;
  const WallRun run = push_on_wall(1e5, 16, 0.2, hand);
  EXPECT_LT(run.deepest, 0.03);
  EXPECT_LT(run.last_speed, 0.02);
  EXPECT_LT(run.energy, 0.02 + 4 * 0.01);
}

TEST(HapticTick, SameInputSameBytes) {
  const auto play = [] {
    HapticTick tick(HapticOptions(), {8.0, 0.5, 3000});
    LateWorld world(2000, 0.3, 16, 9);
    const RandomMotion motion(3, 0.01, 30);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 1000; ++i) {
      const HapticOutput out = tick.run(sample_at(1e-3 * i, motion(1e-3 * i)), 1e-3 * i);
      world.follow(tick, out);
      sum += (1 + i % 7) * out.force;
    }
    return sum;
  };
  EXPECT_EQ(play(), play());
}

}  // namespace
}  // namespace calot::test
