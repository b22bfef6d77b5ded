#include "calot/fem/support.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace calot {
namespace {

std::vector<std::uint8_t> hold(const TetMesh& mesh, std::initializer_list<std::uint32_t> vertices) {
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  for (const std::uint32_t v : vertices) fixed[v] = 1;
  return fixed;
}

TEST(Support, OneTetNeedsThreeVerticesOffALine) {
  const TetMesh tet = test::regular_tet();
  EXPECT_NE(unsupported_part(tet, hold(tet, {})).find("drift"), std::string::npos);
  EXPECT_NE(unsupported_part(tet, hold(tet, {0})).find("turn"), std::string::npos);
  EXPECT_NE(unsupported_part(tet, hold(tet, {0, 1})).find("turn"), std::string::npos);
  EXPECT_EQ(unsupported_part(tet, hold(tet, {0, 1, 2})), "");
}

TEST(Support, CollinearVerticesHoldNothing) {
  const TetMesh bar = test::box_mesh(4, 1, 1, {0.4, 0.1, 0.1});
  EXPECT_NE(unsupported_part(bar, hold(bar, {0, 1, 2, 3, 4})), "");
  EXPECT_EQ(unsupported_part(bar, hold(bar, {0, 1, 2, 3, 4, 5})), "");
}

TEST(Support, HingesDoNotHold) {
  const TetMesh on_vertex = test::two_tets_on_a_vertex(), on_edge = test::two_tets_on_an_edge(),
                on_face = test::two_tets();
  const auto first_tet_held = [](const TetMesh& mesh) {
    std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
    for (const VertexId v : mesh.tets[0]) fixed[v.index()] = 1;
    return fixed;
  };
  EXPECT_NE(unsupported_part(on_vertex, first_tet_held(on_vertex)), "");
  EXPECT_NE(unsupported_part(on_edge, first_tet_held(on_edge)), "");
  EXPECT_EQ(unsupported_part(on_face, first_tet_held(on_face)), "");
}

// A part without a fixed vertex of its own, hinged by one edge to one held part and by a vertex to another, is held:
// the two hinges together stop the turning that each alone allows.
TEST(Support, TwoHingesTogetherHold) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0},    {1, 0, 0},     {0, 1, 0}, {0, 0, 1},  // the middle tet
                    {0.5, 0, -1}, {0.5, -1, -1},                        // with 0 and 1: hinged on the edge 0–1
                    {-1, 0, 2},   {-1, 1, 2},    {-1, 0, 3}};           // with 3: hinged on a vertex
  const auto tet = [](int a, int b, int c, int d) { return Tet{VertexId(a), VertexId(b), VertexId(c), VertexId(d)}; };
  mesh.tets = {tet(0, 1, 2, 3), tet(0, 1, 4, 5), tet(3, 6, 7, 8)};
  mesh.regions = {1, 1, 1};
  EXPECT_EQ(unsupported_part(mesh, hold(mesh, {0, 1, 4, 5, 6, 7, 8})), "");
  EXPECT_NE(unsupported_part(mesh, hold(mesh, {0, 1, 4, 5})), "");
}

TEST(Support, NamesThePartAndItsRegion) {
  TetMesh mesh = test::box_mesh(1, 1, 1, {1, 1, 1});
  const std::size_t held = mesh.vertex_count(), tets = mesh.tet_count();
  TetMesh other = test::regular_tet();
  for (const Vec3& p : other.positions) mesh.positions.push_back(p + Vec3(5, 5, 5));
  const auto shifted = [&](int v) { return VertexId(held + static_cast<std::size_t>(v)); };
  mesh.tets.push_back({shifted(0), shifted(1), shifted(2), shifted(3)});
  mesh.regions.push_back(7);
  mesh.region_names[7] = "gallbladder";
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  std::fill_n(fixed.begin(), held, std::uint8_t{1});
  const std::string found = unsupported_part(mesh, fixed);
  EXPECT_NE(found.find("gallbladder"), std::string::npos) << found;
  EXPECT_NE(found.find("1 tets"), std::string::npos) << found;
  EXPECT_GT(tets, 0u);
}

}  // namespace
}  // namespace calot
