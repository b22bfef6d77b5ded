// How far a compliance can be trusted: the drift probe and the condition number.
#include <cmath>

#include "calot/compliance/compliance.h"
#include "calot/compliance/compliance_impl.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// A fixed sequence (Steele et al. 2014, SplitMix64), so that results don't hang on the standard library.
double random_in_one(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-52 - 1;
}

MatrixXd on_free_slots(const Compliance::Impl& impl, const std::function<double()>& value) {
  MatrixXd x = MatrixXd::Zero(static_cast<Index>(3 * impl.slots()), 1);
  for (std::size_t s = 0; s < impl.slots(); ++s)
    if (impl.row_of_slot[s] >= 0 && !impl.dead[s])
      for (Index a = 0; a < 3; ++a) x(static_cast<Index>(3 * s) + a, 0) = value();
  return x;
}

double absolute_sum(const MatrixXd& x) {
  return x.cwiseAbs().sum();
}

// The norm of the free rows and columns only: fixed ones are not part of the system.
double norm1_of_free(const Compliance::Impl& impl) {
  double largest = 0;
  for (std::size_t s = 0; s < impl.slots(); ++s) {
    if (impl.row_of_slot[s] < 0 || impl.dead[s]) continue;
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t k = impl.stiffness.row_start[s]; k < impl.stiffness.row_start[s + 1]; ++k)
      if (impl.row_of_slot[impl.stiffness.column[k]] >= 0) sum += impl.stiffness.block[k].cwiseAbs().rowwise().sum();
    largest = std::max(largest, sum.maxCoeff());
  }
  return largest;
}

}  // namespace

double Compliance::probe(std::uint64_t seed) const {
  std::uint64_t state = seed;
  const MatrixXd z = on_free_slots(*impl_, [&] { return random_in_one(state); });
  const MatrixXd x = impl_->apply(z, 0);
  MatrixXd residual(z.rows(), 1);
  impl_->stiffness.multiply({x.data(), static_cast<std::size_t>(x.size())},
                            {residual.data(), static_cast<std::size_t>(residual.size())});
  double sum = 0;
  for (std::size_t s = 0; s < impl_->slots(); ++s)
    if (impl_->row_of_slot[s] >= 0 && !impl_->dead[s])
      sum += (residual.block<3, 1>(static_cast<Index>(3 * s), 0) - z.block<3, 1>(static_cast<Index>(3 * s), 0))
                 .squaredNorm();
  return z.size() ? std::sqrt(sum) / std::max(z.norm(), 1e-300) : 0;
}

double Compliance::condition() const {
  // Hager's estimate of ‖C‖₁ (Higham 1988, algorithm 4.1); C is symmetric, so one operator serves both ways.
  const std::size_t free = 3 * impl_->slot_of_row.size();
  if (free == 0) return 1;
  MatrixXd x = on_free_slots(*impl_, [&] { return 1.0 / static_cast<double>(free); });
  double estimate = 0;
  for (int step = 0; step < 6; ++step) {
    const MatrixXd y = impl_->apply(x, 1);
    const double sum = absolute_sum(y);
    if (step > 0 && sum <= estimate) break;
    estimate = sum;
    std::size_t k = 0;
    const MatrixXd signs = on_free_slots(*impl_, [] {
                             return 1.0;
                           }).cwiseProduct(y.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; }));
    Index largest = 0;
    impl_->apply(signs, 1).col(0).cwiseAbs().maxCoeff(&largest);
    k = static_cast<std::size_t>(largest);
    x.setZero();
    x(static_cast<Index>(k), 0) = 1;
  }
  return norm1_of_free(*impl_) * estimate;
}

}  // namespace calot
