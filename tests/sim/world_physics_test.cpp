// Energy, falling, and what parting overlaps does to velocity: the world against what mechanics says.
#include <gtest/gtest.h>

#include "calot/base/parallel.h"
#include "calot/cut/cut.h"
#include "tests/sim/world_scenes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3, g = 9.81;

StillSurface floor_at(double z, double friction) {
  Surface surface;
  surface.positions = {{-0.2, -0.2, z}, {0.2, -0.2, z}, {0.2, 0.2, z}, {-0.2, 0.2, z}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  return {std::move(surface), friction, false};
}

/// A block 20 × 20 × 8 mm with its underside at z.
WorldSetup loose_block(double z, double young = 20e3) {
  TetMesh mesh = test::box_mesh(4, 4, 2, Vec3(20 * mm, 20 * mm, 8 * mm));
  for (Vec3& x : mesh.positions) x += Vec3(-10 * mm, -10 * mm, z);
  return test::world_setup(test::make_model(std::move(mesh), 1.0 / 60, [](const Vec3&) { return false; },
                                            {young, 0.4, 1000}, {.rayleigh_stiffness = 0.01}));
}

double lowest(const World& world) {
  double z = 1e9;
  for (const Vec3& x : world.state().positions) z = std::min(z, x.z());
  return z;
}

TEST(WorldEnergy, ASwingingBlockNeverGainsAny) {
  WorldSetup setup =
      test::world_setup(test::make_model(test::box_mesh(6, 2, 2, Vec3(60 * mm, 15 * mm, 15 * mm)), 1.0 / 60,
                                         [](const Vec3& x) { return x.x() < 1e-9; }, {15e3, 0.4, 1000}));
  setup.options.gravity = Vec3(0, 0, -g);
  setup.options.solver = {1e-8, 60};
  World world(std::move(setup));
  const double start = world.energy();
  double before = start, gained = 0, deepest = start, kinetic = 0;
  for (int k = 0; k < 500; ++k) {
    ASSERT_FALSE(world.step({}).ran_away);
    const double now = world.energy();
    gained = std::max(gained, now - before);
    deepest = std::min(deepest, now);
    before = now;
    kinetic = std::max(kinetic, test::fastest(world));
  }
  EXPECT_GT(kinetic, 0.05) << "it swung";
  EXPECT_GT(start - deepest, 1e-4) << "implicit Euler takes the swing away [J]";
  EXPECT_LT(gained, 1e-3 * (start - deepest));
  RecordProperty("gained_share", std::to_string(gained / (start - deepest)));
}

TEST(WorldEnergy, ABlockDroppedOnAFloorComesToRestAndStaysThere) {
  WorldSetup setup = loose_block(2 * mm);
  setup.options.gravity = Vec3(0, 0, -g);
  setup.still.push_back(floor_at(0, 0.3));
  World world(std::move(setup));
  double before = world.energy(), gained = 0, gained_at_rest = 0, settled = 0;
  const double start = before;
  for (int k = 0; k < 500; ++k) {
    ASSERT_FALSE(world.step({}).ran_away);
    gained = std::max(gained, world.energy() - before);
    if (k > 200) gained_at_rest = std::max(gained_at_rest, world.energy() - before);
    before = world.energy();
    if (k == 200) settled = before;
  }
  EXPECT_GT(world.contacts().size(), 3u);
  const double fell = start - before;
  EXPECT_GT(fell, 5e-5);
  EXPECT_LT(gained, 1e-3 * fell);
  EXPECT_LT(gained_at_rest, 1e-3 * fell);
  EXPECT_NEAR(before, settled, 1e-3 * fell) << "nor little by little";
  EXPECT_LT(test::fastest(world), 0.3 * mm) << "solved to 1e-5 of what acts";
  EXPECT_NEAR(lowest(world), 0, 1e-5);
  RecordProperty("gained_share", std::to_string(gained / fell));
}

// Undone by at most 0.5 mm a step: as a velocity this would be 3 cm/s, for ever.
TEST(WorldPush, AnOverlapThatIsUndoneLeavesNoVelocity) {
  for (const double overlap : {0.2 * mm, 0.4 * mm}) {
    WorldSetup setup = loose_block(-overlap);
    setup.still.push_back(floor_at(0, 0.3));
    World world(std::move(setup));
    double fastest = 0;
    for (int k = 0; k < 30; ++k) {
      ASSERT_FALSE(world.step({}).ran_away);
      fastest = std::max(fastest, test::fastest(world));
    }
    EXPECT_GT(lowest(world), -0.02 * mm) << overlap;
    EXPECT_LT(lowest(world), 0.1 * mm) << "it doesn't leave, either: " << overlap;
    EXPECT_LT(fastest, 3 * mm) << overlap;
    EXPECT_LT(test::fastest(world), 0.3 * mm) << overlap;
  }
}

TEST(WorldPush, AWeightSunkIntoTheFloorRisesAndDoesNotHop) {
  WorldSetup setup = loose_block(-0.4 * mm, 50e3);
  setup.options.gravity = Vec3(0, 0, -g);
  setup.still.push_back(floor_at(0, 0.3));
  World world(std::move(setup));
  double highest = -1;
  for (int k = 0; k < 120; ++k) {
    ASSERT_FALSE(world.step({}).ran_away);
    highest = std::max(highest, lowest(world));
  }
  EXPECT_LT(highest, 0.01 * mm);
  EXPECT_NEAR(lowest(world), 0, 0.01 * mm);
  EXPECT_LT(test::fastest(world), 0.1 * mm);
}

/// A bar held at x = 0, cut through in its middle: the far half is free.
WorldSetup bar(double step) {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(10, 3, 2, Vec3(40 * mm, 9 * mm, 6 * mm)), step,
                                                        [](const Vec3& x) { return x.x() < 1e-9; }, {100e3, 0.4, 1000},
                                                        {.rayleigh_stiffness = 0.01}));
  setup.options.gravity = Vec3(0, 0, -g);
  return setup;
}

void cut_through(World& world) {
  world.edit(cut(world.model().mesh(), Plane{Vec3(20.1 * mm, 0, 0), Vec3::UnitX()}), EventKind::cut, "through");
}

TEST(WorldFall, AFreedPartFallsAsAFreeBody) {
  for (const double step : {1.0 / 60, 1.0 / 240}) {
    World world(bar(step));
    cut_through(world);
    std::vector<std::size_t> part;
    for (std::size_t v = 0; v < world.model().mesh().vertex_count(); ++v)
      if (world.model().mesh().positions[v].x() > 20.1 * mm) part.push_back(v);
    ASSERT_GT(part.size(), 30u);
    const std::vector<double> masses = world.model().vertex_masses();
    const auto height = [&] {
      double sum = 0, mass = 0;
      for (const std::size_t v : part) {
        sum += masses[v] * world.state().positions[v].z();
        mass += masses[v];
      }
      return sum / mass;
    };
    const double from = height();
    const int steps = static_cast<int>(0.4 / step + 0.5);
    for (int k = 0; k < steps; ++k) ASSERT_FALSE(world.step({}).ran_away);
    const double t = steps * step, fallen = from - height();
    EXPECT_NEAR(fallen, g * step * step * steps * (steps + 1) / 2, 1e-5 * fallen) << "the sum of implicit Euler";
    EXPECT_NEAR(fallen, g * t * t / 2, 1.01 * g * t * step / 2) << "and g t²/2 to first order";
  }
}

struct Fall {
  std::vector<WorldEvent> lost;
  std::string hash;
};

Fall fall(int steps) {
  test::RememberingWorld world(bar(1.0 / 60));
  cut_through(world);
  Fall result;
  std::vector<Vec3> there;
  for (int k = 0; k < steps; ++k) {
    EXPECT_FALSE(world.step({}).ran_away) << k;
    EXPECT_TRUE(world.report().free_motion.converged) << k;
    if (k == 100) there = world.state().positions;
  }
  double deepest = 0;
  for (std::size_t v = 0; v < there.size(); ++v) {
    const bool far = world.model().mesh().positions[v].x() > 20.1 * mm;
    EXPECT_EQ(world.is_lost(VertexId(v)), far) << v;
    EXPECT_LT((world.state().positions[v] - there[v]).norm(), 1e-4) << "neither falls nor drifts on " << v;
    deepest = std::min(deepest, world.state().positions[v].z());
  }
  EXPECT_LT(deepest, -1.0);
  EXPECT_GT(deepest, -1.2);
  EXPECT_LT(test::fastest(world), 1e-6);
  for (const WorldEvent& event : world.history())
    if (event.kind == EventKind::lost) result.lost.push_back(event);
  // Cut once more: what is lost stays lost.
  cut_through(world);
  world.edit(cut(world.model().mesh(), Plane{Vec3(30.1 * mm, 0, 0), Vec3::UnitX()}), EventKind::cut, "through");
  for (int k = 0; k < 60; ++k) EXPECT_FALSE(world.step({}).ran_away) << k;
  EXPECT_EQ(test::count(world, EventKind::lost), 1u);
  EXPECT_LT(test::fastest(world), 1e-4);
  result.hash = world.state_hash();
  return result;
}

TEST(WorldFall, APartThatFellOutOfTheSceneIsStoppedAndSaidOnce) {
  const int threads = thread_count();
  set_thread_count(1);
  const Fall one = fall(400);
  set_thread_count(4);
  const Fall four = fall(400);
  set_thread_count(threads);
  ASSERT_EQ(one.lost.size(), 1u);
  EXPECT_NEAR(static_cast<double>(one.lost[0].step), 60 * std::sqrt(2 * 1.0 / g), 3);
  EXPECT_GT(one.lost[0].amount, 100);
  EXPECT_EQ(one.hash, four.hash);
}

TEST(WorldFall, WhatHangsOnSomethingIsNeverLost) {
  WorldSetup setup = loose_block(0);
  setup.options.gravity = Vec3(0, 0, -g);
  setup.options.fall = 0.01;
  Spring spring;  // so weak that it gives a hand's breadth
  spring.vertex = VertexId(0);
  spring.anchor = setup.model.mesh().positions[0];
  spring.stiffness = 0.3 * Mat3::Identity();
  spring.damping = 0.1;
  setup.ligaments.push_back(spring);
  test::RememberingWorld world(std::move(setup));
  for (int k = 0; k < 400; ++k) ASSERT_FALSE(world.step({}).ran_away);
  EXPECT_LT(lowest(world), -0.08);
  EXPECT_EQ(test::count(world, EventKind::lost), 0u);
  EXPECT_FALSE(world.is_lost(VertexId(0)));
}

TEST(WorldRunaway, OnceItsCauseIsGoneTheWorldGoesOn) {
  WorldSetup setup = bar(1.0 / 60);
  Spring spring;
  spring.vertex = VertexId(setup.model.mesh().vertex_count() - 1);
  spring.anchor = Vec3(5, 5, 5);
  spring.stiffness = 1e6 * Mat3::Identity();
  setup.ligaments.push_back(spring);
  test::RememberingWorld world(std::move(setup));
  const std::vector<Vec3> rest = world.state().positions;
  for (int k = 0; k < 5; ++k) {
    ASSERT_TRUE(world.step({}).ran_away);
    ASSERT_EQ(world.state().positions, rest);
  }
  EXPECT_EQ(test::count(world, EventKind::ran_away), 5u);
  TopologyEdit edit;  // the ligament goes with its vertex
  for (std::size_t t = 0; t < world.model().mesh().tet_count(); ++t)
    for (const VertexId v : world.model().mesh().tets[t])
      if (v == spring.vertex) edit.removed.emplace_back(t);
  ASSERT_NE(world.edit(edit, EventKind::cut, "the ligament's end"), nullptr);
  for (int k = 0; k < 120; ++k) {
    ASSERT_FALSE(world.step({}).ran_away) << k;
    ASSERT_TRUE(world.report().free_motion.converged) << k;
  }
  EXPECT_LT(lowest(world), -0.1 * mm) << "it hangs";
  EXPECT_LT(test::fastest(world), 0.01);
}

}  // namespace
}  // namespace calot
