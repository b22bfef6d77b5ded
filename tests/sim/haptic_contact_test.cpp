// What is felt of a constraint set, against what springs in series and Coulomb's law give on paper.
#include <gtest/gtest.h>

#include "calot/sim/haptic_twist.h"
#include "tests/sim/haptic_walls.h"

namespace calot::test {
namespace {

TEST(HapticTwist, TakesOnePoseToTheOther) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const auto pose = [&] {
      Eigen::Vector4d q;
      for (int k = 0; k < 4; ++k) q[k] = random.between(-1, 1);
      return Pose{Eigen::Quaterniond(q.normalized()), Vec3(random.unit(), random.unit(), random.unit())};
    };
    const Pose a = pose(), b = pose(), c = moved(a, twist_between(a, b));
    EXPECT_LT((c.position - b.position).norm(), 1e-14);
    EXPECT_LT(c.rotation.angularDistance(b.rotation), 1e-7);
    EXPECT_LE(twist_between(a, b).tail<3>().norm(), M_PI + 1e-12);
  }
  Vector6 small;
  small << 0, 0, 0, 1e-9, -2e-9, 3e-9;
  EXPECT_LT((twist_between(Pose(), moved(Pose(), small)) - small).norm(), 1e-20);
}

TEST(HapticContact, AWallAndTheCouplingAreSpringsInSeries) {
  for (const double wall : {10.0, 800.0, 1e6})
    for (const double depth : {1e-4, 3e-3, 0.02}) {
      HapticContact contact;
      ASSERT_TRUE(contact.take(wall_set(at(0, 0, 0.001), wall, 0), {1000, 1}));
      const auto answer = contact.solve(at(0, 0, -depth), 500);
      const double force = depth / (1 / wall + 1 / 1000.0);
      EXPECT_NEAR(1000 * answer.offset[2], force, 1e-5 * force);
      EXPECT_NEAR(contact.forces()[0], force, 1e-5 * force);
      EXPECT_LT(answer.offset.head<2>().norm() + answer.offset.tail<3>().norm(), 1e-12);
    }
}

TEST(HapticContact, NothingIsFeltAboveTheWall) {
  HapticContact contact;
  ASSERT_TRUE(contact.take(wall_set(at(0, 0, -0.002), 500, 0.3), {}));
  EXPECT_EQ(contact.solve(at(0.1, 0, 1e-6), 50).offset, Vector6(Vector6::Zero()));
  EXPECT_GT(contact.solve(at(0.1, 0, -1e-4), 50).offset[2], 0);
}

// Two points ±a along x under a tool pressed down and turned about y: each carries k z, so that the tool gives
// 2 k a² / (2 k a² + turning stiffness) of the turn back.
TEST(HapticContact, TurnsAgainstAWallGiveTorque) {
  const double wall = 400, arm = 0.01, turning = 0.05, stiffness = 1000, depth = 5e-3, turn = 0.02;
  HapticContact contact;
  ASSERT_TRUE(contact.take(wall_set(at(0, 0, 0), wall, 0, {{arm, 0, 0}, {-arm, 0, 0}}), {stiffness, turning}));
  const Pose wanted{Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vec3::UnitY())), Vec3(0, 0, -depth)};
  const auto answer = contact.solve(wanted, 1000);
  const double each = 2 * wall * arm * arm;
  EXPECT_NEAR(turning * answer.offset[4], -turn * turning * each / (turning + each), 1e-6);
  EXPECT_NEAR(stiffness * answer.offset[2], depth / (1 / stiffness + 1 / (2 * wall)), 1e-4);
}

TEST(HapticContact, HeldTissuePullsAsItsSpringSays) {
  HapticConstraints set = wall_set(at(0, 0, 0.5), 1e3, 0);  // the wall is far away
  set.held_wrench << 0.5, 0, 0, 0, 0, 0;
  set.held_stiffness.diagonal() << 250, 250, 250, 0, 0, 0;
  HapticContact contact;
  ASSERT_TRUE(contact.take(set, {1000, 1}));
  // Balance: 1000 (d − t) + 0.5 − 250 t = 0.
  const auto answer = contact.solve(at(0.004, 0, 0.5), 50);
  EXPECT_NEAR(answer.offset[0], (4 + 0.5) / 1250 - 0.004, 1e-12);
  // The same without any contact.
  set.problem = {};
  set.motion.resize(0, 6);
  set.wrench.resize(6, 0);
  ASSERT_TRUE(contact.take(set, {1000, 1}));
  EXPECT_NEAR(contact.solve(at(0.004, 0, 0.5), 50).offset[0], (4 + 0.5) / 1250 - 0.004, 1e-12);
}

TEST(HapticContact, ForcesStayInTheirConesEvenAfterOneIteration) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const double friction = random.between(0, 1);
    std::vector<Vec3> points;
    for (std::size_t k = 0; k < 1 + random.below(5); ++k)
      points.emplace_back(random.between(-0.01, 0.01), random.between(-0.01, 0.01), random.between(-0.01, 0.01));
    HapticContact contact;
    ASSERT_TRUE(contact.take(wall_set(at(0, 0, 0), random.between(100, 1e4), friction, points), {}));
    for (int tick = 0; tick < 5; ++tick) {
      contact.solve(at(random.between(-0.02, 0.02), random.between(-0.02, 0.02), random.between(-0.01, 0.005)), 1);
      for (Eigen::Index c = 0; c < contact.forces().size(); c += 3) {
        EXPECT_GE(contact.forces()[c], 0);
        EXPECT_LE(contact.forces().segment<2>(c + 1).norm(), friction * contact.forces()[c] * (1 + 1e-12));
      }
    }
  }
}

TEST(HapticContact, SlidingResistsWithTheFrictionsShare) {
  const double friction = 0.4;
  HapticContact contact;
  ASSERT_TRUE(contact.take(wall_set(at(0, 0, 0), 500, friction), {1000, 1}));
  const auto answer = contact.solve(at(0.03, 0, -0.004), 500);
  EXPECT_NEAR(answer.offset[0] / answer.offset[2], -friction, 1e-4);
  // Little to the side: it sticks, both springs in series again.
  const auto stuck = contact.solve(at(1e-4, 0, -0.004), 500);
  EXPECT_NEAR(1000 * stuck.offset[0], -1e-4 / (1 / 500.0 + 1 / 1000.0), 1e-5);
}

TEST(HapticContact, RefusesSetsWithoutSense) {
  const HapticConstraints sound = wall_set(at(0, 0, 0), 500, 0.2);
  const auto refused = [&](const auto& spoil) {
    HapticConstraints set = sound;
    spoil(set);
    HapticContact contact;
    EXPECT_TRUE(contact.take(sound, {}));
    const bool taken = contact.take(set, {});
    return !taken && contact.solve(at(0, 0, -0.01), 10).offset.isZero(0);
  };
  const double nan = std::nan("");
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_TRUE(refused([&](auto& s) { s.problem.delassus(1, 1) = nan; }));
  EXPECT_TRUE(refused([&](auto& s) { s.problem.free_motion[0] = HUGE_VAL; }));
  EXPECT_TRUE(refused([&](auto& s) { s.problem.friction[0] = -1; }));
  EXPECT_TRUE(refused([&](auto& s) { s.problem.friction.push_back(0.1); }));
  EXPECT_TRUE(refused([&](auto& s) { s.motion(2, 3) = nan; }));
  EXPECT_TRUE(refused([&](auto& s) { s.wrench.resize(6, 2); }));
  EXPECT_TRUE(refused([&](auto& s) { s.pose.position.x() = nan; }));
  EXPECT_TRUE(refused([&](auto& s) { s.held_wrench[5] = nan; }));
  EXPECT_TRUE(refused([&](auto& s) { s.held_stiffness(0, 0) = -2000; }));
}

}  // namespace
}  // namespace calot::test
