// Measures in closed form, and everything that validate() finds.
#include "calot/mesh/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

constexpr double degrees = 180 / 3.14159265358979323846;

TEST(Quality, RegularTet) {
  const Quality q = quality(regular_tet(0.02));
  EXPECT_EQ(q.vertices, 4u);
  EXPECT_EQ(q.tets, 1u);
  EXPECT_NEAR(q.min_dihedral, std::acos(1.0 / 3) * degrees, 1e-10);
  EXPECT_NEAR(q.max_dihedral, std::acos(1.0 / 3) * degrees, 1e-10);
  for (const double edge : {q.min_edge, q.max_edge, q.mean_edge}) EXPECT_NEAR(edge, 0.02, 1e-15);
  EXPECT_NEAR(q.volume, std::pow(0.02, 3) / (6 * std::sqrt(2.0)), 1e-20);
  EXPECT_NEAR(q.min_volume, q.volume, 0);
  EXPECT_NEAR(q.min_radius_ratio, 1, 1e-12);
}

TEST(Quality, CornerOfACube) {
  TetMesh mesh = regular_tet();
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets = {{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}};
  const Quality q = quality(mesh);
  EXPECT_NEAR(q.max_dihedral, 90, 1e-12);
  EXPECT_NEAR(q.min_dihedral, std::acos(1 / std::sqrt(3.0)) * degrees, 1e-10);
  EXPECT_NEAR(q.mean_edge, (3 + 3 * std::sqrt(2.0)) / 6, 1e-15);
  // r = 3V/S with V = 1/6, S = 3/2 + √3/2; R = √3/2.
  EXPECT_NEAR(q.min_radius_ratio, 3 * (0.5 / (1.5 + std::sqrt(3.0) / 2)) / (std::sqrt(3.0) / 2), 1e-12);
}

TEST(Quality, RegionsAddUp) {
  const TetMesh mesh = biliary_mesh();
  double volume = 0;
  std::size_t tets = 0;
  for (const std::int32_t region : {2, 3, 4}) {
    volume += quality(mesh, region).volume;
    tets += quality(mesh, region).tets;
  }
  EXPECT_EQ(tets, quality(mesh).tets);
  EXPECT_NEAR(volume, quality(mesh).volume, 1e-16);
  EXPECT_EQ(quality(mesh, 99).tets, 0u);
  EXPECT_EQ(quality(mesh, 99).min_dihedral, 0);
}

TEST(Quality, FlatAndInvertedTetsHaveNoRadiusRatio) {
  TetMesh mesh = regular_tet();
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  EXPECT_EQ(quality(mesh).min_radius_ratio, 0);
  EXPECT_LT(quality(mesh).min_volume, 0);
}

TEST(Validate, SoundMeshesHaveNoProblems) {
  for (const TetMesh& mesh :
       {box_mesh(2, 2, 2, {1, 1, 1}), bar_mesh(5), biliary_mesh(2), two_tets(), regular_tet(1e-6)}) {
    EXPECT_FALSE(validate(mesh).fatal());
    EXPECT_EQ(validate(mesh).describe(), "");
  }
}

TEST(Validate, Inverted) {
  TetMesh mesh = box_mesh(2, 2, 2, {1, 1, 1});
  for (const std::size_t t : {3u, 17u}) std::swap(mesh.tets[t][0], mesh.tets[t][1]);
  const MeshProblems problems = validate(mesh);
  EXPECT_TRUE(problems.fatal());
  EXPECT_EQ(problems.describe(), "2 inverted tets (3, 17)");
  EXPECT_EQ(orient(mesh), 2u);
  EXPECT_EQ(validate(mesh).describe(), "");
}

TEST(Validate, Flat) {
  TetMesh mesh = two_tets();
  mesh.positions[3] = {0.3, 0.3, 0};
  EXPECT_EQ(validate(mesh).describe(), "1 zero-volume tet (0)");
  mesh.positions[3] = {0.3, 0.3, 1e-16};
  EXPECT_EQ(validate(mesh).flat.size(), 1u);
  mesh.positions[3] = {0.3, 0.3, 1e-12};
  EXPECT_TRUE(validate(mesh).flat.empty());
}

TEST(Validate, BadNumbers) {
  TetMesh mesh = two_tets();
  mesh.tets.push_back({VertexId(0), VertexId(1), VertexId(2), VertexId(77)});
  mesh.regions.push_back(1);
  mesh.tets.push_back({VertexId(0), VertexId(1), VertexId(1), VertexId(3)});
  const MeshProblems problems = validate(mesh);
  EXPECT_TRUE(problems.sizes_differ);
  EXPECT_EQ(problems.out_of_range, std::vector<TetId>{TetId(2)});
  EXPECT_EQ(problems.repeated_vertex, std::vector<TetId>{TetId(3)});
  EXPECT_TRUE(problems.fatal());
}

TEST(Validate, BadPositions) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e101}) {
    TetMesh mesh = two_tets();
    mesh.positions[4].y() = bad;
    EXPECT_EQ(validate(mesh).not_finite, std::vector<VertexId>{VertexId(4)});
    EXPECT_TRUE(validate(mesh).fatal());
  }
}

TEST(Validate, CoincidentAndUnusedVerticesAreNotFatal) {
  TetMesh mesh = two_tets();
  mesh.positions.push_back(mesh.positions[1]);
  mesh.positions[1].y() = -0.0;
  mesh.positions.emplace_back(8, 8, 8);
  const MeshProblems problems = validate(mesh);
  EXPECT_EQ(problems.coincident, std::vector<VertexId>{VertexId(5)});
  EXPECT_EQ(problems.unused, (std::vector<VertexId>{VertexId(5), VertexId(6)}));
  EXPECT_FALSE(problems.fatal());
}

TEST(Validate, RepeatedTetsAndOverfullFaces) {
  TetMesh mesh = two_tets();
  mesh.tets.push_back({mesh.tets[0][1], mesh.tets[0][2], mesh.tets[0][0], mesh.tets[0][3]});
  mesh.regions.push_back(1);
  EXPECT_EQ(validate(mesh).duplicate, std::vector<TetId>{TetId(2)});
  mesh.positions.emplace_back(0.2, 0.2, 2);
  mesh.tets[2] = {VertexId(0), VertexId(1), VertexId(2), VertexId(5)};
  const MeshProblems problems = validate(mesh);
  EXPECT_TRUE(problems.duplicate.empty());
  EXPECT_EQ(problems.overfull_face.size(), 3u);
  EXPECT_TRUE(problems.fatal());
}

// Vertices at one place are two lips of a cut, or a mistake: then tets lie in each other.
TEST(Validate, TetsBetweenTheSamePlacesAreRepeatedToo) {
  TetMesh mesh = two_tets();
  const std::size_t n = mesh.vertex_count();
  const std::vector<Vec3> positions = mesh.positions;
  mesh.positions.insert(mesh.positions.end(), positions.begin(), positions.end());
  mesh.tets.push_back(mesh.tets[1]);
  for (VertexId& v : mesh.tets[2]) v = VertexId(v.index() + n);
  mesh.regions.push_back(1);
  EXPECT_EQ(validate(mesh).duplicate, std::vector<TetId>{TetId(2)});
  EXPECT_TRUE(validate(mesh).fatal());
  // The second tet's neighbour beyond the shared face would be a third tet there.
  TetMesh third = two_tets();
  third.positions.insert(third.positions.end(), positions.begin(), positions.end());
  third.positions.emplace_back(0.2, 0.2, 2);
  third.tets.push_back({VertexId(n + 0), VertexId(n + 1), VertexId(n + 2), VertexId(2 * n)});
  third.regions.push_back(1);
  EXPECT_EQ(validate(third).overfull_face.size(), 3u);
  // The same second tet alone, parted from the first along their face, is sound.
  TetMesh parted = two_tets();
  parted.positions.insert(parted.positions.end(), positions.begin(), positions.end());
  for (VertexId& v : parted.tets[1]) v = VertexId(v.index() + n);
  EXPECT_FALSE(validate(parted).fatal()) << validate(parted).describe();
  EXPECT_EQ(validate(parted).coincident.size(), n);
}

TEST(Validate, NamesOnlyTheFirstFew) {
  TetMesh mesh = box_mesh(2, 1, 1, {1, 1, 1});
  for (Tet& tet : mesh.tets) std::swap(tet[0], tet[1]);
  EXPECT_EQ(validate(mesh).describe(), "12 inverted tets (0, 1, 2, 3, 4, …)");
}

}  // namespace
