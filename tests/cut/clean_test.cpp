#include <gtest/gtest.h>

#include <algorithm>

#include "calot/cut/cut.h"
#include "calot/cut/hanging.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

/// A box with a crumb: two more tets stand on the top by a bridge tet, which a cut at z = 1.5 … takes away.
struct Crumb {
  TetMesh mesh = box_mesh(3, 3, 1, {3, 3, 1});
  std::size_t box_tets = mesh.tet_count();

  VertexId add(const Vec3& p) {
    mesh.positions.push_back(p);
    return VertexId(mesh.positions.size() - 1);
  }
  void tet(VertexId a, VertexId b, VertexId c, VertexId d) {
    if (signed_volume(mesh.position(a), mesh.position(b), mesh.position(c), mesh.position(d)) < 0) std::swap(c, d);
    mesh.tets.push_back({a, b, c, d});
    mesh.regions.push_back(1);
  }
};

std::vector<TetId> after_cut(const TetMesh& mesh, const Edit& edit, std::size_t& parts) {
  TetMesh copy = mesh;
  apply(copy, edit);
  parts = face_connected_parts(copy).count();
  return edit.removed;
}

// Three tets in a row over the edge 0–1 of a big block: removing the middle one leaves the last alone.
TEST(CutClean, DropsATetLeftAlone) {
  Crumb crumb;
  const auto corner = [](int i, int j) { return VertexId(i + 4 * j + 16); };  // on top of the box
  const VertexId a = crumb.add({0.3, 0.3, 2}), b = crumb.add({0.9, 0.4, 2.1}), c = crumb.add({0.4, 0.9, 2.2});
  const VertexId d = crumb.add({0.5, 0.5, 3});
  crumb.tet(corner(0, 0), corner(1, 0), corner(1, 1), a);
  crumb.tet(corner(1, 0), corner(1, 1), a, b);
  crumb.tet(corner(1, 1), a, b, c);
  crumb.tet(a, b, c, d);
  const Plane plane{{0, 0, 1.7}, {0, 0, 1}};
  const Edit kept = cut(crumb.mesh, plane);
  EXPECT_EQ(kept.removed.size(), 3u);
  EXPECT_EQ(kept.report.hanging, std::vector<TetId>{TetId(crumb.mesh.tet_count() - 1)});
  EXPECT_EQ(kept.report.cleaned, 0u);
  const Edit cleaned = cut(crumb.mesh, plane, {.clean = true});
  EXPECT_EQ(cleaned.removed.size(), 4u);
  EXPECT_EQ(cleaned.report.cleaned, 1u);
  std::size_t parts = 0;
  after_cut(crumb.mesh, cleaned, parts);
  EXPECT_EQ(parts, 1u);
}

// A pair of tets joined to a block through one tet: without it, the pair hangs by an edge of the block.
TEST(CutClean, DropsAPairHingedByAnEdge) {
  TetMesh mesh = two_tets();
  mesh.regions = {1, 1};
  Crumb crumb;
  const VertexId p(16), q(17), r(21);  // a top edge of the box, and the corner of its triangle
  const VertexId a = crumb.add({0.4, 0.2, 2}), b = crumb.add({0.6, -1, 1.8}), c = crumb.add({0.5, -1, 3});
  crumb.tet(p, q, r, a);
  crumb.tet(p, q, a, b);
  crumb.tet(p, a, b, c);
  const TetId bridge(crumb.box_tets), first(crumb.box_tets + 1), second(crumb.box_tets + 2);
  const std::vector<std::vector<std::int8_t>> sides{std::vector<std::int8_t>(crumb.mesh.vertex_count(), 1)};
  const auto pieces = detail::hanging_pieces(crumb.mesh, {bridge}, sides);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0], (std::vector<TetId>{first, second}));
  EXPECT_EQ(detail::describe_hinges(crumb.mesh, {bridge}),
            "parts stay hinged on each other, without a shared face, at 2 vertices (16, 17)");
}

TEST(CutClean, NeverDropsMainPartsHingedOnThePlane) {
  const TetMesh mesh = box_mesh(2, 2, 2, {1, 1, 1});  // every tet borders the cut
  const Edit edit = cut(mesh, Plane{{0.5, 0, 0}, {1, 0, 0}}, {.clean = true});
  EXPECT_EQ(edit.removed.size(), edit.report.under_the_plane + edit.report.cleaned);
  std::size_t parts = 0;
  after_cut(mesh, edit, parts);
  EXPECT_EQ(parts, 2u);
  EXPECT_NE(edit.report.notes.back().find("hinged"), std::string::npos);
}

TEST(CutClean, NeverDropsTheLargestPiece) {
  for (const TetMesh& mesh : {two_tets(), two_tets_on_an_edge(), two_tets_on_a_vertex()}) {
    const Edit edit = cut(mesh, Plane{{0.25, 0.25, 0.5}, {0, 0, 1}}, {.clean = true});
    EXPECT_EQ(edit.removed.size(), 1u);
    EXPECT_EQ(edit.report.cleaned, 0u);
    EXPECT_TRUE(edit.report.hanging.empty());  // the second tet was not made by the cut, or is all that is left
  }
}

TEST(CutClean, WhatHungBeforeIsLeftAlone) {
  TetMesh mesh = box_mesh(4, 1, 1, {4, 1, 1});
  // A tet hinged on the far corner of the box before any cut.
  const VertexId corner(4);
  for (const Vec3& p : {Vec3(5, 0, 0), Vec3(4, -1, 0), Vec3(4, 0, -1)}) mesh.positions.push_back(p);
  const std::size_t n = mesh.vertex_count();
  mesh.tets.push_back({corner, VertexId(n - 3), VertexId(n - 1), VertexId(n - 2)});
  mesh.regions.push_back(1);
  ASSERT_NE(signed_volume(mesh, TetId(mesh.tet_count() - 1)), 0);
  const Edit edit = cut(mesh, Plane{{1.5, 0, 0}, {1, 0, 0}}, {.clean = true});
  EXPECT_EQ(edit.report.cleaned, 0u);
  EXPECT_FALSE(edit.empty());
}

TEST(CutClean, OnRandomCutsLeavesNoLooseTetAndTheLargestPart) {
  const TetMesh mesh = biliary_mesh();
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const Plane plane{mesh.positions[random.below(mesh.vertex_count())],
                      {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}};
    const Edit plain = cut(mesh, plane), cleaned = cut(mesh, plane, {.clean = true});
    EXPECT_EQ(cleaned.report.cleaned, plain.report.hanging.size());
    EXPECT_EQ(cleaned.removed.size(), plain.removed.size() + plain.report.hanging.size());
    TetMesh after = mesh;
    apply(after, cleaned);
    const Parts parts = face_connected_parts(after);
    for (const auto& tets : parts.tets) EXPECT_TRUE(parts.count() == 1 || tets.size() > 1);
  }
}

TEST(CutClean, KeepsToTheRegion) {
  Crumb crumb;
  const VertexId p(16), q(17), r(21);
  const VertexId a = crumb.add({0.4, 0.2, 2}), b = crumb.add({0.6, -1, 1.8}), c = crumb.add({0.3, 0.3, 3});
  crumb.tet(p, q, r, a);
  crumb.tet(q, r, a, b);
  crumb.tet(r, a, b, c);
  crumb.mesh.regions.back() = 2;
  const Plane plane{{0, 0, 1.5}, {0, 0, 1}};
  const Edit edit = cut(crumb.mesh, plane, {.region = "1", .clean = true});
  EXPECT_EQ(edit.report.cleaned, 0u);
  for (const TetId t : edit.removed) EXPECT_EQ(crumb.mesh.regions[t.index()], 1);
}

}  // namespace
}  // namespace calot::test
