#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <set>

#include "calot/base/error.h"
#include "calot/cut/cut.h"
#include "tests/cut/exact.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

/// The rule in one sentence, without any of the program's shortcuts: tets with corners strictly on both sides.
std::vector<TetId> crossed_by(const TetMesh& mesh, const Plane& plane) {
  std::vector<TetId> crossed;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    bool above = false, below = false;
    for (const VertexId v : mesh.tets[t]) {
      const int side = rational_side(mesh.position(v), plane.point, plane.normal);
      above |= side > 0;
      below |= side < 0;
    }
    if (above && below) crossed.emplace_back(t);
  }
  return crossed;
}

Plane random_plane(const TetMesh& mesh, Random& random) {
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Plane plane;
  for (int axis = 0; axis < 3; ++axis) {
    plane.point[axis] = random.between(low[axis], high[axis]);
    plane.normal[axis] = random.between(-1, 1);
  }
  return plane;
}

/// Whether any two vertices strictly on different sides are still joined through faces.
bool separated(const TetMesh& mesh, const Edit& edit, const Plane& plane) {
  TetMesh after = mesh;
  apply(after, edit);
  for (const std::vector<VertexId>& part : face_connected_parts(after).vertices) {
    bool above = false, below = false;
    for (const VertexId v : part) {
      const int side = rational_side(after.position(v), plane.point, plane.normal);
      above |= side > 0;
      below |= side < 0;
    }
    if (above && below) return false;
  }
  return true;
}

TEST(CutPlane, RemovesExactlyTheCrossedTets) {
  const TetMesh meshes[] = {biliary_mesh(), box_mesh(4, 5, 6, {1, 1, 1}, CubeSplit::five), regular_tet()};
  Random random(7);
  for (const TetMesh& mesh : meshes)
    for (int i = 0; i < 25; ++i) {
      const Plane plane = random_plane(mesh, random);
      const Edit edit = cut(mesh, plane);
      EXPECT_EQ(edit.removed, crossed_by(mesh, plane));
      EXPECT_EQ(edit.report.crossed, edit.removed.size());
      EXPECT_EQ(edit.report.under_the_plane, 0u);
      EXPECT_TRUE(separated(mesh, edit, plane));
    }
}

// Planes through three vertices of the mesh: vertices, edges and often faces lie on them.
TEST(CutPlane, ThroughVertices) {
  const TetMesh mesh = box_mesh(4, 4, 4, {1, 1, 1}), bent = biliary_mesh();
  Random random(8);
  for (const TetMesh* m : {&mesh, &bent})
    for (int i = 0; i < 40; ++i) {
      const Tet& tet = m->tets[random.below(m->tet_count())];
      const Vec3 a = m->position(tet[0]), b = m->position(tet[1]), c = m->position(tet[2]);
      const Plane plane{a, (b - a).cross(c - a)};
      const Edit edit = cut(*m, plane);
      std::set<TetId> removed(edit.removed.begin(), edit.removed.end());
      for (const TetId t : crossed_by(*m, plane)) EXPECT_EQ(removed.erase(t), 1u);
      EXPECT_EQ(removed.size(), edit.report.under_the_plane);
      for (const TetId t : removed)
        for (const VertexId v : m->tet(t)) EXPECT_LE(rational_side(m->position(v), plane.point, plane.normal), 0);
      EXPECT_TRUE(separated(*m, edit, plane));
    }
}

TEST(CutPlane, InTheFacesOfAGridTakesTheLowerTetsThatTouchByAFace) {
  const TetMesh mesh = box_mesh(4, 3, 3, {4, 3, 3});
  const Plane plane{{2, 0, 0}, {1, 0, 0}};
  const Edit edit = cut(mesh, plane);
  EXPECT_EQ(edit.report.crossed, 0u);
  EXPECT_EQ(edit.report.under_the_plane, 2u * 3 * 3);  // two triangles a cell
  EXPECT_EQ(edit.removed.size(), edit.report.under_the_plane);
  for (const TetId t : edit.removed)
    for (const VertexId v : mesh.tet(t)) EXPECT_LE(mesh.position(v).x(), 2);
  EXPECT_TRUE(separated(mesh, edit, plane));
  ASSERT_FALSE(edit.report.notes.empty());
  EXPECT_NE(edit.report.notes[0].find("18 tetrahedra below it went too"), std::string::npos) << edit.report.notes[0];
  // The other side is the lower one when the normal points the other way.
  for (const TetId t : cut(mesh, Plane{{2, 0, 0}, {-1, 0, 0}}).removed)
    for (const VertexId v : mesh.tet(t)) EXPECT_GE(mesh.position(v).x(), 2);
}

TEST(CutPlane, BesideTheMeshOrGrazingItRemovesNothing) {
  const TetMesh mesh = box_mesh(2, 2, 2, {1, 1, 1});
  for (const Plane& plane : {Plane{{5, 0, 0}, {1, 0, 0}}, Plane{{1, 0, 0}, {1, 0, 0}}, Plane{{0, 0, 0}, {-1, 0, 0}},
                             Plane{{0, 0, 0}, {1, 1, 1}}, Plane{{0, 0, 0}, {0, 1, 1}}}) {
    const Edit edit = cut(mesh, plane);
    EXPECT_TRUE(edit.empty());
    ASSERT_EQ(edit.report.notes.size(), 2u);
    EXPECT_NE(edit.report.notes[1].find("nothing is removed"), std::string::npos);
  }
}

TEST(CutPlane, CanRemoveEverything) {
  const TetMesh mesh = box_mesh(3, 3, 1, {1, 1, 1});
  const Edit edit = cut(mesh, {Plane{{0, 0, 0.5}, {0, 0, 1}}, Plane{{0.2, 0.3, 0.25}, {0.1, 0, 1}},
                               Plane{{0.2, 0.3, 0.75}, {0, 0.1, 1}}});
  EXPECT_EQ(edit.removed.size(), mesh.tet_count());
  EXPECT_TRUE(edit.report.hanging.empty());
}

TEST(CutPlane, KeepsToTheRegion) {
  const TetMesh mesh = biliary_mesh();
  const Plane plane{{0.02, 0.015, 0.03}, {0.3, 0.1, 1}};
  const std::vector<TetId> all = cut(mesh, plane).removed;
  std::vector<TetId> duct, others;
  for (const TetId t : all) (mesh.regions[t.index()] == 3 ? duct : others).push_back(t);
  ASSERT_FALSE(duct.empty());
  ASSERT_FALSE(others.empty());
  EXPECT_EQ(cut(mesh, plane, {.region = "cystic duct"}).removed, duct);
  EXPECT_EQ(cut(mesh, plane, {.region = "3"}).removed, duct);
  EXPECT_THROW(cut(mesh, plane, {.region = "spleen"}), InputError);
}

TEST(CutPlane, FacesBetweenRegionsStayJoinedWhenTheLowerSideIsOutside) {
  const TetMesh mesh = bar_mesh(4, 4, 2);  // "near" below x = 2, "far" above
  const Plane plane{{2, 0, 0}, {1, 0, 0}};
  const Edit edit = cut(mesh, plane, {.region = "far"});
  EXPECT_TRUE(edit.empty());
  EXPECT_NE(edit.report.notes[1].find("still join the parts"), std::string::npos) << edit.report.notes[1];
  EXPECT_EQ(cut(mesh, plane, {.region = "near"}).removed, cut(mesh, plane).removed);
}

TEST(CutPlane, SeveralAtOnceAreSeveralOneAfterAnother) {
  Random random(9);
  for (const TetMesh& mesh : {biliary_mesh(), box_mesh(4, 4, 4, {1, 1, 1})})
    for (int i = 0; i < 10; ++i) {
      std::vector<Blade> blades;
      for (int b = 0; b < 3; ++b) blades.emplace_back(random_plane(mesh, random));
      blades.emplace_back(Plane{mesh.positions[random.below(mesh.vertex_count())], {1, 0, 0}});
      blades.emplace_back(Plane{mesh.positions[random.below(mesh.vertex_count())], {0, 0, -1}});
      const Edit at_once = cut(mesh, blades);
      TetMesh after = mesh;
      std::vector<TetId> number(mesh.tet_count());
      for (std::size_t t = 0; t < number.size(); ++t) number[t] = TetId(t);
      std::vector<TetId> removed;
      for (const Blade& blade : blades) {
        const Remap remap = apply(after, [&] {
          const Edit edit = cut(after, blade);
          for (const TetId t : edit.removed) removed.push_back(number[t.index()]);
          return edit;
        }());
        std::vector<TetId> renumbered;
        for (const TetId t : remap.tet_to_old) renumbered.push_back(number[t.index()]);
        number = renumbered;
      }
      std::sort(removed.begin(), removed.end());
      EXPECT_EQ(at_once.removed, removed);
    }
}

TEST(CutPlane, RefusesDegeneratePlanes) {
  const TetMesh mesh = regular_tet();
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 0}}, Plane{{0, 0, 0}, {nan, 0, 1}}, Plane{{0, inf, 0}, {0, 0, 1}},
                             Plane{{0, 0, 0}, {0, inf, 1}}})
    EXPECT_THROW(cut(mesh, plane), InputError);
  EXPECT_EQ(cut(mesh, Plane{{0, 0, 0}, {0, 0, 5e-324}}).removed.size(), 1u);
  EXPECT_EQ(cut(mesh, Plane{{0, 0, 0}, {0, 0, 1e308}}).removed.size(), 1u);
}

}  // namespace
}  // namespace calot::test
