#include "calot/compliance/correction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calot/compliance/blas.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::size_t count(Index n) {
  return static_cast<std::size_t>(n);
}

// C ← alpha·op(A) op(B) + beta·C.
void multiply(char op_a, char op_b, double alpha, const MatrixXd& a, const MatrixXd& b, double beta, MatrixXd& c) {
  const Index inner = op_a == 'N' ? a.cols() : a.rows();
  if (c.size() == 0) return;
  if (inner == 0) {
    if (beta == 0) c.setZero();
    return;
  }
  blas::gemm(op_a, op_b, count(c.rows()), count(c.cols()), count(inner), alpha, a.data(), count(a.rows()), b.data(),
             count(b.rows()), beta, c.data(), count(c.rows()));
}

MatrixXd product(char op_a, char op_b, const MatrixXd& a, const MatrixXd& b) {
  MatrixXd c(op_a == 'N' ? a.rows() : a.cols(), op_b == 'N' ? b.cols() : b.rows());
  multiply(op_a, op_b, 1, a, b, 0, c);
  return c;
}

// The upper triangle from the lower one, in tiles so that both are read along the columns they lie in.
void mirror_lower(MatrixXd& m) {
  constexpr Index tile = 32;
  for (Index j = 0; j < m.cols(); j += tile)
    for (Index i = j; i < m.rows(); i += tile)
      for (Index c = j; c < std::min(j + tile, m.cols()); ++c)
        for (Index r = std::max(i, c + 1); r < std::min(i + tile, m.rows()); ++r) m(c, r) = m(r, c);
}

// The inverse of a positive definite matrix.
MatrixXd inverse(MatrixXd a) {
  const std::size_t n = count(a.rows());
  if (n == 0) return a;
  blas::potrf(n, a.data(), n);
  blas::potri(n, a.data(), n);
  mirror_lower(a);
  return a;
}

MatrixXd columns_of(const MatrixXd& m, const std::vector<Index>& columns) {
  if (static_cast<Index>(columns.size()) == m.cols()) return m;
  MatrixXd result(m.rows(), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) result.col(static_cast<Index>(k)) = m.col(columns[k]);
  return result;
}

// A start along no mode in particular.
Eigen::VectorXd start_vector(Index size) {
  Eigen::VectorXd x(size);
  for (Index i = 0; i < size; ++i) x(i) = (i % 2 == 0 ? 1.0 : -0.6) + 0.3 * static_cast<double>(i % 7);
  return x;
}

}  // namespace

std::uint64_t Correction::bytes() const {
  return static_cast<std::uint64_t>(condensed_.size() + change_.size() + factor_.size()) * sizeof(double);
}

void Correction::extend(ComplianceBase& base, const std::vector<std::uint32_t>& rows) {
  std::vector<std::uint32_t> fresh;
  for (const std::uint32_t row : rows)
    if (place_[row] < 0) {
      place_[row] = static_cast<std::int32_t>(rows_.size() + fresh.size());
      fresh.push_back(row);
    }
  if (fresh.empty()) return;
  base.prepare(fresh);
  // The inverse of [[A, Bᵀ], [B, D]] from A⁻¹ = S0: with H = B S0 and s = (D − H Bᵀ)⁻¹ it is
  // [[S0 + Hᵀ s H, −Hᵀ s], [−s H, s]].
  const Index old = static_cast<Index>(rows_.size()), added = static_cast<Index>(fresh.size()), size = old + added;
  const MatrixXd across = base.gather(fresh, rows_);
  MatrixXd own = base.gather(fresh, fresh);
  largest_compliance_ = std::max(largest_compliance_, own.diagonal().maxCoeff());
  const MatrixXd h = product('N', 'N', across, condensed_);
  multiply('N', 'T', -1, h, across, 1, own);
  const MatrixXd s = inverse(std::move(own)), sh = product('N', 'N', s, h);
  MatrixXd grown(size, size), change = MatrixXd::Zero(size, size);
  multiply('T', 'N', 1, h, sh, 1, condensed_);
  grown.topLeftCorner(old, old) = condensed_;
  grown.bottomLeftCorner(added, old) = -sh;
  grown.bottomRightCorner(added, added) = s;
  mirror_lower(grown);
  change.topLeftCorner(old, old) = change_;
  condensed_ = std::move(grown);
  change_ = std::move(change);
  rows_.insert(rows_.end(), fresh.begin(), fresh.end());
  struck_.resize(rows_.size(), 0);
}

void Correction::add(ComplianceBase& base, const UpdateStep& step) {
  blas::use_one_thread();
  extend(base, step.rows);
  std::vector<Index> place;
  for (const std::uint32_t row : step.rows) place.push_back(place_[row]);
  const auto touched = place.begin() + step.struck;
  std::for_each(place.begin(), touched, [&](Index p) { struck_[count(p)] = 1; });
  for (Index j = 0; j < step.change.cols(); ++j)
    for (Index i = 0; i < step.change.rows(); ++i) change_(touched[i], touched[j]) += step.change(i, j);
}

CorrectionHealth Correction::factor() {
  alive_.clear();
  for (std::size_t k = 0; k < rows_.size(); ++k)
    if (!struck_[k]) alive_.push_back(static_cast<Index>(k));
  const auto size = static_cast<Index>(alive_.size());
  factor_.resize(size, size);
  for (Index j = 0; j < size; ++j)
    for (Index i = 0; i < size; ++i)
      factor_(i, j) = condensed_(alive_[count(i)], alive_[count(j)]) + change_(alive_[count(i)], alive_[count(j)]);
  if (size == 0) return {};
  if (blas::potrf(count(size), factor_.data(), count(size)) != 0) return {false, 0, 1};
  const double stiffest = condensed_.diagonal().maxCoeff();
  const double error =
      std::numeric_limits<double>::epsilon() * stiffest * stiffest * largest_compliance_ / smallest_eigenvalue();
  return {true, smallest_relative_eigenvalue(), error};
}

// λ_min(S') by inverse iteration.
double Correction::smallest_eigenvalue() const {
  const std::size_t size = count(factor_.rows());
  Eigen::VectorXd x = start_vector(factor_.rows());
  double inverse = 0;
  for (int step = 0; step < 4; ++step) {
    x /= x.norm();
    blas::trsm('L', 'N', size, 1, 1, factor_.data(), size, x.data(), size);
    inverse = x.squaredNorm();
    blas::trsm('L', 'T', size, 1, 1, factor_.data(), size, x.data(), size);
  }
  return 1 / inverse;
}

// Inverse iteration with S'⁻¹ S0; the quotient xᵀ S' x / xᵀ S0 x.
double Correction::smallest_relative_eigenvalue() const {
  const Index size = factor_.rows();
  if (size == 0) return 1;
  const MatrixXd base = [&] {
    MatrixXd m(size, size);
    for (Index j = 0; j < size; ++j)
      for (Index i = 0; i < size; ++i) m(i, j) = condensed_(alive_[count(i)], alive_[count(j)]);
    return m;
  }();
  Eigen::VectorXd x = start_vector(size);
  double smallest = 1;
  for (int step = 0; step < 5; ++step) {
    Eigen::VectorXd y = base * x;
    const double whole = x.dot(y);
    blas::trsm('L', 'N', count(size), 1, 1, factor_.data(), count(size), y.data(), count(size));
    blas::trsm('L', 'T', count(size), 1, 1, factor_.data(), count(size), y.data(), count(size));
    // y = S'⁻¹ S0 x, so yᵀ S' y = yᵀ S0 x.
    const Eigen::VectorXd back = base * y;
    const double numerator = back.dot(x), denominator = back.dot(y);
    if (denominator > 0 && whole > 0) smallest = std::min(1.0, numerator / denominator);
    x = y / y.norm();
  }
  return smallest;
}

// H with H_I H_Jᵀ = G_I S'⁻¹ G_Jᵀ, and G_I in `at_touched`.
MatrixXd Correction::transmitted(const ComplianceBase& base, Rows rows, MatrixXd& at_touched) const {
  at_touched = product('N', 'N', base.gather(rows, rows_), condensed_);
  MatrixXd h = columns_of(at_touched, alive_);
  blas::trsm('R', 'T', count(h.rows()), count(h.cols()), 1, factor_.data(),
             std::max<std::size_t>(1, count(factor_.rows())), h.data(), std::max<std::size_t>(1, count(h.rows())));
  return h;
}

MatrixXd Correction::block(const ComplianceBase& base, Rows rows, Rows columns) const {
  MatrixXd result = base.gather(rows, columns);
  if (empty() || result.size() == 0) return result;
  MatrixXd left_touched, right_touched;
  const MatrixXd left = transmitted(base, rows, left_touched);
  multiply('N', 'N', -1, left_touched, base.gather(rows_, columns), 1, result);
  const bool same = std::equal(rows.begin(), rows.end(), columns.begin(), columns.end());
  multiply('N', 'T', 1, left, same ? left : transmitted(base, columns, right_touched), 1, result);
  return result;
}

MatrixXd Correction::apply(const ComplianceBase& base, const MatrixXd& x) const {
  MatrixXd y = base.apply(x);
  if (empty()) return y;
  // a: what the uncut body would do at T. t: what the cut one does. S0 (t − a): the forces at T that make up the
  // difference.
  MatrixXd a(static_cast<Index>(rows_.size()), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < rows_.size(); ++i) a(static_cast<Index>(i), j) = y(rows_[i], j);
  const MatrixXd load = product('N', 'N', condensed_, a);
  MatrixXd t(static_cast<Index>(alive_.size()), x.cols());
  for (std::size_t i = 0; i < alive_.size(); ++i) t.row(static_cast<Index>(i)) = load.row(alive_[i]);
  for (const char op : {'N', 'T'})
    blas::trsm('L', op, alive_.size(), count(x.cols()), 1, factor_.data(), std::max<std::size_t>(1, alive_.size()),
               t.data(), std::max<std::size_t>(1, alive_.size()));
  MatrixXd difference = -a;
  for (std::size_t i = 0; i < alive_.size(); ++i) difference.row(alive_[i]) += t.row(static_cast<Index>(i));
  const MatrixXd needed = product('N', 'N', condensed_, difference);
  MatrixXd forces = MatrixXd::Zero(x.rows(), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < rows_.size(); ++i) forces(rows_[i], j) = needed(static_cast<Index>(i), j);
  y += base.apply(forces);
  return y;
}

}  // namespace calot
