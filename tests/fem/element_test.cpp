#include "calot/fem/element.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/finite_difference.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

const Material tissue{2.0e5, 0.37, 1060};

TetShape skew_tet() {
  return tet_shape({0, 0, 0}, {0.011, 0.001, 0}, {0.002, 0.013, -0.001}, {0.003, 0.002, 0.009});
}

// The strain energy of a displacement, straight from the definition: V (λ/2 tr(ε)² + μ ε:ε).
double energy(const TetShape& shape, const Lame& l, const Eigen::VectorXd& u) {
  Mat3 gradient = Mat3::Zero();
  for (int a = 0; a < 4; ++a) gradient += u.segment<3>(3 * a) * shape.gradient[static_cast<std::size_t>(a)].transpose();
  const Mat3 strain = 0.5 * (gradient + gradient.transpose());
  return shape.volume * (0.5 * l.lambda * strain.trace() * strain.trace() + l.mu * strain.squaredNorm());
}

TEST(Element, ForceIsTheGradientOfTheStrainEnergy) {
  const TetShape shape = skew_tet();
  const Lame l = lame(tissue);
  test::Random random(7);
  Eigen::VectorXd u(12);
  for (Eigen::Index i = 0; i < 12; ++i) u(i) = random.between(-1e-3, 1e-3);
  const Eigen::VectorXd force = stiffness(shape, l) * u;
  EXPECT_LT(test::gradient_error([&](const Eigen::VectorXd& x) { return energy(shape, l, x); }, force, u, 1e-4), 1e-10);
}

TEST(Element, RigidMotionsCostNothingAndAllElseDoes) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness(skew_tet(), lame(tissue)));
  const double largest = solver.eigenvalues()(11);
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(solver.eigenvalues()(i)), 1e-13 * largest);
  EXPECT_GT(solver.eigenvalues()(6), 1e-4 * largest);
}

// On the unit right tet everything is known: gradients are −1,−1,−1 and the axes, volume 1/6.
TEST(Element, UnitTetInClosedForm) {
  const TetShape shape = tet_shape({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  EXPECT_DOUBLE_EQ(shape.volume, 1.0 / 6);
  EXPECT_EQ(shape.gradient[0], Vec3(-1, -1, -1));
  EXPECT_EQ(shape.gradient[2], Vec3(0, 1, 0));
  const Lame l{3, 2};
  const Mat3 own = stiffness_block(shape, l, 1, 1);  // V (λ + 2μ, μ, μ)
  EXPECT_NEAR(own(0, 0), 7.0 / 6, 1e-15);
  EXPECT_NEAR(own(1, 1), 2.0 / 6, 1e-15);
  EXPECT_NEAR(own(0, 1), 0, 1e-15);
  const Mat3 cross = stiffness_block(shape, l, 1, 2);  // λ e1 e2ᵀ + μ e2 e1ᵀ
  EXPECT_NEAR(cross(0, 1), 3.0 / 6, 1e-15);
  EXPECT_NEAR(cross(1, 0), 2.0 / 6, 1e-15);
}

TEST(Element, TurnedTetHasTheTurnedStiffness) {
  const Mat3 r = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const std::array<Vec3, 4> x{Vec3(0, 0, 0), Vec3(0.011, 0.001, 0), Vec3(0.002, 0.013, -0.001),
                              Vec3(0.003, 0.002, 0.009)};
  const auto k = stiffness(tet_shape(x[0], x[1], x[2], x[3]), lame(tissue));
  const auto turned = stiffness(tet_shape(r * x[0], r * x[1], r * x[2], r * x[3]), lame(tissue));
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const Mat3 expected = r * k.block<3, 3>(3 * a, 3 * b) * r.transpose();
      EXPECT_LT((turned.block<3, 3>(3 * a, 3 * b) - expected).norm(), 1e-12 * k.norm());
    }
}

TEST(Element, LameParametersOfKnownMaterials) {
  const Lame l = lame({1.0e6, 0.25, 1});  // ν = 1/4: λ = μ = 0.4 E
  EXPECT_NEAR(l.lambda, 4.0e5, 1e-6);
  EXPECT_NEAR(l.mu, 4.0e5, 1e-6);
  EXPECT_EQ(lame({1.0e6, 0, 1}).lambda, 0);
}

}  // namespace
}  // namespace calot
