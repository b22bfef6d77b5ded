// Better angles without harm: volumes, boundaries, regions and soundness stay.
#include "calot/mesh/improve.h"

#include <gtest/gtest.h>

#include <set>

#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

/// A block of two regions whose inner vertices, and those on the boundary between the regions, were shaken.
TetMesh shaken_block(std::uint64_t seed, double by) {
  constexpr int cells = 6;
  TetMesh mesh =
      test::cell_mesh(cells, cells, cells, Vec3::Constant(0.06), [](int i, int, int) { return i < cells / 2 ? 1 : 2; });
  test::Random random(seed);
  for (Vec3& p : mesh.positions) {
    const bool outside = (p.array() < 1e-9).any() || (p.array() > 0.06 - 1e-9).any();
    const bool between = std::abs(p[0] - 0.03) < 1e-9;
    const Vec3 shake(random.between(-by, by), random.between(-by, by), random.between(-by, by));
    if (!outside) p += between ? Vec3(0, shake[1], shake[2]) : shake;
  }
  return mesh;
}

/// The triangles between two regions, and outside, as sets of places.
std::set<std::array<std::array<double, 3>, 3>> boundary_faces(const TetMesh& mesh, std::int32_t region) {
  std::set<std::array<std::array<double, 3>, 3>> faces;
  const Surface surface = region_surface(mesh, region);
  for (const Triangle& t : surface.triangles) {
    std::array<std::array<double, 3>, 3> face{};
    for (std::size_t c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d) face[c][static_cast<std::size_t>(d)] = surface.positions[t[c]][d];
    std::sort(face.begin(), face.end());
    faces.insert(face);
  }
  return faces;
}

class Improve : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Improve, testing::Range(1, 7));

TEST_P(Improve, MendsAShakenBlock) {
  TetMesh mesh = shaken_block(static_cast<std::uint64_t>(GetParam()), 0.0031);
  const Quality before = quality(mesh);
  ASSERT_FALSE(validate(mesh).fatal());
  ASSERT_LT(before.min_dihedral, 14);
  const Improvement done = improve(mesh, {.min_dihedral = 18, .max_dihedral = 150});
  const Quality after = quality(mesh);
  EXPECT_TRUE(validate(mesh).describe().empty()) << validate(mesh).describe();
  EXPECT_GT(done.bad_before, 10u);
  EXPECT_EQ(done.bad_after, 0u);
  EXPECT_GE(after.min_dihedral, 18 - 1e-9);
  EXPECT_LE(after.max_dihedral, 150 + 1e-9);
  EXPECT_TRUE(check_manifold(boundary_surface(mesh)).closed_manifold());
  for (const int region : {1, 2}) {
    EXPECT_NEAR(quality(mesh, region).volume, before.volume / 2, 0.01 * before.volume) << region;
    EXPECT_TRUE(check_manifold(region_surface(mesh, region)).closed_manifold()) << region;
  }
  EXPECT_EQ(face_connected_parts(mesh).count(), 1u);
}

TEST_P(Improve, LeavesBoundariesInPlaceWhereTheyMayNotMove) {
  TetMesh mesh = shaken_block(static_cast<std::uint64_t>(GetParam()), 0.0031);
  const auto faces = boundary_faces(mesh, 1);
  const Quality before = quality(mesh);
  const Improvement done = improve(mesh, {.min_dihedral = 15, .max_dihedral = 155, .along = 0, .across = 0});
  EXPECT_EQ(boundary_faces(mesh, 1), faces);
  EXPECT_LT(done.bad_after, done.bad_before);
  EXPECT_NEAR(quality(mesh).volume, before.volume, 1e-12 * before.volume);
}

TEST(Improve, NeverMakesTheWorstAngleWorse) {
  int tried = 0;
  for (std::uint64_t seed = 11; seed < 31; ++seed) {
    TetMesh mesh = shaken_block(seed, 0.0033);
    if (validate(mesh).fatal()) continue;  // shaken until a tet turned over
    ++tried;
    const Quality before = quality(mesh);
    improve(mesh, {.min_dihedral = 25, .max_dihedral = 140, .passes = 2});
    EXPECT_GE(quality(mesh).min_dihedral, std::min(25.0, before.min_dihedral));
    EXPECT_LE(quality(mesh).max_dihedral, std::max(140.0, before.max_dihedral));
  }
  EXPECT_GE(tried, 5);
}

TEST(Improve, LeavesAGoodMeshAlone) {
  const TetMesh before = test::box_mesh(3, 3, 3, Vec3::Ones());
  TetMesh mesh = before;
  const Improvement done = improve(mesh, {});
  EXPECT_EQ(done.moves + done.flips + done.collapses, 0u);
  EXPECT_EQ(mesh.positions, before.positions);
  EXPECT_EQ(mesh.tets, before.tets);
}

/// Four points nearly in a plane, crosswise: moving them can't help where all are held, only another set of tets can.
TEST(Improve, RemovesASliverByFlipping) {
  TetMesh mesh;
  mesh.positions = {{1, 0, 0.01}, {-1, 0, 0.01}, {0, 1, -0.01}, {0, -1, -0.01}, {0, 0, 1}, {0, 0, -1}};
  const auto add = [&](int a, int b, int c, int d) {
    Tet tet{VertexId(a), VertexId(b), VertexId(c), VertexId(d)};
    if (signed_volume(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])) < 0)
      std::swap(tet[0], tet[1]);
    mesh.tets.push_back(tet);
    mesh.regions.push_back(1);
  };
  add(0, 1, 2, 3);  // the sliver
  add(0, 1, 2, 4);
  add(0, 1, 3, 4);
  add(2, 3, 0, 5);
  add(2, 3, 1, 5);
  ASSERT_FALSE(validate(mesh).fatal()) << validate(mesh).describe();
  const double volume = quality(mesh).volume;
  ASSERT_LT(quality(mesh).min_dihedral, 3);
  const Improvement done = improve(mesh, {.min_dihedral = 20, .max_dihedral = 150, .along = 0, .across = 0});
  EXPECT_GE(done.flips, 1u);
  EXPECT_GE(quality(mesh).min_dihedral, 20);
  EXPECT_NEAR(quality(mesh).volume, volume, 1e-12);
  EXPECT_TRUE(validate(mesh).describe().empty());
}

TEST(Improve, GivesTheSameBytes) {
  TetMesh a = shaken_block(3, 0.0031), b = shaken_block(3, 0.0031);
  improve(a, {});
  improve(b, {});
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.tets, b.tets);
}

}  // namespace
}  // namespace calot
