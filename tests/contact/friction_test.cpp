#include "calot/contact/friction.h"

#include <gtest/gtest.h>

#include <numbers>

#include "oracle/siconos_solver.h"
#include "tests/contact/friction_problems.h"
#include "tests/support/files.h"

namespace calot {
namespace {

using namespace test;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The conditions themselves, written down anew: largest violation as a share of the largest free motion.
double broken(const FrictionProblem& p, const VectorXd& forces) {
  const VectorXd u = p.delassus * forces + p.free_motion;
  const double motion = p.free_motion.cwiseAbs().maxCoeff(), size = p.delassus.trace() / double(forces.size());
  double worst = 0;
  for (Eigen::Index i = 0; i < forces.size() / 3; ++i) {
    const double mu = p.friction[i], fn = forces(3 * i), un = u(3 * i);
    const Eigen::Vector2d ft = forces.segment<2>(3 * i + 1), ut = u.segment<2>(3 * i + 1);
    worst = std::max({worst, -fn * size, -un, std::min(fn * size, un), (ft.norm() - mu * fn) * size});
    // Either it sticks, or friction is of full size and opposes the motion.
    const double slack = std::max(0.0, mu * fn - ft.norm()) * size;
    worst = std::max(worst, std::min(slack, ut.norm()));
    if (ut.norm() > 1e-5 * motion && fn * size > 1e-5 * motion)
      worst = std::max(worst, size * (ft + mu * fn * ut.normalized()).norm() * std::min(1.0, ut.norm() / motion));
  }
  return worst / motion;
}

TEST(OneContact, FulfilsTheConditionsExactly) {
  Random random(5);
  int sliding = 0, stuck = 0;
  for (int n = 0; n < 20000; ++n) {
    const double friction = n % 10 * 0.15;
    const FrictionProblem problem = random_problem(random, 1, 3 + n % 2, friction);
    const Vector3d force =
        solve_one_contact(problem.delassus + 1e-9 * Matrix3d::Identity(), problem.free_motion, friction);
    FrictionProblem exact = problem;
    exact.delassus += 1e-9 * Matrix3d::Identity();
    EXPECT_LT(friction_residual(exact, force), 1e-8) << n;
    if (force(0) > 0) ++(force.tail<2>().norm() < friction * force(0) * (1 - 1e-9) ? stuck : sliding);
  }
  EXPECT_GT(sliding, 1000);
  EXPECT_GT(stuck, 300);
}

TEST(OneContact, SlidesAsTheClosedFormSaysWhenDirectionsDontMix) {
  // Equal compliance w everywhere: the force that stops the tangential motion, cut to the cone.
  const double w = 2e-3;
  const Vector3d q(-1e-3, 3e-3, 4e-3);
  const Vector3d force = solve_one_contact(w * Matrix3d::Identity(), q, 0.3);
  EXPECT_NEAR(force(0), 0.5, 1e-12);
  EXPECT_NEAR(force(1), -0.3 * 0.5 * 0.6, 1e-12);
  EXPECT_NEAR(force(2), -0.3 * 0.5 * 0.8, 1e-12);
}

TEST(Friction, ABlockOnASlopeSticksBelowItsAngleAndSlidesAbove) {
  // A rigid block of 1 kg on four feet; W of six degrees of freedom is singular for twelve rows.
  const double h = 1.0 / 60, mass = 1, side = 0.1;
  const Matrix3d turn = Matrix3d::Identity() * (6 / (mass * side * side));
  for (const double mu : {0.1, 0.3, 0.7}) {
    for (const double off : {-0.01, 0.01}) {
      const double angle = std::atan(mu) + off;
      Eigen::Matrix<double, 12, 6> j;
      for (int c = 0; c < 4; ++c) {
        const Vector3d arm(-side / 2, (c & 1 ? 1 : -1) * side / 2, (c & 2 ? 1 : -1) * side / 2);
        for (int a = 0; a < 3; ++a) {
          j.block<1, 3>(3 * c + a, 0) = Vector3d::Unit(a).transpose();
          j.block<1, 3>(3 * c + a, 3) = arm.cross(Vector3d::Unit(a)).transpose();
        }
      }
      Eigen::Matrix<double, 6, 6> inverse = Eigen::Matrix<double, 6, 6>::Identity() / mass;
      inverse.bottomRightCorner<3, 3>() = turn;
      Eigen::Matrix<double, 6, 1> fall = Eigen::Matrix<double, 6, 1>::Zero();
      fall(0) = -9.81 * std::cos(angle) * h * h;
      fall(1) = 9.81 * std::sin(angle) * h * h;
      FrictionProblem problem;
      problem.delassus = h * h * j * inverse * j.transpose();
      problem.free_motion = j * fall;
      problem.friction.assign(4, mu);
      const FrictionSolution s = solve_friction(problem, {}, {1e-9, 500});
      ASSERT_TRUE(s.converged) << s.residual;
      const VectorXd u = problem.delassus * s.forces + problem.free_motion;
      double normal = 0;
      for (int c = 0; c < 4; ++c) normal += s.forces(3 * c);
      EXPECT_NEAR(normal, mass * 9.81 * std::cos(angle), 1e-6);
      const double slide = off < 0 ? 0 : 9.81 * h * h * (std::sin(angle) - mu * std::cos(angle));
      for (int c = 0; c < 4; ++c) EXPECT_NEAR(u(3 * c + 1), slide, 1e-9) << mu << " " << off;
    }
  }
}

/// Ours and Siconos's give the same motion; the same forces where W says so.
void compare(const FrictionProblem& problem, bool unique, const std::string& what) {
  const FrictionSolution ours = solve_friction(problem, {}, {1e-9, 4000});
  EXPECT_TRUE(ours.converged) << what << " residual " << ours.residual;
  EXPECT_LT(broken(problem, ours.forces), 1e-6) << what;
  const auto theirs = oracle::solve_with_siconos(problem, {}, oracle::SiconosMethod::gauss_seidel, 1e-10, 100000);
  ASSERT_EQ(theirs.status, 0) << what << " error " << theirs.error;
  ASSERT_LT(friction_residual(problem, theirs.forces), 1e-7) << what;  // our judge agrees with theirs
  const double motion = problem.free_motion.cwiseAbs().maxCoeff();
  EXPECT_LT((problem.delassus * (ours.forces - theirs.forces)).cwiseAbs().maxCoeff(), 1e-5 * motion) << what;
  if (!unique) return;
  EXPECT_LE((ours.forces - theirs.forces).cwiseAbs().maxCoeff(), 1e-5 * theirs.forces.cwiseAbs().maxCoeff()) << what;
}

TEST(Friction, AgreesWithSiconosOnRandomProblems) {
  Random random(11);
  for (const double mu : {0.0, 0.1, 0.3})
    for (const int contacts : {2, 5, 20})
      for (int n = 0; n < 6; ++n)
        compare(random_problem(random, contacts, 6 * contacts, mu), true,
                std::to_string(contacts) + " contacts, friction " + std::to_string(mu));
}

TEST(Friction, AgreesWithSiconosOnTissue) {
  const TissuePatch patch;
  Random random(3);
  for (const double mu : {0.0, 0.1, 0.3, 0.6, 1.0})
    for (const double reach : {0.008, 0.02})
      for (int n = 0; n < 3; ++n)
        compare(patch.problem(random, 20, reach, mu), false,
                "reach " + std::to_string(reach) + ", friction " + std::to_string(mu));
}

TEST(Friction, AgreesWithSiconosWhereContactsAreRedundant) {
  const TissuePatch patch;
  Random random(8);
  for (int n = 0; n < 5; ++n) {
    const FrictionProblem once = patch.problem(random, 8, 0.012, 0.3);
    FrictionProblem twice;
    twice.delassus.resize(48, 48);
    twice.delassus << once.delassus, once.delassus, once.delassus, once.delassus;
    twice.free_motion.resize(48);
    twice.free_motion << once.free_motion, once.free_motion;
    twice.friction.assign(16, 0.3);
    compare(twice, false, "doubled " + std::to_string(n));
    const VectorXd u1 = once.delassus * solve_friction(once, {}, {1e-10, 4000}).forces;
    const VectorXd u2 = twice.delassus * solve_friction(twice, {}, {1e-10, 4000}).forces;
    EXPECT_LT((u2.head(24) - u1).cwiseAbs().maxCoeff(), 1e-8 * once.free_motion.cwiseAbs().maxCoeff() + 1e-10);
  }
}

TEST(Friction, WarmStartNeedsNothingWhereItIsAlreadyRight) {
  const TissuePatch patch;
  Random random(4);
  const FrictionProblem problem = patch.problem(random, 20, 0.015, 0.3);
  const FrictionSolution cold = solve_friction(problem, {}, {1e-8, 2000});
  ASSERT_TRUE(cold.converged);
  const std::span<const double> start(cold.forces.data(), static_cast<std::size_t>(cold.forces.size()));
  const FrictionSolution warm = solve_friction(problem, start, {1e-8, 2000});
  EXPECT_EQ(warm.iterations, 0);
  EXPECT_EQ(warm.forces, cold.forces);
}

TEST(Friction, TheResidualIsNeverHidden) {
  const TissuePatch patch;
  Random random(9);
  const FrictionProblem problem = patch.problem(random, 20, 0.01, 0.5);
  const FrictionSolution stopped = solve_friction(problem, {}, {1e-12, 2});
  EXPECT_FALSE(stopped.converged);
  EXPECT_GT(stopped.residual, 1e-12);
  EXPECT_EQ(stopped.residual, friction_residual(problem, stopped.forces));
  VectorXd outside = stopped.forces;
  outside(1) += 10 * std::abs(outside.maxCoeff());  // out of its cone
  EXPECT_GT(friction_residual(problem, outside), 0.01);
}

TEST(Friction, OpenImmovableAndBrokenProblems) {
  FrictionProblem problem;
  problem.delassus = 1e-3 * Eigen::MatrixXd::Identity(6, 6);
  problem.free_motion = VectorXd::Constant(6, 1e-3);
  problem.friction = {0.3, 0.3};
  const FrictionSolution open = solve_friction(problem, {}, {});
  EXPECT_TRUE(open.converged);
  EXPECT_TRUE(open.forces.isZero(0));
  problem.free_motion << -1e-3, 0, 0, -1e-3, 0, 0;
  problem.delassus.bottomRightCorner<3, 3>().setZero();
  const FrictionSolution half = solve_friction(problem, {}, {});
  EXPECT_TRUE(half.converged);
  EXPECT_EQ(half.immovable, 1u);
  EXPECT_NEAR(half.forces(0), 1, 1e-12);
  EXPECT_EQ(half.forces(3), 0);
  problem.free_motion(0) = std::nan("");
  const FrictionSolution broken_values = solve_friction(problem, {}, {});
  EXPECT_FALSE(broken_values.converged);
  EXPECT_TRUE(broken_values.forces.isZero(0));
  problem.friction = {0.3};
  EXPECT_NE(message_of([&] { solve_friction(problem, {}, {}); }), "");
  problem.friction = {0.3, -0.1};
  EXPECT_NE(message_of([&] { solve_friction(problem, {}, {}); }), "");
  EXPECT_TRUE(solve_friction({}, {}, {}).converged);
}

}  // namespace
}  // namespace calot
