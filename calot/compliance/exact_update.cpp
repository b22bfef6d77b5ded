#include "calot/compliance/exact_update.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calot/compliance/blas.h"

namespace calot {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

std::size_t count(Index n) {
  return static_cast<std::size_t>(n);
}

// B with B Bᵀ = A, A positive semidefinite: pivoted Cholesky, k×r. Modes below 1e-15 of the largest are rounding.
MatrixXd root_of(MatrixXd a) {
  const Index k = a.rows();
  if (k == 0) return MatrixXd(0, 0);
  std::vector<int> pivot(count(k));
  const double tolerance = 1e-15 * a.diagonal().maxCoeff();
  const auto rank = static_cast<Index>(blas::pstrf(count(k), a.data(), count(k), pivot.data(), tolerance));
  MatrixXd b = MatrixXd::Zero(k, rank);
  for (Index j = 0; j < rank; ++j)
    for (Index i = j; i < k; ++i) b(pivot[count(i)], j) = a(i, j);
  return b;
}

// The smallest eigenvalue of L Lᵀ, by inverse iteration; L lower triangular.
double smallest_eigenvalue(const MatrixXd& l) {
  const Index n = l.rows();
  if (n == 0) return 1;
  MatrixXd x = MatrixXd::Constant(n, 1, 1 / std::sqrt(static_cast<double>(n)));
  for (Index i = 1; i < n; i += 2) x(i, 0) = -x(i, 0);  // not orthogonal to a smooth mode nor to an alternating one
  x(0, 0) += 0.5;
  double inverse = 1;
  for (int step = 0; step < 6; ++step) {
    x /= x.norm();
    blas::trsm('L', 'N', count(n), 1, 1, l.data(), count(n), x.data(), count(n));
    inverse = x.squaredNorm();
    blas::trsm('L', 'T', count(n), 1, 1, l.data(), count(n), x.data(), count(n));
  }
  return std::min(1.0, 1 / inverse);
}

void product(char op_a, char op_b, double alpha, const MatrixXd& a, const MatrixXd& b, double beta, MatrixXd& c) {
  const Index inner = op_a == 'N' ? a.cols() : a.rows();
  if (c.size() == 0) return;
  blas::gemm(op_a, op_b, count(c.rows()), count(c.cols()), count(inner), alpha, a.data(),
             count(std::max<Index>(1, a.rows())), b.data(), count(std::max<Index>(1, b.rows())), beta, c.data(),
             count(c.rows()));
}

}  // namespace

UpdateFactors exact_update(const MatrixXd& block, Index struck, const MatrixXd& removed) {
  blas::use_one_thread();
  const Index q = block.rows(), d = struck, k = q - d;
  UpdateFactors factors;
  // D: chol(C_DD)⁻ᵀ, and C_SS and C_DS after striking.
  MatrixXd ld = block.topLeftCorner(d, d);
  if (blas::potrf(count(d), ld.data(), count(std::max<Index>(1, d))) != 0) {
    factors.smallest_eigenvalue = 0;
    return factors;
  }
  factors.minus = MatrixXd::Zero(q, d);
  MatrixXd inverse_transposed = MatrixXd::Identity(d, d);
  blas::trsm('L', 'T', count(d), count(d), 1, ld.data(), count(std::max<Index>(1, d)), inverse_transposed.data(),
             count(std::max<Index>(1, d)));
  factors.minus.topRows(d) = inverse_transposed;
  MatrixXd half = block.topRightCorner(d, k);  // L_D⁻¹ C_DS
  blas::trsm('L', 'N', count(d), count(k), 1, ld.data(), count(std::max<Index>(1, d)), half.data(),
             count(std::max<Index>(1, d)));
  MatrixXd css = block.bottomRightCorner(k, k);
  product('T', 'N', -1, half, half, 1, css);
  // S: I − Bᵀ C_SS B = L Lᵀ.
  const MatrixXd b = root_of(removed);
  const Index r = b.cols();
  MatrixXd cb(k, r), core = MatrixXd::Identity(r, r);
  product('N', 'N', 1, css, b, 0, cb);
  product('T', 'N', -1, b, cb, 1, core);
  if (blas::potrf(count(r), core.data(), count(std::max<Index>(1, r))) != 0) {
    factors.smallest_eigenvalue = 0;
    return factors;
  }
  factors.smallest_eigenvalue = smallest_eigenvalue(core);
  // plus = [−C_DD⁻¹ C_DS; I] B L⁻ᵀ.
  MatrixXd bl = b;
  blas::trsm('R', 'T', count(k), count(r), 1, core.data(), count(std::max<Index>(1, r)), bl.data(),
             count(std::max<Index>(1, k)));
  factors.plus.resize(q, r);
  factors.plus.bottomRows(k) = bl;
  blas::trsm('L', 'T', count(d), count(k), 1, ld.data(), count(std::max<Index>(1, d)), half.data(),
             count(std::max<Index>(1, d)));
  MatrixXd top(d, r);
  product('N', 'N', -1, half, bl, 0, top);
  factors.plus.topRows(d) = top;
  return factors;
}

}  // namespace calot
