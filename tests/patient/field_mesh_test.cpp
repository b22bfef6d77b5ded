// The mesh of a whole field: organs of very different size, thin tubes inside fat, one conforming mesh.
#include "calot/patient/field_mesh.h"

#include <gtest/gtest.h>

#include "calot/mesh/parts.h"
#include "calot/patient/sweep.h"
#include "tests/support/files.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

void paint(LabelMap& map, Structure s, const BallChain& body, const std::vector<Structure>& over) {
  const std::size_t slice = map.grid.size[0] * map.grid.size[1];
  std::vector<float> distance(slice);
  for (std::size_t k = 0; k < map.grid.size[2]; ++k) {
    std::fill(distance.begin(), distance.end(), 1.0f);
    lower_to_distance(body, map.grid, k, 1 * mm, distance);
    for (std::size_t v = 0; v < slice; ++v) {
      Label& label = map.voxels[k * slice + v];
      if (distance[v] < 0 && std::find(over.begin(), over.end(), static_cast<Structure>(label)) != over.end())
        label = label_of(s);
    }
  }
}

BallChain tube(const std::vector<Vec3>& through, double radius) {
  std::vector<Vec3> metres;
  for (const Vec3& p : through) metres.push_back(p * mm);
  const Curve line = resampled(spline(metres), 0.2 * mm);
  return balls_along(line, std::vector<double>(line.size(), radius * mm));
}

/// Liver (a large ball's part), gallbladder in its bed, a cystic duct and an artery through fat, a bile duct.
const LabelMap& field() {
  static const LabelMap map = [] {
    constexpr double voxel = 0.8 * mm;
    using enum Structure;
    LabelMap m;
    m.grid.size = {125, 110, 185};
    m.grid.to_world = Eigen::Translation3d(-50 * mm, -43 * mm, -50 * mm) * Eigen::Scaling(voxel);
    m.voxels.assign(m.grid.count(), 0);
    paint(m, liver, {{Vec3(5, 0, 50) * mm, 43 * mm}}, {none});
    paint(m, gallbladder_bed, {{Vec3(18, 5, 2) * mm, 14.5 * mm}}, {liver});
    paint(m, hepatocystic_fat, {{Vec3(-6, 4, 0) * mm, 13 * mm}}, {none});
    paint(m, gallbladder, {{Vec3(18, 5, 0) * mm, 14 * mm}}, {none, hepatocystic_fat, gallbladder_bed, liver});
    paint(m, common_bile_duct, tube({{-14, 0, 0}, {-14, -3, -20}, {-12, -8, -42}}, 2.7), {none, hepatocystic_fat});
    paint(m, common_hepatic_duct, tube({{-14, 0, 1}, {-13, 1, 10}, {-10, 3, 16}}, 2.5),
          {none, hepatocystic_fat, liver});
    paint(m, cystic_duct, tube({{-14, 0, 0}, {-8, 4, -2}, {-2, 3, 1}, {6, 5, 0}}, 1.6), {none, hepatocystic_fat});
    paint(m, cystic_artery, tube({{-13, 3, 7}, {-6, 3, 5}, {0, 5, 5}, {7, 5, 5}}, 0.95), {none, hepatocystic_fat});
    m.names = structure_names();
    return m;
  }();
  return map;
}

TEST(FieldMesh, IsOneSoundMeshOfEveryRegion) {
  Progress silent;
  const LabelMesh meshed = mesh_labels(field(), field_mesh_options(field(), 12000), silent);
  EXPECT_TRUE(validate(meshed.mesh).describe().empty()) << validate(meshed.mesh).describe();
  EXPECT_TRUE(meshed.outer.closed_manifold());
  EXPECT_LE(meshed.quality.tets, 12000u);
  EXPECT_GE(meshed.quality.tets, 11000u);
  EXPECT_GE(meshed.quality.min_dihedral, 10);
  EXPECT_LE(meshed.quality.max_dihedral, 165);
  EXPECT_EQ(face_connected_parts(meshed.mesh).count(), 1u);
  ASSERT_EQ(meshed.regions.size(), 8u) << testing::PrintToString(voxel_counts(field()));
  double duct_edge = 0, liver_edge = 0;
  for (const MeshedRegion& region : meshed.regions) {
    const auto structure = static_cast<Structure>(region.label);
    TetMesh own = meshed.mesh;
    own.tets.clear();
    for (std::size_t t = 0; t < meshed.mesh.tet_count(); ++t)
      if (meshed.mesh.regions[t] == region.label) own.tets.push_back(meshed.mesh.tets[t]);
    own.regions.assign(own.tets.size(), region.label);
    EXPECT_EQ(face_connected_parts(own).count(), 1u) << region.name;
    const double error = region.quality.volume / region.voxel_volume - 1;
    EXPECT_LE(std::abs(error), 0.05) << region.name;
    if (structure == Structure::cystic_duct) duct_edge = region.quality.mean_edge;
    if (structure == Structure::liver) liver_edge = region.quality.mean_edge;
  }
  EXPECT_LT(duct_edge, 2.2 * mm);
  EXPECT_GT(liver_edge, 2 * duct_edge);
}

TEST(FieldMesh, GivesTheSameBytes) {
  Progress silent;
  const MesherOptions options = field_mesh_options(field(), 8000);
  const LabelMesh a = mesh_labels(field(), options, silent), b = mesh_labels(field(), options, silent);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.tets, b.mesh.tets);
  EXPECT_EQ(a.mesh.regions, b.mesh.regions);
}

TEST(FieldMesh, RefusesTooFewTets) {
  EXPECT_NE(test::message_of([] { field_mesh_options(field(), 100); }).find("4000 … 2000000"), std::string::npos);
}

}  // namespace
}  // namespace calot
