// A patient's liver on its ligaments: a blunt tube under its edge lifts it, as one piece and deformable.
#include <gtest/gtest.h>

#include "calot/scene/scene_file.h"
#include "calot/scene/scene_world.h"
#include "fuzz/tiny_patient.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

/// A slab of liver 160 x 100 x 30 mm, x to the right and y to the front, held at its back, 0.5 kg.
void write_liver(const std::filesystem::path& folder) {
  Patient patient = fuzz::tiny_patient();
  patient.mesh = cell_mesh(8, 5, 2, {0.16, 0.10, 0.03}, [](int, int, int) { return label_of(Structure::liver); });
  patient.mesh.region_names = {{label_of(Structure::liver), "liver"}};
  Attachment back{"back", AttachmentKind::fixed, {}, "ligaments"};
  for (std::size_t v = 0; v < patient.mesh.vertex_count(); ++v)
    if (patient.mesh.positions[v].y() < 0.041) back.vertices.emplace_back(v);
  patient.attachments = {back};
  patient.border_cuts.clear();
  std::erase_if(patient.materials, [](const auto& entry) { return entry.first != Structure::liver; });
  std::erase_if(patient.appearances, [](const auto& entry) { return entry.first != Structure::liver; });
  patient.lines.clear();
  patient.landmarks.clips.clear();
  patient.landmarks.cuts.clear();
  fuzz::write_named_files(folder, patient);
  std::ofstream text(folder / "patient.toml");
  detail::write_patient_toml(text, patient, "calot");
}

class LiverLift : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Bodies, LiverLift, testing::Values("rigid", "deformable"));

TEST_P(LiverLift, ATubeLiftsTheEdgeByThirtyMillimetres) {
  const TempFolder folder;
  write_liver(folder.path());
  write_bytes(folder / "s.toml",
              "patient = \".\"\nlength_unit = \"mm\"\nseconds = 2.5\nrayleigh_mass = 5.0\ngravity = [0, 0, 0]\n"
              "[[region]]\nregion = \"liver\"\nbody = \"" +
                  std::string(GetParam()) +
                  "\"\n"
                  "[[instrument]]\nname = \"retractor\"\nkind = \"suction\"\nport = [300, 85, -10]\nkeyframes = [\n"
                  "{ time = 0, tip = [-10, 85, -10] }, { time = 2, tip = [-10, 85, 75] }]\n");
  SceneRun run(read_scene(folder / "s.toml"));
  const std::vector<Vec3> rest = run.world().state().positions;
  for (int k = 0; k < 150; ++k) {
    run.step();
    ASSERT_FALSE(run.world().report().ran_away);
    for (const WorldEvent& event : run.world().events()) EXPECT_NE(event.kind, EventKind::torn);
  }
  ASSERT_EQ(run.world().state().positions.size(), rest.size());
  double front = 0;
  for (std::size_t v = 0; v < rest.size(); ++v)
    if (rest[v].y() > 0.099) front = std::max(front, (run.world().state().positions[v] - rest[v]).z());
  EXPECT_GT(front, 0.030);
  const double force = run.world().instruments()[0].force.norm();
  EXPECT_GT(force, 0.1);
  EXPECT_LT(force, 15);
  RecordProperty("lift_mm", std::to_string(1e3 * front));
  RecordProperty("force_N", std::to_string(force));
}

}  // namespace
}  // namespace calot::test
