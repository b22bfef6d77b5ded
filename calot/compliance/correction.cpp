#include "calot/compliance/correction.h"

#include "calot/compliance/blas.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::size_t count(Index n) {
  return static_cast<std::size_t>(n);
}

MatrixXd multiply(char op_a, char op_b, const MatrixXd& a, const MatrixXd& b) {
  const Index rows = op_a == 'N' ? a.rows() : a.cols(), inner = op_a == 'N' ? a.cols() : a.rows();
  const Index columns = op_b == 'N' ? b.cols() : b.rows();
  MatrixXd c = MatrixXd::Zero(rows, columns);
  if (c.size() == 0 || inner == 0) return c;
  blas::gemm(op_a, op_b, count(rows), count(columns), count(inner), 1, a.data(), count(a.rows()), b.data(),
             count(b.rows()), 0, c.data(), count(rows));
  return c;
}

void mirror_lower(MatrixXd& m) {
  for (Index j = 0; j < m.cols(); ++j)
    for (Index i = j + 1; i < m.rows(); ++i) m(j, i) = m(i, j);
}

MatrixXd rows_of(const MatrixXd& m, const std::vector<Index>& rows) {
  MatrixXd result(static_cast<Index>(rows.size()), m.cols());
  for (Index j = 0; j < m.cols(); ++j)
    for (std::size_t i = 0; i < rows.size(); ++i) result(static_cast<Index>(i), j) = m(rows[i], j);
  return result;
}

}  // namespace

MatrixXd Correction::block(const ComplianceBase& base, Rows rows, Rows columns) const {
  MatrixXd result = base.gather(rows, columns);
  if (empty() || result.size() == 0) return result;
  const MatrixXd left = base.gather(rows, rows_);
  const MatrixXd weighted = multiply('N', 'N', left, core_);
  const bool same = rows.size() == columns.size() && std::equal(rows.begin(), rows.end(), columns.begin());
  const MatrixXd right = same ? left : base.gather(columns, rows_);
  blas::gemm('N', 'T', rows.size(), columns.size(), rows_.size(), 1, weighted.data(), rows.size(), right.data(),
             columns.size(), 1, result.data(), rows.size());
  return result;
}

MatrixXd Correction::apply(const ComplianceBase& base, const MatrixXd& x) const {
  MatrixXd y = base.apply(x);
  if (empty()) return y;
  MatrixXd at_rows(static_cast<Index>(rows_.size()), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < rows_.size(); ++i) at_rows(static_cast<Index>(i), j) = y(rows_[i], j);
  const MatrixXd weighted = multiply('N', 'N', core_, at_rows);
  MatrixXd forces = MatrixXd::Zero(x.rows(), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t i = 0; i < rows_.size(); ++i) forces(rows_[i], j) = weighted(static_cast<Index>(i), j);
  y += base.apply(forces);
  return y;
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
  const Index old = static_cast<Index>(rows_.size()), added = static_cast<Index>(fresh.size()), size = old + added;
  const MatrixXd across = base.gather(fresh, rows_), own = base.gather(fresh, fresh);
  MatrixXd grown(size, size), core = MatrixXd::Zero(size, size);
  grown.topLeftCorner(old, old) = base_block_;
  grown.bottomLeftCorner(added, old) = across;
  grown.topRightCorner(old, added) = across.transpose();
  grown.bottomRightCorner(added, added) = own;
  core.topLeftCorner(old, old) = core_;
  base_block_ = std::move(grown);
  core_ = std::move(core);
  rows_.insert(rows_.end(), fresh.begin(), fresh.end());
}

void Correction::add(ComplianceBase& base, const UpdateStep& step) {
  blas::use_one_thread();
  extend(base, step.rows);
  std::vector<Index> place;
  for (const std::uint32_t row : step.rows) place.push_back(place_[row]);
  // C_:q = C0_:T E with E = I_:q + M C0_Tq; the step adds −(C_:q minus)(…)ᵀ + (C_:q plus)(…)ᵀ, so M gains E (…) Eᵀ.
  // M is symmetric, so E·U = U on the rows q, plus M (C0_Tq U).
  const auto through = [&](const MatrixXd& factor) {
    const MatrixXd base_columns = rows_of(base_block_, place);  // C0_qT
    MatrixXd e = multiply('N', 'N', core_, multiply('T', 'N', base_columns, factor));
    for (Index j = 0; j < factor.cols(); ++j)
      for (std::size_t i = 0; i < place.size(); ++i) e(place[i], j) += factor(static_cast<Index>(i), j);
    return e;
  };
  const MatrixXd minus = through(step.factors.minus), plus = through(step.factors.plus);
  const std::size_t size = rows_.size();
  blas::syrk('N', size, count(minus.cols()), -1, minus.data(), size, 1, core_.data(), size);
  blas::syrk('N', size, count(plus.cols()), 1, plus.data(), size, 1, core_.data(), size);
  mirror_lower(core_);
}

}  // namespace calot
