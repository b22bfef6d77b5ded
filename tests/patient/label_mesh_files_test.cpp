// The folder that a meshed label map becomes loads as a model.
#include "calot/patient/label_mesh_files.h"

#include <gtest/gtest.h>

#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/patient/phantom.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

std::size_t fixed_count(const Model& model) {
  std::size_t count = 0;
  for (const std::uint8_t flag : model.fixed()) count += flag;
  return count;
}

TEST(LabelMeshFiles, the_phantom_is_held_at_both_ends_of_its_bile_duct) {
  const test::TempFolder folder;
  const Phantom phantom = make_biliary_tree(2, 0.7e-3);
  MesherOptions options;
  options.vertices = 1200;
  Progress progress;
  const LabelMesh meshed = mesh_labels(phantom.labels, options, progress);
  std::filesystem::create_directory(folder / "made");
  write_label_mesh(folder / "made", meshed, "labels.nii.gz");
  for (const std::string& file : label_mesh_files(meshed))
    EXPECT_TRUE(std::filesystem::exists(folder / "made" / file)) << file;
  EXPECT_TRUE(std::filesystem::exists(folder / "made" / "common_bile_duct.stl"));
  const Model model = load_model(folder / "made" / "model.toml");
  ASSERT_EQ(model.mesh().vertex_count(), meshed.mesh.vertex_count());
  for (std::size_t v = 0; v < meshed.mesh.vertex_count(); ++v)
    EXPECT_LT((model.mesh().positions[v] - meshed.mesh.positions[v]).norm(), 1e-12);
  EXPECT_EQ(model.mesh().region_names, meshed.mesh.region_names);
  const Vec3 hilum = phantom.lines[1].points.front(), papilla = phantom.lines[1].points.back();
  std::size_t above = 0, below = 0;
  for (std::size_t v = 0; v < meshed.mesh.vertex_count(); ++v) {
    if (!model.fixed()[v]) continue;
    const double to_hilum = (meshed.mesh.positions[v] - hilum).norm(),
                 to_papilla = (meshed.mesh.positions[v] - papilla).norm();
    EXPECT_LT(std::min(to_hilum, to_papilla), 0.012) << "only the ends";
    ++(to_hilum < to_papilla ? above : below);
  }
  EXPECT_GE(above, 4u);
  EXPECT_GE(below, 4u);
  const Surface surface = read_surface(folder / "made" / "gallbladder.stl", 1e-3);
  EXPECT_FALSE(surface.triangles.empty());
}

TEST(LabelMeshFiles, other_organs_are_held_where_nothing_is_operated) {
  const test::TempFolder folder;
  LabelMap map = test::half_balls(10, test::oblique_grid({1, 1, 1}, {0.002, 0.002, 0.002}));
  MesherOptions options;
  options.vertices = 400;
  Progress progress;
  for (const bool both : {true, false}) {
    options.labels = both ? std::vector<Label>{1, 2} : std::vector<Label>{2};
    write_label_mesh(folder.path(), mesh_labels(map, options, progress), "map.nii");
    const Model model = load_model(folder / "model.toml");
    const std::size_t fixed = fixed_count(model);
    EXPECT_GE(fixed, 4u);
    EXPECT_LT(fixed, model.mesh().vertex_count() / 2);
  }
}

TEST(LabelMeshFiles, a_map_without_names_still_gives_files) {
  const test::TempFolder folder;
  LabelMap map = test::half_balls(8, test::oblique_grid({1, 1, 1}, {0.002, 0.002, 0.002}));
  map.names.clear();
  MesherOptions options;
  options.vertices = 300;
  Progress progress;
  write_label_mesh(folder.path(), mesh_labels(map, options, progress), "map.nii");
  EXPECT_TRUE(std::filesystem::exists(folder / "region_1.stl"));
  EXPECT_GT(load_model(folder / "model.toml").mesh().tet_count(), 0u);
}

}  // namespace
}  // namespace calot
