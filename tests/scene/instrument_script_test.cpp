// Between two moments of a script: smooth, through every key, within what the keys say, and through the port.
#include "calot/scene/instrument_script.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/meshes.h"

namespace calot::test {
namespace {

const Vec3 port(0.05, 0.02, 0.15);
constexpr double reach = 0.02;

InstrumentScript random_script(std::uint64_t seed) {
  Random random(seed);
  InstrumentScript script;
  double time = random.unit();
  for (int k = 0; k < 8; ++k, time += random.between(0.05, 1)) {
    InstrumentKey key;
    key.time = time;
    key.tip = Vec3(random.between(-0.05, 0.05), random.between(-0.05, 0.05), random.between(-0.02, 0.05));
    key.roll = random.between(-2, 2);
    key.opening = random.between(0, 1);
    key.grip = random.between(0, 5);
    key.energy = random.below(2) == 0;
    key.fire = random.below(2) == 0;
    script.keys.push_back(key);
  }
  return script;
}

Vec3 tip_of(const InstrumentInput& input) {
  return input.pose * Vec3(0, 0, reach);
}

TEST(InstrumentScript, GoesThroughEveryKeyAndThePort) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const InstrumentScript script = random_script(seed);
    for (const InstrumentKey& key : script.keys) {
      const InstrumentInput input = input_at(script, reach, port, key.time);
      EXPECT_LT((tip_of(input) - key.tip).norm(), 1e-12);
      EXPECT_NEAR(input.opening, key.opening, 1e-12);
      EXPECT_NEAR(input.grip, key.grip, 1e-12);
      EXPECT_EQ(input.energy, key.energy);
      EXPECT_EQ(input.fire, key.fire);
    }
    for (double t = 0; t < script.end() + 1; t += 0.01) {
      const InstrumentInput input = input_at(script, reach, port, t);
      EXPECT_NEAR(input.pose.rotation.norm(), 1, 1e-12);
      // The port lies on the axis.
      const Vec3 there = input.pose.inverse() * port;
      EXPECT_LT(there.head<2>().norm(), 1e-12);
      EXPECT_LT(there.z(), 0);
    }
  }
}

TEST(InstrumentScript, MovesWithoutLeapsAndNeverBeyondItsKeys) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const InstrumentScript script = random_script(seed);
    const double step = 1e-4;
    Vec3 before = tip_of(input_at(script, reach, port, 0)), speed = Vec3::Zero();
    Eigen::Quaterniond rotation = input_at(script, reach, port, 0).pose.rotation;
    std::size_t k = 0;
    for (double t = step; t < script.end() + 0.5; t += step) {
      const InstrumentInput input = input_at(script, reach, port, t);
      const Vec3 tip = tip_of(input), now = (tip - before) / step;
      // A leap in velocity would be as large as the velocity itself, centimetres a second; this is h times
      // acceleration.
      ASSERT_LT((now - speed).norm(), 0.03) << t;
      ASSERT_LT(input.pose.rotation.angularDistance(rotation), 0.02) << t;
      while (k + 1 < script.keys.size() && script.keys[k + 1].time < t) ++k;
      if (t > script.keys[0].time && k + 1 < script.keys.size()) {
        const InstrumentKey &a = script.keys[k], &b = script.keys[k + 1];
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_LE(tip[axis], std::max(a.tip[axis], b.tip[axis]) + 1e-12);
          ASSERT_GE(tip[axis], std::min(a.tip[axis], b.tip[axis]) - 1e-12);
        }
        ASSERT_LE(input.grip, std::max(a.grip, b.grip) + 1e-12);
        ASSERT_GE(input.grip, std::min(a.grip, b.grip) - 1e-12);
      }
      before = tip;
      speed = now;
      rotation = input.pose.rotation;
    }
    EXPECT_EQ(speed, Vec3(Vec3::Zero()));
  }
}

TEST(InstrumentScript, HoldsBeforeAndAfter) {
  const InstrumentScript script = random_script(3);
  EXPECT_LT((tip_of(input_at(script, reach, port, -5)) - script.keys.front().tip).norm(), 1e-12);
  EXPECT_LT((tip_of(input_at(script, reach, port, 1e4)) - script.keys.back().tip).norm(), 1e-12);
  EXPECT_EQ(input_at(script, reach, port, 1e4).fire, script.keys.back().fire);
  EXPECT_EQ(script.end(), script.keys.back().time);
}

TEST(InstrumentScript, SwitchesAtTheirMoment) {
  InstrumentScript script;
  for (int k = 0; k < 3; ++k) {
    InstrumentKey key;
    key.time = k;
    key.energy = k == 1;
    script.keys.push_back(key);
  }
  EXPECT_FALSE(input_at(script, reach, {}, 0.999).energy);
  EXPECT_TRUE(input_at(script, reach, {}, 1.0).energy);
  EXPECT_TRUE(input_at(script, reach, {}, 1.999).energy);
  EXPECT_FALSE(input_at(script, reach, {}, 2.0).energy);
}

TEST(InstrumentScript, WithoutAPortItPointsWhereItIsTold) {
  InstrumentScript script;
  InstrumentKey key;
  key.tip = Vec3(0.01, 0, 0);
  key.direction = Vec3(1, 0, 0);
  key.roll = 0.5;
  script.keys.push_back(key);
  const InstrumentInput input = input_at(script, reach, {}, 7);
  EXPECT_LT((input.pose.rotation * Vec3::UnitZ() - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((input.pose.position - Vec3(0.01 - reach, 0, 0)).norm(), 1e-12);
  // Rolled from level: x was horizontal.
  EXPECT_NEAR(std::abs((input.pose.rotation * Vec3::UnitX()).z()), std::sin(0.5), 1e-12);
  key.time = 1;
  key.direction = Vec3(0, 0, -1);
  script.keys.push_back(key);
  EXPECT_LT((input_at(script, reach, {}, 1).pose.rotation * Vec3::UnitZ() - Vec3(0, 0, -1)).norm(), 1e-12);
}

TEST(InstrumentScript, RecordedPosesTurnEvenly) {
  InstrumentScript script;
  InstrumentPoseKey a, b;
  b.time = 2;
  b.pose = {Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vec3::UnitX())), Vec3(0, 0.02, 0)};
  b.grip = 4;
  script.poses = {a, b};
  const InstrumentInput half = input_at(script, reach, {}, 1), end = input_at(script, reach, {}, 9);
  EXPECT_LT(half.pose.rotation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3::UnitX()))), 1e-7);
  EXPECT_NEAR(half.pose.position.y(), 0.01, 1e-15);
  EXPECT_NEAR(half.grip, 2, 1e-12);
  EXPECT_LT((end.pose.position - b.pose.position).norm(), 1e-15);
  script.poses.resize(1);
  EXPECT_EQ(input_at(script, reach, {}, 3).pose.position, Vec3(0, 0, 0));
}

}  // namespace
}  // namespace calot::test
