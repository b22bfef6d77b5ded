#include "bench/accuracy.h"

#include <algorithm>
#include <limits>

namespace calot::bench {

double worst_column(const Compliance& compliance, const Compliance& reference, const std::vector<DofId>& dofs) {
  const Eigen::MatrixXd c = compliance.columns(dofs), r = reference.columns(dofs);
  double worst = 0;
  for (Eigen::Index j = 0; j < c.cols(); ++j)
    if (const double scale = r.col(j).cwiseAbs().maxCoeff(); scale > 0)
      worst = std::max(worst, (c.col(j) - r.col(j)).cwiseAbs().maxCoeff() / scale);
  return worst;
}

double worst_block(const Eigen::MatrixXd& block, const Compliance& reference, const std::vector<DofId>& dofs) {
  const Eigen::MatrixXd r = reference.columns(dofs);
  double worst = 0;
  for (Eigen::Index j = 0; j < block.cols(); ++j) {
    const double scale = r.col(j).cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < block.rows() && scale > 0; ++i)
      worst = std::max(worst, std::abs(block(i, j) - r(dofs[static_cast<std::size_t>(i)].value, j)) / scale);
  }
  return worst;
}

double error_bound(const Compliance& reference) {
  return std::max(1e-9, 10 * std::numeric_limits<double>::epsilon() * reference.condition());
}

}  // namespace calot::bench
