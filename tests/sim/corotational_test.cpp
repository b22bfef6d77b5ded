#include "calot/sim/corotational.h"

#include <gtest/gtest.h>

#include "tests/support/models.h"

namespace calot {
namespace {

using test::Random;

Vec3 random_vector(Random& random, double size) {
  return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}

std::vector<Vec3> shaken(const std::vector<Vec3>& positions, double size, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> result = positions;
  for (Vec3& x : result) x += random_vector(random, size);
  return result;
}

double largest(const std::vector<Vec3>& values) {
  double size = 0;
  for (const Vec3& v : values) size = std::max(size, v.norm());
  return size;
}

TEST(Corotational, IsTheModelsStiffnessAtRest) {
  const Model model = test::biliary_model(0.01);
  const BlockMatrix k = model.stiffness();
  const Corotational tissue(model);
  const std::vector<Vec3> d = shaken(std::vector<Vec3>(model.mesh().vertex_count(), Vec3::Zero()), 1e-3, 1);
  std::vector<Vec3> y(d.size()), expected(d.size());
  tissue.multiply(d, y);
  k.multiply({d.data()->data(), 3 * d.size()}, {expected.data()->data(), 3 * d.size()});
  for (std::size_t v = 0; v < d.size(); ++v) EXPECT_LT((y[v] - expected[v]).norm(), 1e-12 * largest(expected));
}

TEST(Corotational, RigidMotionGivesNoForceAtAnyAngle) {
  const Model model = test::biliary_model(0.01);
  Corotational tissue(model);
  std::vector<Vec3> f(model.mesh().vertex_count());
  for (int degrees = 0; degrees <= 360; degrees += 45) {
    const Eigen::AngleAxisd turn(degrees * M_PI / 180, Vec3(1, 2, -1).normalized());
    std::vector<Vec3> x = model.mesh().positions;
    for (Vec3& p : x) p = turn * p + Vec3(0.1, -0.2, 0.05);
    // 45 degrees in one step is more than a step of tissue ever turns.
    EXPECT_LT(tissue.update_rotations(x), 1e-6) << degrees;
    tissue.force(x, f);
    EXPECT_LT(largest(f), 1e-7) << degrees;  // stiffness 1e6 Pa over millimetres: a strain of 1e-10
  }
}

TEST(Corotational, RotationsAreThoseOfThePolarDecomposition) {
  const Model model =
      test::make_model(test::box_mesh(3, 3, 3, Vec3(0.03, 0.03, 0.03)), 0.01, [](const Vec3&) { return false; });
  Corotational tissue(model);
  const std::vector<Vec3> x = shaken(model.mesh().positions, 2e-3, 7);
  for (int k = 0; k < 3; ++k) tissue.update_rotations(x);
  for (std::size_t t = 0; t < model.mesh().tet_count(); ++t) {
    const Tet& tet = model.mesh().tets[t];
    Mat3 rest, now;
    for (int a = 0; a < 3; ++a) {
      const std::size_t v = tet[static_cast<std::size_t>(a + 1)].index();
      rest.col(a) = model.mesh().positions[v] - model.mesh().position(tet[0]);
      now.col(a) = x[v] - x[tet[0].index()];
    }
    const Mat3 f = now * rest.inverse();
    const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 polar = svd.matrixU() * svd.matrixV().transpose();
    ASSERT_GT(f.determinant(), 0);
    EXPECT_LT((tissue.rotation(TetId(t)).toRotationMatrix() - polar).norm(), 1e-9) << t;
  }
}

// With the rotation of every tet at its optimum, the derivative of the energy is the force with rotations held.
TEST(Corotational, ForceIsTheDerivativeOfTheEnergy) {
  const Model model =
      test::make_model(test::box_mesh(2, 2, 2, Vec3(0.02, 0.02, 0.02)), 0.01, [](const Vec3&) { return false; });
  Corotational tissue(model);
  const std::vector<Vec3> x = shaken(model.mesh().positions, 1.5e-3, 3);
  for (int k = 0; k < 3; ++k) tissue.update_rotations(x);
  std::vector<Vec3> f(x.size());
  tissue.force(x, f);
  const double step = 1e-7;
  for (std::size_t v = 0; v < x.size(); v += 3)
    for (int axis = 0; axis < 3; ++axis) {
      double energy[2];
      for (int side = 0; side < 2; ++side) {
        std::vector<Vec3> moved = x;
        moved[v][axis] += side == 0 ? -step : step;
        Corotational turned = tissue;
        turned.update_rotations(moved);
        energy[side] = turned.energy(moved);
      }
      EXPECT_NEAR(f[v][axis], -(energy[1] - energy[0]) / (2 * step), 1e-5 * largest(f));
    }
}

TEST(Corotational, ForcesBalanceForceAndMoment) {
  const Model model = test::biliary_model(0.01);
  Corotational tissue(model);
  const std::vector<Vec3> x = shaken(model.mesh().positions, 5e-4, 9);
  for (int k = 0; k < 3; ++k) tissue.update_rotations(x);
  std::vector<Vec3> f(x.size());
  tissue.force(x, f);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t v = 0; v < x.size(); ++v) {
    force += f[v];
    moment += x[v].cross(f[v]);
  }
  EXPECT_LT(force.norm(), 1e-10 * largest(f));
  EXPECT_LT(moment.norm(), 1e-9 * largest(f) * 0.1);
}

TEST(Corotational, RemovalKeepsTheOthersRotations) {
  Model model = test::biliary_model(0.01);
  Corotational tissue(model);
  const std::vector<Vec3> x = shaken(model.mesh().positions, 5e-4, 11);
  tissue.update_rotations(x);
  const std::vector<Eigen::Quaterniond> before = tissue.rotations();
  const StiffnessChange change = model.apply({test::random_tets(model.mesh(), 40, 5), {}, {}, {}});
  tissue.follow(model, change.remap);
  ASSERT_EQ(tissue.tet_count(), model.mesh().tet_count());
  for (std::size_t t = 0; t < tissue.tet_count(); ++t)
    EXPECT_TRUE(tissue.rotation(TetId(t)).coeffs() == before[change.remap.tet_to_old[t].index()].coeffs());
}

}  // namespace
}  // namespace calot
