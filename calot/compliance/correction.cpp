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

// Two halves of a square of which the lower one is filled: the upper from the lower, in tiles, so that both are read
// and written along columns. Only the first `size` rows and columns.
void mirror_lower(MatrixXd& m, Index size) {
  constexpr Index tile = 32;
  for (Index j = 0; j < size; j += tile)
    for (Index i = j; i < size; i += tile)
      for (Index c = j; c < std::min(j + tile, size); ++c)
        for (Index r = std::max(i, c + 1); r < std::min(i + tile, size); ++r) m(c, r) = m(r, c);
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

void Correction::reserve(Index size) {
  if (size <= condensed_.rows()) return;
  const Index capacity = std::max<Index>(2 * condensed_.rows(), (size + 127) / 128 * 128);
  for (MatrixXd* m : {&condensed_, &change_}) {
    MatrixXd larger = MatrixXd::Zero(capacity, capacity);
    larger.topLeftCorner(m->rows(), m->cols()) = *m;
    *m = std::move(larger);
  }
  factor_.resize(capacity, capacity);
}

void Correction::extend(ComplianceBase& base, const std::vector<std::uint32_t>& rows) {
  if (place_.size() < base.size()) place_.resize(base.size(), -1);
  std::vector<std::uint32_t> fresh;
  for (const std::uint32_t row : rows)
    if (place_[row] < 0) {
      place_[row] = static_cast<std::int32_t>(rows_.size() + fresh.size());
      fresh.push_back(row);
    }
  if (fresh.empty()) return;
  base.prepare(fresh);
  // The inverse of [[A, Bᵀ], [B, D]] from A⁻¹ = S0: with H = B S0 and D − H Bᵀ = L Lᵀ it is
  // [[S0 + Hᵀ s H, −Hᵀ s], [−s H, s]], s = L⁻ᵀ L⁻¹.
  const Index old = size(), added = static_cast<Index>(fresh.size());
  const MatrixXd across = base.gather(fresh, rows_);
  MatrixXd own = base.gather(fresh, fresh), h(added, old);
  largest_compliance_ = std::max(largest_compliance_, own.diagonal().maxCoeff());
  reserve(old + added);
  const std::size_t capacity = count(condensed_.rows()), n = count(old), k = count(added);
  if (n > 0) {
    blas::gemm('N', 'N', k, n, n, 1, across.data(), k, condensed_.data(), capacity, 0, h.data(), k);
    blas::gemm('N', 'T', k, k, n, -1, h.data(), k, across.data(), k, 1, own.data(), k);
  }
  if (blas::potrf(k, own.data(), k) != 0) failed_ = true;
  blas::trsm('L', 'N', k, n, 1, own.data(), k, h.data(), k);                         // L⁻¹ H
  if (n > 0) blas::syrk('T', n, k, 1, h.data(), k, 1, condensed_.data(), capacity);  // S0 + Hᵀ s H
  blas::trsm('L', 'T', k, n, -1, own.data(), k, h.data(), k);                        // −s H
  condensed_.block(old, 0, added, old) = h;
  blas::potri(k, own.data(), k);  // s
  condensed_.block(old, old, added, added) = own;
  rows_.insert(rows_.end(), fresh.begin(), fresh.end());
  mirror_lower(condensed_, size());
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
  const Index n = size();
  if (failed_) return {false, 0, 1};
  if (n == 0) return {};
  for (Index j = 0; j < n; ++j) {
    if (struck_[count(j)]) {
      factor_.col(j).segment(j, n - j).setZero();
      factor_(j, j) = 1;
    } else {
      factor_.col(j).segment(j, n - j) = condensed_.col(j).segment(j, n - j) + change_.col(j).segment(j, n - j);
    }
  }
  for (Index i = 0; i < n; ++i)
    if (struck_[count(i)]) factor_.row(i).head(i).setZero();
  if (blas::potrf(count(n), factor_.data(), count(factor_.rows())) != 0) return {false, 0, 1};
  return health();
}

// Inverse iteration with S'⁻¹ S0 on the rows that are not struck. On the way: λ_min of S' itself, from the same solves.
CorrectionHealth Correction::health() {
  const std::size_t n = rows_.size(), capacity = count(factor_.rows());
  const auto without_struck = [&](Eigen::VectorXd& x) {
    for (std::size_t k = 0; k < n; ++k)
      if (struck_[k]) x(static_cast<Index>(k)) = 0;
  };
  const int steps = weakest_mode_.size() == 0 ? 3 : 1;
  Eigen::VectorXd x = start_vector(size()), s0x(size()), s0y(size());
  x *= weakest_mode_.size() == 0 ? 1.0 : 0.05;  // the mode known so far, and a little of every other
  x.head(weakest_mode_.size()) += weakest_mode_;
  without_struck(x);
  if (x.isZero(0)) return {};
  CorrectionHealth health;
  double weakest = std::numeric_limits<double>::max();
  blas::gemv('N', n, n, condensed_.data(), capacity, x.data(), s0x.data());
  without_struck(s0x);
  for (int step = 0; step < steps; ++step) {
    Eigen::VectorXd y = s0x;
    blas::trsv('N', n, factor_.data(), capacity, y.data());
    blas::trsv('T', n, factor_.data(), capacity, y.data());  // y = S'⁻¹ S0 x, so yᵀ S' y = yᵀ S0 x
    blas::gemv('N', n, n, condensed_.data(), capacity, y.data(), s0y.data());
    without_struck(s0y);
    const double stored = y.dot(s0x);
    if (const double whole = y.dot(s0y); whole > 0) health.smallest_eigenvalue = std::min(1.0, stored / whole);
    if (const double length = y.squaredNorm(); length > 0) weakest = std::min(weakest, stored / length);
    const double scale = 1 / y.norm();
    x = scale * y;
    s0x = scale * s0y;
  }
  weakest_mode_ = x;
  const double stiffest = condensed_.diagonal().head(size()).maxCoeff();
  health.error = std::numeric_limits<double>::epsilon() * stiffest * stiffest * largest_compliance_ / weakest;
  return health;
}

MatrixXd Correction::transmitted(const MatrixXd& base_rows, MatrixXd& at_touched) const {
  const std::size_t k = count(base_rows.rows()), n = rows_.size(), capacity = count(condensed_.rows());
  at_touched.resize(base_rows.rows(), size());
  blas::gemm('N', 'N', k, n, n, 1, base_rows.data(), k, condensed_.data(), capacity, 0, at_touched.data(), k);
  MatrixXd h = at_touched;
  for (std::size_t j = 0; j < n; ++j)
    if (struck_[j]) h.col(static_cast<Index>(j)).setZero();
  blas::trsm('R', 'T', k, n, 1, factor_.data(), capacity, h.data(), k);
  return h;
}

MatrixXd Correction::block(const ComplianceBase& base, Rows rows, Rows columns) const {
  MatrixXd result = base.gather(rows, columns);
  if (empty() || result.size() == 0) return result;
  const std::size_t m = rows.size(), k = columns.size(), n = rows_.size();
  const bool same = std::equal(rows.begin(), rows.end(), columns.begin(), columns.end());
  const MatrixXd left_base = base.gather(rows, rows_);
  MatrixXd left_touched, right_touched;
  const MatrixXd left = transmitted(left_base, left_touched);
  const MatrixXd right_base = same ? MatrixXd() : base.gather(columns, rows_);
  const MatrixXd right = same ? MatrixXd() : transmitted(right_base, right_touched);
  blas::gemm('N', 'T', m, k, n, -1, left_touched.data(), m, same ? left_base.data() : right_base.data(), k, 1,
             result.data(), m);
  blas::gemm('N', 'T', m, k, n, 1, left.data(), m, same ? left.data() : right.data(), k, 1, result.data(), m);
  return result;
}

MatrixXd Correction::apply(const ComplianceBase& base, const MatrixXd& x) const {
  MatrixXd y = base.apply(x);
  if (empty()) return y;
  // a: what the uncut body would do at T. t: what the cut one does. S0 (t − a): the forces at T that make up the
  // difference.
  const std::size_t n = rows_.size(), k = count(x.cols()), capacity = count(condensed_.rows());
  MatrixXd a(size(), x.cols()), t(size(), x.cols()), needed(size(), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < n; ++i) a(static_cast<Index>(i), j) = y(rows_[i], j);
  blas::gemm('N', 'N', n, k, n, 1, condensed_.data(), capacity, a.data(), n, 0, t.data(), n);
  for (std::size_t i = 0; i < n; ++i)
    if (struck_[i]) t.row(static_cast<Index>(i)).setZero();
  for (const char op : {'N', 'T'}) blas::trsm('L', op, n, k, 1, factor_.data(), capacity, t.data(), n);
  t -= a;
  blas::gemm('N', 'N', n, k, n, 1, condensed_.data(), capacity, t.data(), n, 0, needed.data(), n);
  MatrixXd forces = MatrixXd::Zero(x.rows(), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < n; ++i) forces(rows_[i], j) = needed(static_cast<Index>(i), j);
  y += base.apply(forces);
  return y;
}

}  // namespace calot
