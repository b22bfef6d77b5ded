// One finite-difference check for every force and every stiffness.
#pragma once
#include <Eigen/Core>
#include <functional>

namespace calot::test {

/// Largest difference between `gradient` and the fourth-order central difference of `energy` at x, relative to the
/// largest component; `step` is relative to the scale of x.
inline double gradient_error(const std::function<double(const Eigen::VectorXd&)>& energy,
                             const Eigen::VectorXd& gradient, const Eigen::VectorXd& x, double step) {
  double worst = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const auto at = [&](double offset) {
      Eigen::VectorXd moved = x;
      moved(i) += offset;
      return energy(moved);
    };
    const double slope = (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
    worst = std::max(worst, std::abs(slope - gradient(i)));
  }
  return worst / std::max(gradient.cwiseAbs().maxCoeff(), 1e-300);
}

}  // namespace calot::test
