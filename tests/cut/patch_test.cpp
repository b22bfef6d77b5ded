#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/cut/cut.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

bool contains(const std::vector<TetId>& sorted, TetId t) {
  return std::binary_search(sorted.begin(), sorted.end(), t);
}

bool is_subset(const std::vector<TetId>& part, const std::vector<TetId>& whole) {
  return std::includes(whole.begin(), whole.end(), part.begin(), part.end());
}

Vec3 random_vector(Random& random) {
  return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
}

/// Whether x lies in the tet by its four signed volumes.
bool inside_tet(const TetMesh& mesh, TetId t, const Vec3& x) {
  const Tet& v = mesh.tet(t);
  const Vec3 a = mesh.position(v[0]), b = mesh.position(v[1]), c = mesh.position(v[2]), d = mesh.position(v[3]);
  return std::min({signed_volume(x, b, c, d), signed_volume(a, x, c, d), signed_volume(a, b, x, d),
                   signed_volume(a, b, c, x)}) > 1e-12;
}

TEST(CutPatch, ALargeOneCutsAsItsPlane) {
  const TetMesh mesh = biliary_mesh();
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Vec3 centre = mesh.positions[random.below(mesh.vertex_count())], normal = random_vector(random);
    const BladePatch patch{centre, normal, random_vector(random), 10, 10};
    EXPECT_EQ(cut(mesh, patch).removed, cut(mesh, Plane{centre, normal}).removed);
  }
}

// Every tet that a point strewn over the blade hits is taken, and no tet farther from the blade than its own size is.
TEST(CutPatch, TakesWhatItTouchesAndNothingBeyond) {
  const TetMesh mesh = box_mesh(5, 5, 5, {1, 1, 1}, CubeSplit::five);
  Random random(2);
  for (int i = 0; i < 15; ++i) {
    const Vec3 centre = Vec3(0.5, 0.5, 0.5) + 0.3 * random_vector(random);
    const Vec3 normal = random_vector(random).normalized(), across = normal.cross(random_vector(random)).normalized();
    const Vec3 along = across.cross(normal);
    const double length = random.between(0.05, 0.8), width = random.between(0.05, 0.8);
    const std::vector<TetId> removed = cut(mesh, BladePatch{centre, normal, along, length, width}).removed;
    EXPECT_TRUE(is_subset(removed, cut(mesh, Plane{centre, normal}).removed));
    for (int k = 0; k < 300; ++k) {
      const Vec3 x = centre + random.between(-0.5, 0.5) * length * along + random.between(-0.5, 0.5) * width * across;
      for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        EXPECT_TRUE(!inside_tet(mesh, TetId(t), x) || contains(removed, TetId(t)));
    }
    const double size = std::sqrt(2.0) * 0.2;  // longest edge of this mesh
    for (const TetId t : removed)
      for (const VertexId v : mesh.tet(t)) {
        EXPECT_LT(std::abs(along.dot(mesh.position(v) - centre)), length / 2 + size + 1e-12);
        EXPECT_LT(std::abs(across.dot(mesh.position(v) - centre)), width / 2 + size + 1e-12);
      }
  }
}

// The section of this tet is the triangle (0,0) (0.5,0) (0,0.5) at z = 0.5; a blade across its hypotenuse from outside
// overlaps its bounding box but not the triangle.
TEST(CutPatch, SeparatesByTheSectionsOwnEdges) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets = {{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}};
  mesh.regions = {1};
  const auto cuts = [&](double x, double y, double size) {
    return !cut(mesh, BladePatch{{x, y, 0.5}, {0, 0, 1}, {1, 0, 0}, size, size}).empty();
  };
  EXPECT_TRUE(cuts(0.1, 0.1, 0.01));
  EXPECT_FALSE(cuts(0.4, 0.4, 0.299));  // short of the hypotenuse, but inside the bounding box
  EXPECT_TRUE(cuts(0.4, 0.4, 0.301));
  EXPECT_FALSE(cuts(-0.1, 0.1, 0.2));  // beside it, along an edge
  EXPECT_TRUE(cuts(0.2, 0.2, 100));
}

TEST(CutPatch, TakesLowerTetsUnderItsOwnExtentOnly) {
  const TetMesh mesh = box_mesh(2, 4, 4, {2, 4, 4});
  const Edit edit = cut(mesh, BladePatch{{1, 1, 1}, {1, 0, 0}, {0, 1, 0}, 2, 2});
  EXPECT_EQ(edit.report.under_the_plane, 8u);  // two triangles in each of 2 × 2 cells
  for (const TetId t : edit.removed)
    for (const VertexId v : mesh.tet(t)) {
      EXPECT_LE(mesh.position(v).y(), 2);
      EXPECT_LE(mesh.position(v).z(), 2);
    }
}

TEST(CutPatch, LengthRunsAlongItsDirection) {
  const TetMesh mesh = box_mesh(10, 10, 1, {1, 1, 0.1});
  const auto span = [&](const Vec3& along) {
    Vec3 low(1, 1, 1), high(0, 0, 0);
    for (const TetId t : cut(mesh, BladePatch{{0.5, 0.5, 0.05}, {0, 0, 1}, along, 0.7, 0.05}).removed)
      for (const VertexId v : mesh.tet(t)) {
        low = low.cwiseMin(mesh.position(v));
        high = high.cwiseMax(mesh.position(v));
      }
    return Vec3(high - low);
  };
  EXPECT_GT(span({1, 0, 0}).x(), 0.7);
  EXPECT_LT(span({1, 0, 0}).y(), 0.3);
  EXPECT_GT(span({0, 1, 0.4}).y(), 0.7);  // the part along the normal is dropped
  EXPECT_LT(span({0, 1, 0.4}).x(), 0.3);
}

TEST(CutPatch, RefusesDegenerateOnes) {
  const TetMesh mesh = regular_tet();
  const Vec3 origin = Vec3::Zero(), x(1, 0, 0), z(0, 0, 1);
  for (const BladePatch& patch :
       {BladePatch{origin, z, x, 0, 1}, BladePatch{origin, z, x, 1, -1}, BladePatch{origin, z, x, NAN, 1},
        BladePatch{origin, z, x, 1, INFINITY}, BladePatch{origin, z, z, 1, 1}, BladePatch{origin, z, origin, 1, 1},
        BladePatch{origin, origin, x, 1, 1}, BladePatch{Vec3(NAN, 0, 0), z, x, 1, 1}})
    EXPECT_THROW(cut(mesh, patch), InputError);
}

}  // namespace
}  // namespace calot::test
