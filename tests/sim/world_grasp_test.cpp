// Jaws and clips in the world: what they hold, when they let go, and that cuts take nothing from them.
#include <gtest/gtest.h>

#include "calot/mesh/parts.h"
#include "tests/sim/world_scenes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3, h = 1.0 / 60;

/// A strip 20 × 4 × 20 mm that is held below; a grasper comes along −x and has its top edge between its jaws.
struct Strip {
  explicit Strip(double grip) : world(make(grip)) { input = world.instruments()[0].setup().start; }

  static test::RememberingWorld make(double grip) {
    WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(10, 2, 10, Vec3(20 * mm, 4 * mm, 20 * mm)), h,
                                                          [](const Vec3& x) { return x.z() < 1e-9; },
                                                          {400e3, 0.4, 1000}, {.rayleigh_stiffness = 0.01}));
    setup.instruments.push_back(test::instrument(InstrumentKind::bowel_grasper, Vec3(24 * mm, 2 * mm, 18.5 * mm),
                                                 -Vec3::UnitX(), -Vec3::UnitZ(), 0.5));
    setup.instruments[0].start.grip = grip;
    return test::RememberingWorld(std::move(setup));
  }

  void close() {
    for (int k = 0; k < 60; ++k) step(Vec3::Zero(), std::max(0.0, 0.5 - 0.02 * (k + 1)));
  }
  void step(const Vec3& move, double opening) {
    input.pose.position += move;
    input.opening = opening;
    const StepReport& report = world.step(test::Inputs{input});
    EXPECT_TRUE(report.free_motion.converged) << report.step << " " << report.free_motion.residual;
    EXPECT_FALSE(report.ran_away) << report.step;
  }
  [[nodiscard]] const Grasp& grasp() const { return *world.instruments()[0].grasp; }

  test::RememberingWorld world;
  InstrumentInput input;
};

TEST(WorldGrasp, PulledSlowlyItSlipsAtItsLimitAndNoSooner) {
  constexpr double grip = 1.5, limit = 2 * 5.0 / 6.0 * grip;
  Strip strip(grip);
  strip.close();
  ASSERT_TRUE(strip.grasp().holding());
  EXPECT_EQ(test::count(strip.world, EventKind::grasped), 1u);
  EXPECT_NEAR(strip.grasp().report().grip, grip, 0.02 * grip);
  double peak = 0, first_slip = 0;
  const double slipped = strip.grasp().report().slipped;
  for (int k = 0; k < 400 && strip.grasp().holding(); ++k) {
    strip.step(Vec3(0, 0, 0.025 * mm), 0);
    const double pull = strip.grasp().report().pull.norm();
    // What the instrument feels is what the jaws say.
    EXPECT_NEAR(-strip.world.instruments()[0].force.z(), -strip.grasp().report().pull.z(), 0.02 + 0.02 * pull);
    peak = std::max(peak, pull);
    if (first_slip == 0 && strip.grasp().report().slipped > slipped + 0.1 * mm) first_slip = pull;
  }
  // The grip is reached from below, and not every place under the jaws slides at once.
  EXPECT_LT(peak, 1.01 * limit);
  EXPECT_GT(peak, 0.93 * limit);
  EXPECT_GT(first_slip, 0.75 * limit);
  EXPECT_GE(test::count(strip.world, EventKind::slipped), 1u);
  EXPECT_FALSE(strip.grasp().holding());  // slid out from between the jaws
  EXPECT_EQ(test::count(strip.world, EventKind::let_go), 1u);
}

/// Away from rest at once: what was expected of the step, that tissue goes on as it went, is as wrong as it gets.
TEST(WorldGrasp, PulledFastItPassesItsLimitByAFewPercentAtMost) {
  for (const Vec3& way : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitZ())}) {
    constexpr double grip = 1.5, limit = 2 * 5.0 / 6.0 * grip, speed = 100 * mm;
    Strip strip(grip);
    strip.close();
    ASSERT_TRUE(strip.grasp().holding());
    double most = 0;
    for (int k = 0; k < 20 && strip.grasp().holding(); ++k) {
      strip.step(speed * h * way, 0);
      const GraspReport& report = strip.grasp().report();
      if (strip.grasp().holding()) most = std::max(most, report.a.tangential + report.b.tangential);
    }
    EXPECT_LT(most, 1.05 * limit) << way.transpose();
    EXPECT_GT(most, 0.6 * limit) << way.transpose();
  }
}

TEST(WorldGrasp, HoldsBelowItsLimitAndReleasesWhenOpened) {
  constexpr double grip = 3.0, limit = 2 * 5.0 / 6.0 * grip;
  Strip strip(grip);
  strip.close();
  for (int k = 0; k < 200 && strip.grasp().report().pull.norm() < 0.6 * limit; ++k)
    strip.step(Vec3(0, 0, 0.025 * mm), 0);
  ASSERT_TRUE(strip.grasp().holding());
  const double slipped = strip.grasp().report().slipped, pull = strip.grasp().report().pull.norm();
  const std::size_t slips = test::count(strip.world, EventKind::slipped);
  for (int k = 0; k < 120; ++k) strip.step(Vec3::Zero(), 0);
  EXPECT_TRUE(strip.grasp().holding());
  EXPECT_LT(strip.grasp().report().slipped - slipped, 1e-6);
  EXPECT_NEAR(strip.grasp().report().pull.norm(), pull, 0.05 * pull);
  EXPECT_LT(test::fastest(strip.world), 1e-4);
  EXPECT_EQ(test::count(strip.world, EventKind::slipped), slips);
  for (int k = 0; k < 30; ++k) strip.step(Vec3::Zero(), std::min(0.9, 0.04 * (k + 1)));
  EXPECT_FALSE(strip.grasp().holding());
  EXPECT_EQ(test::count(strip.world, EventKind::let_go), 1u);
  for (int k = 0; k < 120; ++k) strip.step(Vec3::Zero(), 0.9);
  double off = 0;  // back where it was
  for (std::size_t v = 0; v < strip.world.state().positions.size(); ++v)
    off = std::max(off, (strip.world.state().positions[v] - strip.world.model().mesh().positions[v]).norm());
  EXPECT_LT(off, 0.2 * mm);
}

/// A flat band along x, held at x = 0: an applier clips it at 10 mm, a grasper holds its end, scissors cut at 22 mm;
/// all come along −y.
struct Operation {
  Operation() : world(make()) {
    for (const InstrumentArm& arm : world.instruments()) inputs.emplace_back(arm.setup().start);
  }

  static test::RememberingWorld make() {
    WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(20, 4, 2, Vec3(40 * mm, 6 * mm, 2 * mm)), h,
                                                          [](const Vec3& x) { return x.x() < 1e-9; },
                                                          {200e3, 0.4, 1000}, {.rayleigh_stiffness = 0.01}));
    const auto add = [&](InstrumentKind kind, const Vec3& at, double opening) {
      // Jaws open along z.
      setup.instruments.push_back(test::instrument(kind, at, -Vec3::UnitY(), Vec3::UnitX(), opening));
    };
    const double z = 1 * mm;
    add(InstrumentKind::clip_applier, Vec3(10 * mm, 16.5 * mm, z), 0.45);
    add(InstrumentKind::bowel_grasper, Vec3(34 * mm, 20 * mm, z), 0.5);
    add(InstrumentKind::scissors, Vec3(22.3 * mm, 13 * mm, z), 0.8);
    setup.instruments[1].start.grip = 5;
    return test::RememberingWorld(std::move(setup));
  }
  const StepReport& step() { return world.step(inputs); }
  [[nodiscard]] const Grasp& grasp() const { return *world.instruments()[1].grasp; }
  /// Where the band's cross-section at a place of its rest shape is now: the clip bends it, tools must follow.
  [[nodiscard]] Vec3 middle_at(double x) const {
    Vec3 middle = Vec3::Zero();
    double number = 0;
    for (std::size_t v = 0; v < world.state().positions.size(); ++v)
      if (std::abs(world.model().mesh().positions[v].x() - x) < 0.1 * mm) {
        middle += world.state().positions[v];
        ++number;
      }
    return middle / number;
  }

  test::RememberingWorld world;
  test::Inputs inputs;
};

TEST(WorldGrasp, ACutTakesNothingFromGraspAndClip) {
  Operation o;
  o.inputs[0]->fire = true;
  for (int k = 0; k < 60; ++k) {
    if (k < 24) o.inputs[1]->pose.position.z() = o.middle_at(34 * mm).z();
    o.inputs[1]->opening = std::clamp(0.5 - 0.02 * (k - 24), 0.0, 0.5);
    const StepReport& report = o.step();
    EXPECT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
  }
  ASSERT_EQ(o.world.clips().size(), 1u);
  ASSERT_TRUE(o.grasp().holding());
  const auto closes = [&] { return o.world.clips()[0].closes(1, o.world.model().mesh(), o.world.state().positions); };
  EXPECT_TRUE(closes());
  // The grasper goes back out of the clip's way and pulls a little.
  for (int k = 0; k < 30; ++k) {
    o.inputs[1]->pose.position.x() += 0.02 * mm;
    o.step();
  }
  o.inputs[2]->pose.position = o.middle_at(22 * mm) + Vec3(0.3 * mm, 10 * mm, 0);
  std::size_t cuts = 0, opened = 0;
  for (int k = 0; k < 60; ++k) {
    o.inputs[2]->opening = std::max(0.0, 0.8 * (1 - (k + 1) / 50.0));
    const std::size_t before = o.world.model().mesh().vertex_count();
    std::vector<std::uint8_t> held(before), clipped(before);
    for (std::size_t v = 0; v < before; ++v) {
      held[v] = o.grasp().holds(VertexId(v));
      clipped[v] = o.world.clips()[0].holds(VertexId(v));
    }
    const std::size_t held_count = o.grasp().held_count(), pairs = o.world.clips()[0].pair_count();
    const StepReport& report = o.step();
    ASSERT_FALSE(report.ran_away) << k;
    EXPECT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
    if (o.world.changes().empty()) continue;
    ++cuts;
    const std::vector<VertexId> now = test::followed(before, o.world.changes());
    for (const StiffnessChange& change : o.world.changes()) opened += change.added.size();
    for (std::size_t v = 0; v < before; ++v) {
      if (held[v]) {
        ASSERT_TRUE(now[v].valid());
        EXPECT_TRUE(o.grasp().holds(now[v])) << k << " vertex " << v;
      }
      if (clipped[v]) {
        ASSERT_TRUE(now[v].valid());
        EXPECT_TRUE(o.world.clips()[0].holds(now[v])) << k << " vertex " << v;
      }
    }
    EXPECT_GE(o.grasp().held_count(), held_count) << k;
    EXPECT_GE(o.world.clips()[0].pair_count(), pairs) << k;
  }
  EXPECT_GE(cuts, 5u);
  EXPECT_GT(opened, 10u);
  ASSERT_EQ(face_connected_parts(o.world.model().mesh()).count(), 2u);
  EXPECT_EQ(test::count(o.world, EventKind::let_go), 0u);
  EXPECT_EQ(test::count(o.world, EventKind::clip_lost), 0u);
  EXPECT_TRUE(o.grasp().holding());
  EXPECT_TRUE(closes());
  EXPECT_NE(o.world.clips()[0].state(), ClipState::off);
  // What is cut off hangs in the jaws alone: it goes where they go, without force when they stop.
  const std::vector<Vec3> before = o.world.state().positions;
  for (int k = 0; k < 60; ++k) {
    o.inputs[1]->pose.position.x() += 0.2 * mm;
    o.step();
  }
  for (int k = 0; k < 60; ++k) o.step();
  const Parts parts = face_connected_parts(o.world.model().mesh());
  const std::size_t far = before[parts.vertices[0][0].index()].x() > before[parts.vertices[1][0].index()].x() ? 0 : 1;
  double least = 1, most = 0;
  for (const VertexId v : parts.vertices[far]) {
    const double moved = (o.world.state().positions[v.index()] - before[v.index()]).x();
    least = std::min(least, moved);
    most = std::max(most, moved);
  }
  EXPECT_NEAR(least, 12 * mm, 1 * mm);
  EXPECT_NEAR(most, 12 * mm, 1 * mm);
  EXPECT_LT(o.grasp().report().pull.norm(), 0.02);
}

// A stiff band, so that what gives is the instrument: 3 N/mm, however much of clip and tissue lies between its jaws.
TEST(WorldGrasp, JawsOnAClipPullOnceAndTheHandFeelsIt) {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(10, 4, 2, Vec3(20 * mm, 6 * mm, 2 * mm)), h,
                                                        [](const Vec3& x) { return x.x() < 1e-9; }, {20e6, 0.3, 1000},
                                                        {.rayleigh_stiffness = 0.01}));
  const auto add = [&](InstrumentKind kind, const Vec3& at, double opening) {
    setup.instruments.push_back(test::instrument(kind, at, -Vec3::UnitY(), Vec3::UnitX(), opening));
  };
  add(InstrumentKind::clip_applier, Vec3(10 * mm, 16.5 * mm, 1 * mm), 0.45);
  add(InstrumentKind::bowel_grasper, Vec3(10 * mm, 18 * mm, 1 * mm), 0.5);
  setup.instruments[1].start.grip = 3;
  test::RememberingWorld world(std::move(setup));
  test::Inputs inputs;
  for (const InstrumentArm& arm : world.instruments()) inputs.emplace_back(arm.setup().start);
  inputs[0]->fire = true;
  for (int k = 0; k < 30; ++k) world.step(inputs);
  inputs[0]->pose.position.y() += 20 * mm;
  for (int k = 0; k < 60; ++k) {
    inputs[1]->opening = std::max(0.0, 0.5 - 0.02 * k);
    world.step(inputs);
  }
  const InstrumentArm& arm = world.instruments()[1];
  ASSERT_EQ(arm.held_clip, 0);
  EXPECT_FALSE(arm.grasp->holding());
  EXPECT_GT(arm.opening_to(), 0.02);  // the clip keeps the jaws apart
  EXPECT_EQ(test::count(world, EventKind::let_go), 0u);
  const Vec3 before = arm.force;
  constexpr double way = 0.2e-3;
  for (int k = 0; k < 60; ++k) {
    if (k < 20) inputs[1]->pose.position.x() += way / 20;
    world.step(inputs);
  }
  const double stiffness = (before - arm.force).x() / way;
  EXPECT_LT(stiffness, 3000);
  EXPECT_GT(stiffness, 0.7 * 3000);

  HapticConstraints felt;
  world.haptic_constraints(1, felt);
  ASSERT_EQ(felt.problem.friction.size(), 0u);
  EXPECT_LT((felt.held_wrench.head<3>() - arm.force).norm(), 1e-9);
  const Vec3 r = arm.to() * arm.clip_anchor - arm.to().position;
  EXPECT_GT(r.norm(), 10 * mm);
  EXPECT_LT((felt.held_wrench.tail<3>() - r.cross(arm.force)).norm(), 1e-9);
  Vector6 twist;
  twist << 1e-4, -2e-4, 3e-4, 0.01, 0.02, -0.01;
  const Vec3 moved = twist.head<3>() + Vec3(twist.tail<3>()).cross(r), pulled = -3000 * moved;
  const Vector6 change = -felt.held_stiffness * twist;
  EXPECT_LT((change.head<3>() - pulled).norm(), 1e-9);
  EXPECT_LT((change.tail<3>() - r.cross(pulled)).norm(), 1e-9);
  for (int k = 0; k < 30; ++k) {
    inputs[1]->opening = 0.9;
    world.step(inputs);
  }
  EXPECT_LT(arm.held_clip, 0);
  EXPECT_EQ(test::count(world, EventKind::let_go), 1u);
}

TEST(WorldGrasp, ACutThroughWhatIsHeldKeepsBothSidesHeld) {
  Operation o;
  for (int k = 0; k < 40; ++k) {
    o.inputs[1]->opening = std::max(0.0, 0.5 - 0.02 * (k + 1));
    o.step();
  }
  ASSERT_TRUE(o.grasp().holding());
  // Straight through the jaws' middle: what comes of a held vertex is held too.
  const SplitEdit cut = split(o.world.model().mesh(), Plane{Vec3(34.2 * mm, 0, 0), Vec3::UnitX()});
  ASSERT_FALSE(cut.empty());
  const std::size_t before = o.grasp().held_count();
  std::vector<std::uint8_t> held(o.world.model().mesh().vertex_count());
  for (std::size_t v = 0; v < held.size(); ++v) held[v] = o.grasp().holds(VertexId(v));
  o.world.edit(cut, EventKind::cut, "through the jaws");
  ASSERT_EQ(o.world.changes().size(), 1u);
  const Remap& remap = o.world.changes()[0].remap;
  std::size_t fresh = 0;
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& from = remap.added_from[k];
    const VertexId nearest = from.weight <= 0.5 ? from.from : from.to;
    if (!held[nearest.index()]) continue;
    ++fresh;
    EXPECT_TRUE(o.grasp().holds(remap.added_vertices[k]));
  }
  for (std::size_t v = 0; v < held.size(); ++v)
    if (held[v]) {
      EXPECT_TRUE(o.grasp().holds(remap.vertex_to_new[v])) << v;
    }
  EXPECT_GT(fresh, 0u);
  EXPECT_GE(o.grasp().held_count(), before + fresh);
  for (int k = 0; k < 60; ++k) {
    const StepReport& report = o.step();
    EXPECT_FALSE(report.ran_away);
    EXPECT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
  }
  // The severed end is held by the jaws alone, the other end by them and by its root; neither falls out.
  const Parts parts = face_connected_parts(o.world.model().mesh());
  ASSERT_EQ(parts.count(), 2u);
  for (const std::vector<VertexId>& part : parts.vertices)
    EXPECT_TRUE(std::any_of(part.begin(), part.end(), [&](VertexId v) { return o.grasp().holds(v); }));
}

}  // namespace
}  // namespace calot
