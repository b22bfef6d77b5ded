// Connected parts and hinges.
#include "calot/mesh/parts.h"

#include <gtest/gtest.h>

#include <set>

#include "calot/mesh/topology_edit.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

std::vector<VertexId> ids(std::initializer_list<int> numbers) {
  std::vector<VertexId> result;
  for (const int n : numbers) result.emplace_back(n);
  return result;
}

TEST(Parts, OneBlockIsOnePart) {
  const TetMesh mesh = biliary_mesh();
  const Parts parts = face_connected_parts(mesh);
  ASSERT_EQ(parts.count(), 1u);
  EXPECT_EQ(parts.tets[0].size(), mesh.tet_count());
  EXPECT_EQ(parts.vertices[0].size(), mesh.vertex_count());
  EXPECT_TRUE(hinges(mesh, parts).empty());
}

TEST(Parts, AFaceJoins) {
  EXPECT_EQ(face_connected_parts(two_tets()).count(), 1u);
}

TEST(Parts, AnEdgeIsAHinge) {
  const TetMesh mesh = two_tets_on_an_edge();
  const Parts parts = face_connected_parts(mesh);
  ASSERT_EQ(parts.count(), 2u);
  const std::vector<Hinge> found = hinges(mesh, parts);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].part, 0u);
  EXPECT_EQ(found[0].other, 1u);
  EXPECT_EQ(found[0].vertices, ids({0, 1}));
  EXPECT_EQ(vertex_connected_groups(mesh), std::vector<std::uint32_t>(6, 0));
}

TEST(Parts, AVertexIsAHinge) {
  const TetMesh mesh = two_tets_on_a_vertex();
  const Parts parts = face_connected_parts(mesh);
  ASSERT_EQ(parts.count(), 2u);
  const std::vector<Hinge> found = hinges(mesh, parts);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].vertices, ids({0}));
  EXPECT_EQ(parts.vertices[1], ids({0, 4, 5, 6}));
}

TEST(Parts, SeveralPartsOnOneHinge) {
  // Checkerboard cells meet along edges and at vertices only.
  const TetMesh mesh = cell_mesh(2, 2, 2, {1, 1, 1}, [](int i, int j, int k) { return (i + j + k) % 2 == 0 ? 1 : 0; });
  const Parts parts = face_connected_parts(mesh);
  EXPECT_EQ(parts.count(), 4u);
  const std::vector<Hinge> found = hinges(mesh, parts);
  EXPECT_EQ(found.size(), 6u);
  for (const Hinge& hinge : found) EXPECT_EQ(hinge.vertices.size(), 2u);  // two cubes share an edge
}

TEST(Parts, NumberedByFirstTetAndComplete) {
  TetMesh mesh = biliary_mesh();
  apply(mesh, {tets_where(mesh, [](const Vec3& p) { return p.x() > 0.018 && p.x() < 0.024; }), {}, {}});
  apply(mesh,
        {tets_where(mesh, [](const Vec3& p) { return p.x() < 0.01 && p.z() > 0.0203 && p.z() < 0.0252; }), {}, {}});
  const Parts parts = face_connected_parts(mesh);
  ASSERT_EQ(parts.count(), 3u);
  std::uint32_t next = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    ASSERT_LE(parts.of_tet[t], next);
    if (parts.of_tet[t] == next) ++next;
  }
  EXPECT_EQ(next, 3u);
  std::size_t tets = 0;
  for (std::size_t p = 0; p < 3; ++p) {
    tets += parts.tets[p].size();
    EXPECT_TRUE(std::is_sorted(parts.vertices[p].begin(), parts.vertices[p].end()));
    for (const TetId t : parts.tets[p]) EXPECT_EQ(parts.of_tet[t.index()], p);
  }
  EXPECT_EQ(tets, mesh.tet_count());
  EXPECT_TRUE(hinges(mesh, parts).empty());
  const std::vector<std::uint32_t> groups = vertex_connected_groups(mesh);
  EXPECT_EQ(std::set<std::uint32_t>(groups.begin(), groups.end()).size(), 3u);
}

TEST(Parts, VerticesWithoutTetsAreGroupsOfTheirOwn) {
  TetMesh mesh = two_tets();
  mesh.positions.emplace_back(5, 5, 5);
  mesh.positions.emplace_back(6, 6, 6);
  EXPECT_EQ(vertex_connected_groups(mesh), (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 1, 2}));
}

TEST(Parts, NoTets) {
  const TetMesh mesh;
  EXPECT_EQ(face_connected_parts(mesh).count(), 0u);
  EXPECT_TRUE(vertex_connected_groups(mesh).empty());
}

}  // namespace
