// What the world says of itself: events and changes that a follower needs, none missing, none twice.
#include <gtest/gtest.h>

#include "calot/compliance/compliance.h"
#include "calot/cut/split.h"
#include "tests/sim/world_scenes.h"
#include "tests/support/accuracy.h"
#include "tests/support/edits.h"

namespace calot {
namespace {

constexpr double mm = 1e-3, h = 1.0 / 60;

Model slab() {
  TetMesh mesh = test::box_mesh(12, 8, 2, Vec3(36 * mm, 16 * mm, 3 * mm));
  mesh.region_names[1] = "liver";
  return test::make_model(std::move(mesh), h, [](const Vec3& x) { return x.x() < 1e-9; }, {300e3, 0.4, 1000},
                          {.rayleigh_stiffness = 0.005});
}

TEST(WorldNews, AStepTellsOfEditsBeforeItAndForgetsWhatWasBefore) {
  World world(test::world_setup(slab()));
  world.step({});
  EXPECT_TRUE(world.events().empty());
  EXPECT_TRUE(world.changes().empty());
  TopologyEdit first, second, none_such;
  first.removed = {TetId(7)};
  second.removed = {TetId(3), TetId(90)};
  none_such.removed = {TetId(1'000'000)};
  const StiffnessChange* change = world.edit(first, EventKind::cut, "first");
  ASSERT_NE(change, nullptr);
  EXPECT_EQ(change, &world.changes().back());
  EXPECT_EQ(world.edit(none_such, EventKind::cut, "never"), nullptr);
  EXPECT_EQ(world.edit({}, EventKind::cut, "nothing"), nullptr);
  ASSERT_NE(world.edit(second, EventKind::burnt, "second", 4), nullptr);
  world.step({});
  ASSERT_EQ(world.changes().size(), 2u);
  EXPECT_EQ(world.changes()[0].remap.tet_to_new.size(), slab().mesh().tet_count());
  EXPECT_EQ(world.changes()[1].remap.tet_to_new.size(), slab().mesh().tet_count() - 1);
  ASSERT_EQ(world.events().size(), 3u);
  EXPECT_EQ(world.events()[0].text, "first");
  EXPECT_EQ(world.events()[1].kind, EventKind::cut_refused);
  EXPECT_EQ(world.events()[2].kind, EventKind::burnt);
  EXPECT_EQ(world.events()[2].instrument, 4);
  for (const WorldEvent& event : world.events()) EXPECT_EQ(event.step, 2u);
  world.step({});
  EXPECT_TRUE(world.events().empty());
  EXPECT_TRUE(world.changes().empty());
}

/// Scissors that snip again and again from one edge, a hook that burns a furrow, and edits from outside in between.
struct Busy {
  Busy() : world(setup()) {
    for (const InstrumentArm& arm : world.instruments()) inputs.emplace_back(arm.setup().start);
  }
  static WorldSetup setup() {
    WorldSetup setup = test::world_setup(slab());
    setup.options.heat = true;
    setup.instruments.push_back(test::instrument(InstrumentKind::scissors, Vec3(9.3 * mm, 19 * mm, 1.5 * mm),
                                                 -Vec3::UnitY(), Vec3::UnitX(), 0.8));
    setup.instruments.push_back(
        test::instrument(InstrumentKind::hook, Vec3(5 * mm, 3 * mm, 15.9 * mm), -Vec3::UnitZ(), Vec3::UnitX(), 0));
    setup.instruments[1].power = 60;
    return setup;
  }
  void step(int k) {
    // The blades' crossing runs evenly from 2 to 19 mm; then they open over the next place.
    const int snip = k / 26, at = k % 26;
    const double crossing = 2 + 17 * (at + 1) / 20.0;
    inputs[0]->opening = at < 20 ? 2 * std::asin(0.8 / crossing) : 0.13 * (at - 19);
    inputs[0]->pose.position.x() = (9.3 + 4.3 * (snip + std::max(0, at - 19) / 6.0)) * mm;
    inputs[1]->pose.position.x() += 0.1 * mm;
    inputs[1]->energy = k > 2;
    world.step(inputs);
  }
  test::RememberingWorld world;
  test::Inputs inputs;
};

TEST(WorldNews, AComplianceLedByChangesIsExactAfterSixtyCutsBurnsAndEditsFromOutside) {
  Busy busy;
  World& world = busy.world;
  Compliance compliance = precompute(world.model(), {Backend::sparse});
  std::size_t changes = 0, outside = 0;
  std::vector<VertexId> face;
  for (int k = 0; k < 156; ++k) {
    if (k % 13 == 5) {  // twice before the same step
      const TopologyEdit edit = test::random_edit(world.model().mesh(), 2, 100 + static_cast<std::uint64_t>(k));
      outside += busy.world.edit(edit, EventKind::cut, "from outside") != nullptr;
      const BladePatch patch{Vec3(30 * mm, 8 * mm, (1 + 0.01 * k) * mm), Vec3::UnitZ(), Vec3::UnitX(), 5 * mm, 5 * mm};
      const TopologyEdit slit = split(world.model().mesh(), patch);
      outside += busy.world.edit(slit, EventKind::cut, "from outside") != nullptr;
    }
    busy.step(k);
    for (const StiffnessChange& change : world.changes()) {
      ASSERT_NO_THROW(compliance.update(change)) << k;
      ++changes;
    }
    if (compliance.pending_rank() > 400) compliance.fold();
    if (!world.changes().empty()) face = test::cut_face(world.changes().back());
  }
  EXPECT_GE(outside, 10u);
  EXPECT_GE(test::count(busy.world, EventKind::cut) - outside, 30u) << "by scissors";
  EXPECT_GE(test::count(busy.world, EventKind::burnt), 5u);
  EXPECT_GE(changes, 60u);
  const Compliance anew = precompute(world.model(), {Backend::sparse});
  std::erase_if(face, [](VertexId v) { return !v.valid(); });
  if (face.size() > 12) face.resize(12);
  const double worst =
      test::worst_column(compliance, anew, test::sample_dofs(world.model().mesh().vertex_count(), face));
  RecordProperty("changes", std::to_string(changes));
  RecordProperty("worst", std::to_string(1e9 * worst) + "e-9");
  EXPECT_LT(worst, test::bound(anew));
  EXPECT_LT(worst, 1e-9);
}

TEST(WorldNews, OverstretchedTissueThatCannotTearIsSaidOnce) {
  TetMesh mesh;  // one tet on its own: nothing to part it from
  mesh.positions = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}};
  mesh.tets = {{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}};
  mesh.regions = {1};
  mesh.region_names[1] = "liver";
  WorldSetup setup = test::world_setup(test::make_model(std::move(mesh), h, [](const Vec3&) { return false; },
                                                        {5e3, 0.3, 1000}, {.rayleigh_stiffness = 0.02}));
  setup.options.tearing = true;
  for (std::size_t v = 0; v < 2; ++v) {
    Spring spring;
    spring.vertex = VertexId(v);
    spring.anchor = Vec3(v == 0 ? -0.01 : 0.02, 0, 0);
    spring.stiffness = 100 * Mat3::Identity();
    spring.damping = 0.05;
    setup.ligaments.push_back(spring);
  }
  test::RememberingWorld world(std::move(setup));
  for (int k = 0; k < 200; ++k) world.step({});
  EXPECT_GT(world.report().largest_stretch, 1.35);
  EXPECT_EQ(test::count(world, EventKind::overstretched), 1u);
  for (const WorldEvent& event : world.history()) {
    if (event.kind == EventKind::overstretched) {
      EXPECT_EQ(event.amount, 1);
    }
  }
}

}  // namespace
}  // namespace calot
