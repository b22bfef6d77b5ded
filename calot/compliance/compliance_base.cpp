#include "calot/compliance/compliance_base.h"

#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Rows in the base itself, and where they stand in a list.
struct OwnRows {
  std::vector<std::uint32_t> rows;
  std::vector<Index> place;
};

OwnRows own_rows(Rows rows, std::size_t own_size) {
  OwnRows own;
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (rows[k] < own_size) {
      own.rows.push_back(rows[k]);
      own.place.push_back(static_cast<Index>(k));
    }
  return own;
}

}  // namespace

std::uint32_t ComplianceBase::append(double compliance) {
  const auto first = static_cast<std::uint32_t>(size());
  appended_.push_back(compliance);
  return first;
}

MatrixXd ComplianceBase::gather(Rows rows, Rows columns) const {
  if (appended_.empty()) return own_gather(rows, columns);
  const OwnRows own = own_rows(rows, own_size()), across = own_rows(columns, own_size());
  if (own.rows.size() == rows.size() && across.rows.size() == columns.size()) return own_gather(rows, columns);
  const MatrixXd block = own_gather(own.rows, across.rows);
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  for (Index j = 0; j < block.cols(); ++j)
    for (Index i = 0; i < block.rows(); ++i)
      result(own.place[static_cast<std::size_t>(i)], across.place[static_cast<std::size_t>(j)]) = block(i, j);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    if (columns[j] < own_size()) continue;
    const double compliance = appended_[(columns[j] - own_size()) / 3];
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i] == columns[j]) result(static_cast<Index>(i), static_cast<Index>(j)) = compliance;
  }
  return result;
}

MatrixXd ComplianceBase::apply(const MatrixXd& x) const {
  if (appended_.empty()) return own_apply(x);
  const auto own = static_cast<Index>(own_size());
  MatrixXd y(x.rows(), x.cols());
  y.topRows(own) = own_apply(x.topRows(own));
  for (std::size_t k = 0; k < appended_.size(); ++k)
    y.middleRows<3>(own + static_cast<Index>(3 * k)) = appended_[k] * x.middleRows<3>(own + static_cast<Index>(3 * k));
  return y;
}

void ComplianceBase::prepare(Rows rows) {
  own_prepare(own_rows(rows, own_size()).rows);
}

MatrixXd DenseBase::own_gather(Rows rows, Rows columns) const {
  // Symmetric: the shorter side picks columns of the matrix, so that the longer one reads along them.
  if (rows.size() < columns.size()) return own_gather(columns, rows).transpose();
  MatrixXd block(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  double* out = block.data();
  for (const std::uint32_t c : columns) {
    const double* from = column(c);
    for (const std::uint32_t r : rows) *out++ = from[r];
  }
  return block;
}

MatrixXd DenseBase::own_apply(const MatrixXd& x) const {
  blas::use_one_thread();
  MatrixXd y(x.rows(), x.cols());
  parallel_blocks(size_, 256, [&](std::size_t begin, std::size_t end, std::size_t) {
    // The matrix is symmetric: its columns are its rows, and they are contiguous. One vector alone is a matter of
    // reading the matrix once, which dgemm, packing it, does not.
    if (x.cols() == 1)
      blas::gemv('T', size_, end - begin, column(begin), size_, x.data(), y.data() + begin);
    else
      blas::gemm('T', 'N', end - begin, static_cast<std::size_t>(x.cols()), size_, 1, column(begin), size_, x.data(),
                 size_, 0, y.data() + begin, size_);
  });
  return y;
}

MatrixXd SparseBase::forward(Rows rows) const {
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(own_size()), static_cast<Index>(rows.size()));
  std::vector<std::uint32_t> fresh;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::int32_t kept = prepared_[rows[k]];
    if (kept >= 0)
      result.col(static_cast<Index>(k)) = forward_[static_cast<std::size_t>(kept)];
    else
      fresh.push_back(static_cast<std::uint32_t>(k));
  }
  if (fresh.empty()) return result;
  MatrixXd unit = MatrixXd::Zero(static_cast<Index>(own_size()), static_cast<Index>(fresh.size()));
  for (std::size_t k = 0; k < fresh.size(); ++k) unit(rows[fresh[k]], static_cast<Index>(k)) = 1;
  factor_.solve_forward(unit.data(), fresh.size());
  for (std::size_t k = 0; k < fresh.size(); ++k) result.col(fresh[k]) = unit.col(static_cast<Index>(k));
  return result;
}

MatrixXd SparseBase::own_gather(Rows rows, Rows columns) const {
  // C0_IJ = (L⁻¹P E_I)ᵀ (L⁻¹P E_J): forward solves only.
  const MatrixXd left = forward(rows), right = forward(columns);
  MatrixXd block(left.cols(), right.cols());
  blas::gemm('T', 'N', rows.size(), columns.size(), own_size(), 1, left.data(), own_size(), right.data(), own_size(), 0,
             block.data(), std::max<std::size_t>(1, rows.size()));
  return block;
}

MatrixXd SparseBase::own_apply(const MatrixXd& x) const {
  MatrixXd y = x;
  factor_.solve_forward(y.data(), static_cast<std::size_t>(y.cols()));
  factor_.solve_backward(y.data(), static_cast<std::size_t>(y.cols()));
  return y;
}

void SparseBase::own_prepare(Rows rows) {
  std::vector<std::uint32_t> fresh;
  for (const std::uint32_t row : rows)
    if (prepared_[row] < 0) fresh.push_back(row);
  const MatrixXd solved = forward(fresh);
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    prepared_[fresh[k]] = static_cast<std::int32_t>(forward_.size());
    forward_.push_back(solved.col(static_cast<Index>(k)));
  }
}

}  // namespace calot
