// The hand against closed forms: the port holds the axis, the fulcrum inverts, forces do the same work at both ends.
#include "calot/device/hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calot/device/ported_device.h"
#include "calot/sim/haptic_loop.h"
#include "calot/sim/haptic_mock.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

const InstrumentGeometry grasper = instrument_geometry(InstrumentKind::bowel_grasper);
const Vec3 port(0.02, -0.01, 0.15);

HandOptions fast(HandMap map) {
  HandOptions options;
  options.map = map;
  options.port = port;
  options.max_speed = options.max_roll_speed = options.max_jaw_speed = 1e9;
  return options;
}

/// Through the port straight down, its tip 0.15 m deep.
Pose start() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Vec3::UnitX())), port - Vec3(0, 0, 0.15 - reach_of(grasper))};
}

DeviceState at(const Vec3& position, const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity()) {
  DeviceState state;
  state.connected = true;
  state.handle = {rotation, position};
  return state;
}

Eigen::Quaterniond turned(double angle, const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

double distance_to_axis(const Pose& pose) {
  const Vec3 axis = pose.rotation * Vec3::UnitZ();
  return (port - pose.position).cross(axis).norm() / axis.norm();
}

TEST(Hand, TipFollowsAndRollsAboutItsAxis) {
  Hand hand(grasper, fast(HandMap::tip), start());
  EXPECT_NEAR(hand.depth(), 0.15, 1e-12);
  const Vec3 tip = hand.tip(), device(1, 2, 3);
  (void)hand.update(at(device), {}, 0.01);
  EXPECT_NEAR((hand.tip() - tip).norm(), 0, 1e-12);
  const Vec3 x = hand.input().pose.rotation * Vec3::UnitX();
  const Vec3 way(0.03, -0.02, -0.01);
  (void)hand.update(at(device + way, turned(0.5, Vec3::UnitZ())), {}, 0.01);
  EXPECT_NEAR((hand.tip() - tip - way).norm(), 0, 1e-12);
  EXPECT_LE(distance_to_axis(hand.input().pose), 1e-15);
  // Back in place it is turned about its own axis by what the handle was turned.
  (void)hand.update(at(device, turned(0.5, Vec3::UnitZ())), {}, 0.01);
  const Vec3 wanted = turned(0.5, hand.axis()) * x;
  EXPECT_NEAR((hand.input().pose.rotation * Vec3::UnitX() - wanted).norm(), 0, 1e-12);
  EXPECT_FALSE(hand.at_limit());
}

TEST(Hand, HandleOutsideMovesTheTipTheOtherWay) {
  HandOptions options = fast(HandMap::handle);
  options.shaft_length = 0.40;  // 0.25 outside
  Hand hand(grasper, options, start());
  (void)hand.update(at(Vec3::Zero()), {}, 0.01);
  const double right = 0.05;
  (void)hand.update(at({right, 0, 0}), {}, 0.01);
  const double outside = std::hypot(0.25, right), depth = 0.40 - outside;
  EXPECT_NEAR((hand.tip() - (port + depth / outside * Vec3(-right, 0, -0.25))).norm(), 0, 1e-12);
  // Pushed 30 mm along the shaft it is 30 mm deeper.
  (void)hand.update(at({0, 0, -0.03}), {}, 0.01);
  EXPECT_NEAR(hand.depth(), 0.18, 1e-12);
  // A handle that turns with the shaft carries its roll along exactly.
  const Vec3 tilt(0.3, -0.2, -1), axis = tilt.normalized();
  const Eigen::Quaterniond swing = Eigen::Quaterniond::FromTwoVectors(-Vec3::UnitZ(), axis);
  const Eigen::Quaterniond turn = turned(2.0, axis) * swing;
  (void)hand.update(at(0.25 * (-axis) - Vec3(0, 0, 0.25), turn), {}, 0.01);
  EXPECT_NEAR(hand.input().pose.rotation.angularDistance(turn * start().rotation), 0, 1e-7);
}

TEST(Hand, AxisPassesThroughThePortWhateverComes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const HandMap map : {HandMap::tip, HandMap::handle})
    for (const bool absolute : {false, true}) {
      HandOptions options = fast(map);
      options.absolute = absolute;
      options.max_speed = 2;
      options.origin = map == HandMap::tip ? Vec3(0, 0, 0) : Vec3(port + Vec3(0, 0, 0.25));
      Hand hand(grasper, options, start());
      double worst = 0;
      for (int i = 0; i < 3000; ++i) {
        const double reach = i % 10 == 0 ? 1.0 : 0.1;
        const Vec3 place = reach * Vec3(any(random), any(random), any(random));
        const Vec3 about(any(random), any(random), any(random));
        const Pose pose = hand.update(at(place, turned(4 * any(random), about)), {i % 37 == 0, false}, 0.01).pose;
        worst = std::max(worst, distance_to_axis(pose));
        const double tilt = std::acos(std::min(1.0, hand.axis().dot(-Vec3::UnitZ())));
        ASSERT_LE(tilt, options.max_tilt + 1e-9);
        ASSERT_GE(hand.depth(), options.min_depth - 1e-12);
        ASSERT_LE(hand.depth(), options.max_depth + 1e-12);
        ASSERT_NEAR(pose.rotation.norm(), 1, 1e-12);
      }
      EXPECT_LE(worst, 1e-12);
    }
}

TEST(Hand, SpeedIsLimitedAndTheAimReached) {
  HandOptions options = fast(HandMap::tip);
  options.max_speed = 0.2;
  options.max_roll_speed = 2;
  options.max_jaw_speed = 1;
  Hand hand(grasper, options, start());
  DeviceState state = at(Vec3::Zero());
  (void)hand.update(state, {}, 0.01);
  const Vec3 from = hand.tip();
  state = at({0.05, 0, 0}, turned(1.0, Vec3::UnitZ()));
  state.opening = grasper.max_opening;
  for (int i = 1; i <= 60; ++i) {
    const Vec3 before = hand.tip();
    const double opening = hand.input().opening;
    (void)hand.update(state, {}, 0.01);
    EXPECT_LE((hand.tip() - before).norm(), 0.2 * 0.01 + 1e-12);
    EXPECT_LE(hand.input().opening - opening, 0.01 + 1e-12);
    EXPECT_NEAR(std::min((hand.tip() - from).norm(), 0.05), std::min(0.002 * i, 0.05), 1e-9);
  }
  EXPECT_NEAR((hand.tip() - from - Vec3(0.05, 0, 0)).norm(), 0, 1e-12);
}

TEST(Hand, ClutchRecentres) {
  Hand hand(grasper, fast(HandMap::tip), start());
  (void)hand.update(at(Vec3::Zero()), {}, 0.01);
  const Vec3 from = hand.tip();
  (void)hand.update(at({0.02, 0, 0}), {}, 0.01);
  (void)hand.update(at({-0.5, 0.3, 0}, turned(1, Vec3::UnitX())), {true, false}, 0.01);
  EXPECT_NEAR((hand.tip() - from - Vec3(0.02, 0, 0)).norm(), 0, 1e-12);
  (void)hand.update(at({-0.5, 0.3, 0}), {}, 0.01);
  (void)hand.update(at({-0.48, 0.3, 0}), {}, 0.01);
  EXPECT_NEAR((hand.tip() - from - Vec3(0.04, 0, 0)).norm(), 0, 1e-12);
}

TEST(Hand, ScaleAndAxesOfTheDevice) {
  HandOptions options = fast(HandMap::tip);
  options.scale = 0.25;
  options.axes = turned(M_PI / 2, Vec3::UnitZ());
  Hand hand(grasper, options, start());
  (void)hand.update(at(Vec3::Zero()), {}, 0.01);
  const Vec3 from = hand.tip();
  (void)hand.update(at({0.04, 0, 0}), {}, 0.01);
  EXPECT_NEAR((hand.tip() - from - Vec3(0, 0.01, 0)).norm(), 0, 1e-12);
}

TEST(Hand, AtTheBorderTheWayBackBeginsAtOnce) {
  Hand hand(grasper, fast(HandMap::tip), start());
  (void)hand.update(at(Vec3::Zero()), {}, 0.01);
  (void)hand.update(at({0, 0, -0.5}), {}, 0.01);
  EXPECT_TRUE(hand.at_limit());
  EXPECT_NEAR(hand.depth(), hand.options().max_depth, 1e-12);
  (void)hand.update(at({0, 0, -0.49}), {}, 0.01);
  EXPECT_NEAR(hand.depth(), hand.options().max_depth - 0.01, 1e-12);
  EXPECT_FALSE(hand.at_limit());
}

TEST(Hand, JawsAndRatchet) {
  Hand hand(grasper, fast(HandMap::tip), start());
  DeviceState state = at(Vec3::Zero());
  state.opening = 10;
  EXPECT_EQ(hand.update(state, {}, 0.01).opening, grasper.max_opening);
  state.opening = 0.1;
  state.grip = 1e3;
  EXPECT_EQ(hand.update(state, {false, true}, 0.01).grip, grasper.max_grip);
  state.opening = 0.4;
  state.grip = 0;
  EXPECT_DOUBLE_EQ(hand.update(state, {false, true}, 0.01).opening, 0.1);
  EXPECT_EQ(hand.input().grip, grasper.max_grip);
  EXPECT_DOUBLE_EQ(hand.update(state, {}, 0.01).opening, 0.4);
  EXPECT_EQ(hand.input().grip, 0);
}

TEST(Hand, FaultsHoldTheInstrumentAndItsJaws) {
  Hand hand(grasper, fast(HandMap::tip), start());
  DeviceState state = at(Vec3::Zero());
  state.grip = 3;
  state.pedal = state.button = true;
  EXPECT_TRUE(hand.update(state, {}, 0.01).energy && hand.input().fire);
  const Vec3 from = hand.tip();
  for (const int fault : {0, 1, 2}) {
    DeviceState bad = at({0.05, 0, 0});
    bad.pedal = true;
    if (fault == 0) bad.connected = false;
    if (fault == 1) bad.handle.position.y() = NAN;
    if (fault == 2) bad.handle.rotation.coeffs().setZero();
    EXPECT_FALSE(hand.update(bad, {}, 0.01).energy || hand.input().fire);
    EXPECT_EQ(hand.input().grip, 3);
    EXPECT_EQ((hand.tip() - from).norm(), 0);
  }
  (void)hand.update(at({0.05, 0, 0}), {}, 0.01);
  EXPECT_NEAR((hand.tip() - from).norm(), 0, 1e-12);  // took hold anew, no jump
}

TEST(Hand, AnotherInstrumentComesToTheSamePlace) {
  Hand hand(grasper, fast(HandMap::tip), start());
  const Vec3 tip = hand.tip();
  const InstrumentGeometry hook = instrument_geometry(InstrumentKind::hook);
  hand.change(hook);
  EXPECT_NEAR((hand.input().pose * Vec3(0, 0, reach_of(hook)) - tip).norm(), 0, 1e-12);
  DeviceState state = at(Vec3::Zero());
  state.opening = 1;
  EXPECT_EQ(hand.update(state, {}, 1).opening, 0);
}

TEST(Hand, PosesAreBroughtThroughAPort) {
  const Pose off{turned(0.3, {1, 2, 0}), Vec3(0.01, 0.02, 0.03)};
  const Pose through = through_port(off, 0.02, port);
  EXPECT_LE(distance_to_axis(through), 1e-15);
  EXPECT_NEAR((through * Vec3(0, 0, 0.02) - off * Vec3(0, 0, 0.02)).norm(), 0, 1e-12);
}

// Both ends do the same work for any small motion of the handle.
TEST(Hand, ForcesGoThroughTheLever) {
  for (const HandMap map : {HandMap::tip, HandMap::handle}) {
    HandOptions options = fast(map);
    options.scale = 0.5;
    options.axes = turned(0.7, {1, 1, 0});
    Hand hand(grasper, options, start());
    const Vec3 home(0.1, 0.2, 0.3);
    (void)hand.update(at(home), {}, 0.01);
    // Tilted first; a real handle has turned with the shaft then, so the hand takes hold of it anew.
    (void)hand.update(at(home + Vec3(0.03, 0.02, -0.02)), {}, 0.01);
    (void)hand.update(at(home), {true, false}, 0.01);
    (void)hand.update(at(home), {}, 0.01);
    const Pose before = hand.input().pose;
    const Vec3 axis = options.axes.conjugate() * hand.axis();
    const HandWrench on{{1, -2, 0.5}, {0.02, 0.01, -0.03}}, felt = hand.at_handle(on);
    constexpr double eps = 1e-6;
    for (int d = 0; d < 4; ++d) {
      const Vec3 shift = d < 3 ? Vec3(eps * Vec3::Unit(d)) : Vec3::Zero();
      const Vec3 about = map == HandMap::tip ? Vec3(Vec3::UnitZ()) : axis;
      const Vec3 turn = d == 3 ? Vec3(eps * about) : Vec3::Zero();
      Hand moved = hand;
      (void)moved.update(at(home + shift, d == 3 ? turned(eps, about) : Eigen::Quaterniond::Identity()), {}, 0.01);
      const Pose after = moved.input().pose;
      const Eigen::AngleAxisd way(after.rotation * before.rotation.conjugate());
      const double work =
          on.force.dot(after.position - before.position) + on.torque.dot(Vec3(way.angle() * way.axis()));
      EXPECT_NEAR(work, felt.force.dot(shift) + felt.torque.dot(turn), 1e-4 * eps) << "motion " << d;
    }
  }
}

TEST(Hand, SaysWhatIsWrong) {
  HandOptions options = fast(HandMap::tip);
  options.max_tilt = 2;
  EXPECT_EQ(message_of([&] { Hand(grasper, options, start()); }),
            "hand: the largest tilt is out of range; give 0.1 to 1.5 rad");
  options = fast(HandMap::tip);
  options.min_depth = 0.4;
  EXPECT_NE(message_of([&] { Hand(grasper, options, start()); }).find("0 < min_depth"), std::string::npos);
}

// In the haptic loop a device behind a port pivots too, and the force that comes back is within its limits.
TEST(PortedDevice, PivotsAndKeepsTheLimits) {
  MockHapticDevice mock([](double time) {
    return Pose{Eigen::Quaterniond::Identity(), Vec3(0.03 * std::sin(6 * time), 0.02 * std::cos(5 * time), 0)};
  });
  PortedDevice device(mock, grasper, fast(HandMap::handle), start());
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    const DeviceState state = device.read();
    ASSERT_TRUE(state.connected);
    EXPECT_LE(distance_to_axis(state.handle), 1e-12);
    device.write({0, 8, 0}, {0, 0, 0.3});
    most = std::max(most, mock.force().norm());
    EXPECT_LE(mock.force().norm(), mock.limits().max_force + 1e-12);
    EXPECT_LE(mock.torque().norm(), mock.limits().max_torque + 1e-12);
  }
  EXPECT_GT(most, 1);
  device.write({NAN, 0, 0}, Vec3::Zero());
  EXPECT_TRUE(mock.force().allFinite());
  mock.set_fault(MockFault::disconnected);
  EXPECT_FALSE(device.read().connected);
  EXPECT_LE(device.limits().max_stiffness, mock.limits().max_stiffness);
}

}  // namespace
}  // namespace calot::test
