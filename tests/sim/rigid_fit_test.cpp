// The rigid motion nearest to a deformation.
#include "calot/sim/rigid_fit.h"

#include <gtest/gtest.h>

#include "tests/support/edits.h"

namespace calot {
namespace {

std::vector<Vec3> cloud(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3> points(12);
  for (Vec3& p : points) p = Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  return points;
}

double misfit(const Pose& pose, const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  double sum = 0;
  for (std::size_t k = 0; k < from.size(); ++k) sum += (pose * from[k] - to[k]).squaredNorm();
  return sum;
}

TEST(RigidFit, FindsAMotionAgain) {
  const std::vector<Vec3> from = cloud(1);
  const Pose motion{Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Vec3(1, 2, -1).normalized())), Vec3(3, -1, 0.5)};
  std::vector<Vec3> to;
  for (const Vec3& p : from) to.push_back(motion * p);
  EXPECT_LT(misfit(fit_rigid(from, to), from, to), 1e-24);
}

TEST(RigidFit, IsTheBestOfItsNeighboursAndNeverMirrors) {
  const std::vector<Vec3> from = cloud(2);
  std::vector<Vec3> to = cloud(3);
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = 0.2 * to[k] + Vec3(from[k].x(), from[k].y(), -from[k].z());
  const Pose best = fit_rigid(from, to);
  EXPECT_NEAR(best.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  const double least = misfit(best, from, to);
  for (int axis = 0; axis < 3; ++axis)
    for (const double by : {-1e-3, 1e-3}) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(by, Vec3::Unit(axis)));
      EXPECT_GT(misfit({turn * best.rotation, best.position}, from, to), least);
      EXPECT_GT(misfit({best.rotation, best.position + by * Vec3::Unit(axis)}, from, to), least);
    }
}

TEST(RigidFit, OnePointIsTakenToItsPlace) {
  const std::vector<Vec3> from{Vec3(1, 2, 3)}, to{Vec3(-1, 0, 5)};
  EXPECT_LT((fit_rigid(from, to) * from[0] - to[0]).norm(), 1e-12);
}

}  // namespace
}  // namespace calot
