#include "calot/sim/rigid_fit.h"

#include <Eigen/SVD>

namespace calot {

Pose fit_rigid(std::span<const Vec3> from, std::span<const Vec3> to) {
  const auto mean = [](std::span<const Vec3> points) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points) sum += p;
    return Vec3(sum / static_cast<double>(points.size()));
  };
  const Vec3 before = mean(from), after = mean(to);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < from.size(); ++k) sum += (to[k] - after) * (from[k] - before).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Quaterniond turn(Eigen::Matrix3d(svd.matrixU() * flip * svd.matrixV().transpose()));
  return {turn, after - turn * before};
}

}  // namespace calot
