// The example scenes are read, short, and give sound tissue.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "calot/mesh/quality.h"
#include "calot/scene/scene_file.h"
#include "calot/scene/tissue.h"
#include "fuzz/tiny_patient.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

TEST(ExampleScenes, AreReadAndShort) {
  const TempFolder patient;
  fuzz::write_tiny_files(patient.path());
  write_bytes(patient / "patient.toml", fuzz::tiny_patient_toml());
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CALOT_SOURCE_DIR "/examples/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path());
    const std::string text = read_bytes(entry.path());
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60);
    Scene scene = read_scene(entry.path());
    EXPECT_FALSE(scene.title.empty());
    EXPECT_GT(scene.steps, 0u);
    // Patients are made by who runs the scene: here one of four cubes stands in.
    const bool of_patient = !scene.patient.empty();
    if (of_patient) {
      scene.patient = patient.path();
      const std::set<std::string> there = {"liver", "gallbladder", "cystic duct", "common bile duct"};
      std::erase_if(scene.regions, [&](const RegionSettings& settings) { return !there.contains(settings.region); });
    }
    const SceneTissue tissue = load_tissue(scene);
    EXPECT_EQ(validate(tissue.model.mesh()).describe(), "");
    EXPECT_GT(tissue.model.mesh().tet_count(), of_patient ? 1u : 100u);
    EXPECT_LT(tissue.model.mesh().tet_count(), 20000u);
    for (const SceneInstrument& tool : scene.instruments) {
      const std::optional<Vec3> port =
          of_patient ? Vec3(0.1, 0.1, 0.1) : port_of(tool, tissue);  // the stand-in has other ports
      for (double t = 0; t < scene.time_step * static_cast<double>(scene.steps); t += 0.05)
        EXPECT_TRUE(input_at(tool.script, 0.02, port, t).pose.position.allFinite());
    }
    ++count;
  }
  EXPECT_GE(count, 5);
}

}  // namespace
}  // namespace calot::test
