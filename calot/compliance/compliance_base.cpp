#include "calot/compliance/compliance_base.h"

#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd DenseBase::gather(Rows rows, Rows columns) const {
  // Symmetric: the shorter side picks columns of the matrix, so that the longer one reads along them.
  if (rows.size() < columns.size()) return gather(columns, rows).transpose();
  MatrixXd block(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  double* out = block.data();
  for (const std::uint32_t c : columns) {
    const double* from = column(c);
    for (const std::uint32_t r : rows) *out++ = from[r];
  }
  return block;
}

MatrixXd DenseBase::columns(Rows columns) const {
  MatrixXd result(static_cast<Index>(size_), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    std::copy_n(column(columns[k]), size_, result.col(static_cast<Index>(k)).data());
  return result;
}

MatrixXd DenseBase::apply(const MatrixXd& x) const {
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
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(size()), static_cast<Index>(rows.size()));
  std::vector<std::uint32_t> fresh;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::int32_t kept = prepared_[rows[k]];
    if (kept >= 0)
      result.col(static_cast<Index>(k)) = forward_[static_cast<std::size_t>(kept)];
    else
      fresh.push_back(static_cast<std::uint32_t>(k));
  }
  if (fresh.empty()) return result;
  MatrixXd unit = MatrixXd::Zero(static_cast<Index>(size()), static_cast<Index>(fresh.size()));
  for (std::size_t k = 0; k < fresh.size(); ++k) unit(rows[fresh[k]], static_cast<Index>(k)) = 1;
  factor_.solve_forward(unit.data(), fresh.size());
  for (std::size_t k = 0; k < fresh.size(); ++k) result.col(fresh[k]) = unit.col(static_cast<Index>(k));
  return result;
}

MatrixXd SparseBase::gather(Rows rows, Rows columns) const {
  // C0_IJ = (L⁻¹P E_I)ᵀ (L⁻¹P E_J): forward solves only.
  const MatrixXd left = forward(rows), right = forward(columns);
  MatrixXd block(left.cols(), right.cols());
  blas::gemm('T', 'N', rows.size(), columns.size(), size(), 1, left.data(), size(), right.data(), size(), 0,
             block.data(), std::max<std::size_t>(1, rows.size()));
  return block;
}

MatrixXd SparseBase::columns(Rows columns) const {
  MatrixXd result = forward(columns);
  factor_.solve_backward(result.data(), columns.size());
  return result;
}

MatrixXd SparseBase::apply(const MatrixXd& x) const {
  MatrixXd y = x;
  factor_.solve_forward(y.data(), static_cast<std::size_t>(y.cols()));
  factor_.solve_backward(y.data(), static_cast<std::size_t>(y.cols()));
  return y;
}

void SparseBase::prepare(Rows rows) {
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
