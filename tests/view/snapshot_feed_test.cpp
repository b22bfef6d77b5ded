// The hand-over from the world to the view: the newest moment, every event once, memory used again.
#include <gtest/gtest.h>

#include <thread>

#include "calot/view/snapshot_maker.h"
#include "tests/sim/world_scenes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

World slab() {
  TetMesh mesh = test::box_mesh(6, 4, 2, Vec3(18 * mm, 12 * mm, 6 * mm));
  mesh.region_names[1] = "liver";
  return World(test::world_setup(
      test::make_model(std::move(mesh), 1.0 / 60, [](const Vec3& x) { return x.x() < 1e-9; }, {50e3, 0.4, 1000}, {})));
}

TopologyEdit removing(std::initializer_list<int> tets) {
  TopologyEdit edit;
  for (const int t : tets) edit.removed.emplace_back(t);
  return edit;
}

TEST(SnapshotFeed, SkinIsTheSameUntilAnEditAndShowsWhatItLaidBare) {
  World world = slab();
  SnapshotFeed feed(world);
  ASSERT_NE(feed.fetch(), nullptr);
  const Snapshot first = feed.current();
  EXPECT_EQ(first.skin.triangles.size(), world.surface().triangles().size());
  EXPECT_EQ(first.skin.vertices.size(), first.positions.size());
  EXPECT_EQ(first.skin.vertices.front().look, TissueLook::liver);
  for (const SkinVertex& v : first.skin.vertices) EXPECT_FALSE(v.cut);
  world.step({});
  feed.publish(world);
  ASSERT_NE(feed.fetch(), nullptr);
  EXPECT_EQ(feed.current().skin.version, first.skin.version);
  EXPECT_EQ(feed.current().step, 1U);

  world.edit(removing({100, 101, 102, 103, 104, 105}), EventKind::cut, "a cube");
  world.step({});
  feed.publish(world);
  ASSERT_NE(feed.fetch(), nullptr);
  const Snapshot& after = feed.current();
  EXPECT_NE(after.skin.version, first.skin.version);
  std::size_t cut = 0;
  for (const Triangle& t : after.skin.triangles) {
    const bool is_cut = after.skin.vertices[t[0]].cut;
    for (const std::uint32_t c : t) {
      EXPECT_EQ(after.skin.vertices[c].cut, is_cut);  // no corner is shared between skin and cut
      EXPECT_TRUE(
          after.positions[c].isApprox(world.state().positions[after.skin.vertices[c].vertex].cast<float>(), 1e-6F));
    }
    cut += is_cut ? 1 : 0;
  }
  EXPECT_GT(cut, 4U);
  EXPECT_EQ(after.skin.triangles.size(), world.surface().triangles().size());
}

TEST(SnapshotFeed, ASnapshotThatWasNotFetchedLeavesItsEventsToTheNext) {
  World world = slab();
  SnapshotFeed feed(world);
  EXPECT_EQ(feed.fetch()->events.size(), 0U);
  EXPECT_EQ(feed.fetch(), nullptr);
  std::vector<std::string> seen;
  for (int step = 0; step < 6; ++step) {
    const std::string name = "edit " + std::to_string(step);
    world.edit(removing({step}), EventKind::cut, name);
    world.step({});
    feed.publish(world);
    if (step % 3 != 2) continue;  // two of three are never fetched
    const Snapshot* snapshot = feed.fetch();
    ASSERT_NE(snapshot, nullptr);
    EXPECT_EQ(snapshot->first_event, seen.size());
    for (const WorldEvent& event : snapshot->events) seen.push_back(event.text);
  }
  ASSERT_EQ(seen.size(), 6U);
  for (int step = 0; step < 6; ++step) EXPECT_EQ(seen[static_cast<std::size_t>(step)], "edit " + std::to_string(step));
}

TEST(SnapshotFeed, TwoThreadsMissNoEventAndSeeNoneTwice) {
  World world = slab();
  SnapshotFeed feed(world);
  constexpr int edits = 40;
  std::atomic<bool> done = false;
  std::vector<std::string> seen;
  std::uint64_t last = 0;
  const auto look = [&] {
    const Snapshot* snapshot = feed.fetch();
    if (snapshot == nullptr) return;
    EXPECT_GE(snapshot->step, last);
    EXPECT_EQ(snapshot->positions.size(), snapshot->skin.vertices.size());
    last = snapshot->step;
    for (const WorldEvent& event : snapshot->events)
      if (event.kind == EventKind::cut) seen.push_back(event.text);
  };
  std::thread view([&] {
    while (!done) look();
    look();
  });
  for (int k = 0; k < edits; ++k) {
    world.edit(removing({2 * k}), EventKind::cut, std::to_string(k));
    world.step({});
    feed.publish(world);
  }
  done = true;
  view.join();
  ASSERT_EQ(seen.size(), static_cast<std::size_t>(edits));
  for (int k = 0; k < edits; ++k) EXPECT_EQ(seen[static_cast<std::size_t>(k)], std::to_string(k));
}

}  // namespace
}  // namespace calot
