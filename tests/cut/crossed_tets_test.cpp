#include "calot/cut/crossed_tets.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace calot {
namespace {

Sweep square(double x, double low, double high) {
  const Vec3 a(x, low, low), b(x, high, low), c(x, high, high), d(x, low, high);
  return {{{a, b, c}, {a, c, d}}};
}

TEST(CrossedTets, AreThoseThatACutWithThePlaneRemoves) {
  const TetMesh mesh = test::box_mesh(5, 4, 4, Vec3(0.05, 0.04, 0.04));
  const Edit removed = cut(mesh, Plane{Vec3(0.023, 0, 0), Vec3::UnitX()});
  EXPECT_EQ(crossed_tets(mesh, mesh.positions, square(0.023, -0.1, 0.1)), removed.removed);
}

TEST(CrossedTets, StayWithinThePatch) {
  const TetMesh mesh = test::box_mesh(5, 4, 4, Vec3(0.05, 0.04, 0.04));
  const std::vector<TetId> all = crossed_tets(mesh, mesh.positions, square(0.023, -0.1, 0.1)),
                           some = crossed_tets(mesh, mesh.positions, square(0.023, -0.1, 0.018));
  EXPECT_GT(some.size(), 0u);
  EXPECT_LT(some.size(), all.size());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
  EXPECT_TRUE(crossed_tets(mesh, mesh.positions, square(0.2, -0.1, 0.1)).empty());
  EXPECT_TRUE(crossed_tets(mesh, mesh.positions, {}).empty());
}

}  // namespace
}  // namespace calot
