// Meshes of label maps: conforming, closed, sized as asked, of the right volume, and the same every time.
#include "calot/patient/mesher.h"

#include <gtest/gtest.h>

#include "calot/mesh/parts.h"
#include "calot/patient/phantom.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

/// What every mesh of this room promises.
void expect_sound(const LabelMesh& meshed, std::size_t vertices) {
  EXPECT_TRUE(validate(meshed.mesh).describe().empty()) << validate(meshed.mesh).describe();
  EXPECT_TRUE(meshed.outer.closed_manifold());
  EXPECT_NEAR(static_cast<double>(meshed.mesh.vertex_count()), static_cast<double>(vertices),
              0.03 * static_cast<double>(vertices));
  EXPECT_GE(meshed.quality.min_dihedral, 10);
  EXPECT_LE(meshed.quality.max_dihedral, 165);
  for (const MeshedRegion& region : meshed.regions) {
    TetMesh part = meshed.mesh;
    part.tets.clear();
    part.regions.clear();
    for (std::size_t t = 0; t < meshed.mesh.tet_count(); ++t)
      if (meshed.mesh.regions[t] == region.label) {
        part.tets.push_back(meshed.mesh.tets[t]);
        part.regions.push_back(region.label);
      }
    EXPECT_EQ(face_connected_parts(part).count(), 1u) << region.name;
    EXPECT_NEAR(region.quality.volume / region.voxel_volume, 1, 0.05) << region.name;
  }
}

TEST(Mesher, meshes_the_phantom) {
  const Phantom phantom = make_biliary_tree(3);
  MesherOptions options;
  options.vertices = 1500;
  Progress progress;
  const LabelMesh meshed = mesh_labels(phantom.labels, options, progress);
  expect_sound(meshed, options.vertices);
  ASSERT_EQ(meshed.regions.size(), 3u);
  EXPECT_EQ(face_connected_parts(meshed.mesh).count(), 1u);
  EXPECT_EQ(meshed.mesh.region_names.at(label_of(Structure::cystic_duct)), "cystic duct");
  EXPECT_LT(meshed.regions[1].quality.mean_edge, 0.5 * meshed.regions[0].quality.mean_edge)
      << "the thin duct gets small tets";
  Eigen::AlignedBox3d box;
  for (const Vec3& p : meshed.mesh.positions) box.extend(p);
  EXPECT_TRUE(box.contains(phantom.lines[0].points[phantom.lines[0].points.size() / 2]))
      << "in the patient's coordinates";
}

TEST(Mesher, refines_a_region_to_the_edge_asked_for) {
  const Phantom phantom = make_biliary_tree(4);
  MesherOptions options;
  options.vertices = 3000;
  options.refine = {{label_of(Structure::cystic_duct), 0.8e-3}};
  Progress progress;
  const LabelMesh meshed = mesh_labels(phantom.labels, options, progress);
  expect_sound(meshed, options.vertices);
  EXPECT_NEAR(meshed.regions[1].quality.mean_edge, 0.8e-3, 0.2 * 0.8e-3);
}

TEST(Mesher, keeps_oblique_and_left_handed_geometry) {
  for (const double handed : {1.0, -1.0}) {
    const VoxelGrid grid = test::oblique_grid({1, 1, 1}, {0.001, handed * 0.001, 0.0015});
    const LabelMap map = test::half_balls(12, grid);
    MesherOptions options;
    options.vertices = 600;
    Progress progress;
    const LabelMesh meshed = mesh_labels(map, options, progress);
    expect_sound(meshed, options.vertices);
    const Vec3 centre = map.grid.to_world * Vec3(13, 13, 13), apart = map.grid.to_world.linear() * Vec3::UnitX();
    Vec3 mean[2] = {Vec3::Zero(), Vec3::Zero()};
    double volume[2] = {0, 0};
    for (std::size_t t = 0; t < meshed.mesh.tet_count(); ++t) {
      const double v = signed_volume(meshed.mesh, TetId(t));
      const auto side = static_cast<std::size_t>(meshed.mesh.regions[t] - 1);
      for (const VertexId corner : meshed.mesh.tets[t]) mean[side] += v / 4 * meshed.mesh.position(corner);
      volume[side] += v;
    }
    EXPECT_LT(((mean[0] + mean[1]) / (volume[0] + volume[1]) - centre).norm(), 0.3e-3);
    EXPECT_LT((mean[0] / volume[0] - centre).dot(apart), 0) << "label 1 lies towards −i";
    EXPECT_GT((mean[1] / volume[1] - centre).dot(apart), 0);
  }
}

TEST(Mesher, gives_the_same_mesh_every_time) {
  const LabelMap map = test::half_balls(10, test::oblique_grid({1, 1, 1}, {0.001, 0.001, 0.001}));
  MesherOptions options;
  options.vertices = 500;
  Progress progress;
  const LabelMesh first = mesh_labels(map, options, progress), second = mesh_labels(map, options, progress);
  EXPECT_EQ(first.mesh.positions, second.mesh.positions);
  EXPECT_EQ(first.mesh.tets, second.mesh.tets);
  EXPECT_EQ(first.mesh.regions, second.mesh.regions);
}

TEST(Mesher, gives_specks_to_what_surrounds_them_and_says_so) {
  LabelMap map = test::half_balls(12, test::oblique_grid({1, 1, 1}, {0.001, 0.001, 0.001}));
  map.voxels[map.grid.index(20, 13, 13)] = 1;  // inside the other half
  map.voxels[map.grid.index(1, 1, 1)] = 2;     // outside
  MesherOptions options;
  options.vertices = 500;
  Progress progress;
  const LabelMesh meshed = mesh_labels(map, options, progress);
  expect_sound(meshed, options.vertices);
  EXPECT_EQ(meshed.regions[0].specks, 1u);
  EXPECT_EQ(meshed.regions[1].specks, 1u);
  ASSERT_GE(meshed.notes.size(), 2u);
  EXPECT_NE(meshed.notes.back().find("2 (right half)"), std::string::npos);
}

TEST(Mesher, meshes_what_the_border_cuts) {
  const LabelMap map = test::map_of(test::oblique_grid({20, 20, 20}, {0.001, 0.001, 0.001}),
                                    [](int, int, int k) -> Label { return k < 10 ? 9 : 0; });
  MesherOptions options;
  options.vertices = 500;
  Progress progress;
  const LabelMesh meshed = mesh_labels(map, options, progress);
  EXPECT_TRUE(meshed.outer.closed_manifold());
  EXPECT_NEAR(meshed.regions[0].quality.volume / 4e-6, 1, 0.05);
}

TEST(Mesher, refuses_bad_options) {
  const LabelMap map = test::half_balls(6, test::oblique_grid({1, 1, 1}, {0.001, 0.001, 0.001}));
  Progress progress;
  const auto message = [&](auto change) {
    MesherOptions options;
    change(options);
    return test::message_of([&] { mesh_labels(map, options, progress); });
  };
  EXPECT_NE(message([](MesherOptions& o) { o.vertices = 3; }).find("fewer than 50"), std::string::npos);
  EXPECT_NE(message([](MesherOptions& o) { o.labels = {1, 7}; }).find("label 7"), std::string::npos);
  EXPECT_NE(message([](MesherOptions& o) { o.refine = {{1, -1}}; }).find("isn't positive"), std::string::npos);
  EXPECT_NE(message([](MesherOptions& o) {
              o.labels = {1}, o.refine = {{2, 0.001}};
            }).find("isn't meshed"),
            std::string::npos);
  EXPECT_NE(message([](MesherOptions& o) { o.smoothing = 9; }).find("voxels"), std::string::npos);
  const LabelMap empty = test::map_of(map.grid, [](int, int, int) -> Label { return 0; });
  EXPECT_NE(test::message_of([&] { mesh_labels(empty, {}, progress); }).find("no label but background"),
            std::string::npos);
}

TEST(Mesher, says_how_near_it_came_when_the_count_is_out_of_reach) {
  const LabelMap map = test::half_balls(8, test::oblique_grid({1, 1, 1}, {0.001, 0.001, 0.001}));
  Progress progress;
  MesherOptions options;
  options.vertices = 60;
  options.tries = 4;
  options.refine = {{1, 0.001}, {2, 0.001}};
  EXPECT_NE(test::message_of([&] { mesh_labels(map, options, progress); }).find("the nearest had"), std::string::npos);
}

TEST(Mesher, stops_on_request) {
  const LabelMap map = test::half_balls(8, test::oblique_grid({1, 1, 1}, {0.001, 0.001, 0.001}));
  Progress progress;
  progress.request_stop();
  EXPECT_THROW(mesh_labels(map, {}, progress), Interrupted);
}

}  // namespace
}  // namespace calot
