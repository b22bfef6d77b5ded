// The scene of the operation does what its title says, on a coarse mesh.
#include <gtest/gtest.h>

#include <map>

#include "calot/mesh/parts.h"
#include "calot/scene/scene_file.h"
#include "calot/scene/scene_world.h"

namespace calot::test {
namespace {

TEST(ClipAndCut, ThreeClipsHoldAndTheDuctIsCutBetweenThem) {
  Scene scene = read_scene(CALOT_SOURCE_DIR "/examples/scenes/clip_and_cut.toml");
  ASSERT_EQ(scene.tubes.size(), 1U);
  scene.tubes[0].rings = 2;
  scene.heat = scene.fluids = false;
  const double seconds = static_cast<double>(scene.steps) * scene.time_step;
  scene.time_step = 1.0 / 30;
  const auto steps = static_cast<std::uint64_t>(seconds / scene.time_step);
  SceneRun run(scene);
  std::map<EventKind, int> count;
  for (std::uint64_t k = 0; k < steps; ++k) {
    run.step();
    for (const WorldEvent& event : run.world().events()) count[event.kind] += event.step == run.steps() ? 1 : 0;
    ASSERT_FALSE(run.world().report().ran_away) << k;
  }
  EXPECT_EQ(count[EventKind::grasped], 1);
  EXPECT_EQ(count[EventKind::let_go], 0);
  EXPECT_EQ(count[EventKind::clip_placed], 3);
  EXPECT_EQ(count[EventKind::clip_lost], 0);
  EXPECT_EQ(count[EventKind::torn], 0);
  EXPECT_EQ(count[EventKind::cut_refused], 0);
  EXPECT_GT(count[EventKind::cut], 0);
  const World& world = run.world();
  const TetMesh& mesh = world.model().mesh();
  EXPECT_EQ(face_connected_parts(mesh).count(), 2U);
  EXPECT_TRUE(world.instruments()[0].grasp->holding());

  std::int32_t duct = -1;
  for (const auto& [region, name] : mesh.region_names)
    if (name == "cystic duct") duct = region;
  ASSERT_EQ(world.clips().size(), 3U);
  std::vector<std::uint32_t> part_of_clip;
  const Parts parts = face_connected_parts(mesh);
  for (const Clip& clip : world.clips()) {
    EXPECT_TRUE(clip.closes(duct, mesh, world.state().positions));
    part_of_clip.push_back(parts.of_tet[clip.tets().front().index()]);
  }
  EXPECT_EQ(part_of_clip[0], part_of_clip[1]);
  EXPECT_NE(part_of_clip[1], part_of_clip[2]);
  EXPECT_LT(world.report().deepest_overlap, 1e-3);
}

}  // namespace
}  // namespace calot::test
