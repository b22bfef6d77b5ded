#include <algorithm>

#include "calot/compliance/path_solve.h"
#include "calot/sim/warped_compliance.h"

namespace calot {
namespace {

using Index = Eigen::Index;
std::size_t size(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// Rows are only ever appended, so an older chunk's columns are zero in all rows beyond its own.
void ReadyColumns::add(const SparseFactor& factor, std::span<const std::uint32_t> first_rows) {
  const std::size_t n = factor.size();
  if (place_of_row_.empty()) {
    place_of_row_.assign(n, -1);
    column_of_row_.assign(n, -1);
  }
  std::vector<std::uint32_t> fresh, positions;
  for (const std::uint32_t row : first_rows)
    if (column_of_row_[row] < 0) {
      column_of_row_[row] = static_cast<std::int32_t>(count_ + 3 * static_cast<Index>(fresh.size()));
      fresh.push_back(row);
      positions.push_back(row / 3);
    }
  if (fresh.empty()) return;
  const std::vector<std::uint32_t> path = detail::elimination_path(factor.pattern(), positions);
  for (const std::uint32_t s : path)
    for (std::uint32_t row = 3 * factor.pattern().super_start[s]; row < 3 * factor.pattern().super_start[s + 1]; ++row)
      if (place_of_row_[row] < 0) {
        place_of_row_[row] = static_cast<std::int32_t>(rows_.size());
        rows_.push_back(row);
      }
  Chunk chunk{count_, solve(factor, fresh, path), {}};
  chunk.single = chunk.columns.cast<float>();
  extend_compliance(chunk);
  chunks_.push_back(std::move(chunk));
}

Eigen::MatrixXd ReadyColumns::solve(const SparseFactor& factor, std::span<const std::uint32_t> fresh,
                                    std::span<const std::uint32_t> path) {
  const std::size_t n = factor.size(), columns = 3 * fresh.size();
  if (solved_.size() < n * columns) solved_.resize(n * columns);
  for (std::size_t k = 0; k < columns; ++k)
    for (const std::uint32_t s : path) {
      const std::size_t first = 3 * std::size_t{factor.pattern().super_start[s]};
      std::fill_n(solved_.begin() + static_cast<std::ptrdiff_t>(n * k + first), 3 * factor.pattern().own(s), 0.0);
    }
  for (std::size_t k = 0; k < columns; ++k) solved_[n * k + fresh[k / 3] + k % 3] = 1;
  detail::forward_on_path(factor, path, solved_.data(), n, columns, work_);
  Eigen::MatrixXd packed = Eigen::MatrixXd::Zero(static_cast<Index>(rows_.size()), static_cast<Index>(columns));
  for (std::size_t k = 0; k < columns; ++k)
    for (const std::uint32_t s : path)
      for (std::uint32_t row = 3 * factor.pattern().super_start[s]; row < 3 * factor.pattern().super_start[s + 1];
           ++row)
        packed(place_of_row_[row], static_cast<Index>(k)) = solved_[n * k + row];
  return packed;
}

void ReadyColumns::extend_compliance(const Chunk& fresh) {
  const Index before = count_, width = fresh.columns.cols();
  count_ += width;
  if (gram_.rows() < count_) {
    Eigen::MatrixXd grown = Eigen::MatrixXd::Zero(count_ + count_ / 2, count_ + count_ / 2);
    grown.topLeftCorner(before, before) = gram_.topLeftCorner(before, before);
    gram_ = std::move(grown);
  }
  const auto product = [&](const Chunk& a) {
    Eigen::MatrixXd part(a.columns.cols(), width);
    const Index rows = std::min(a.columns.rows(), fresh.columns.rows());
    blas::gemm('T', 'N', size(part.rows()), size(width), size(rows), 1.0, a.columns.data(), size(a.columns.rows()),
               fresh.columns.data(), size(fresh.columns.rows()), 0.0, part.data(), size(part.rows()));
    return part;
  };
  for (const Chunk& chunk : chunks_) {
    const Eigen::MatrixXd part = product(chunk);
    gram_.block(chunk.first, before, part.rows(), width) = part;
    gram_.block(before, chunk.first, width, part.rows()) = part.transpose();
  }
  gram_.block(before, before, width, width) = product(fresh);
}

template <class Matrix>
Matrix ReadyColumns::against(const Matrix& packed) const {
  using Real = typename Matrix::Scalar;
  Matrix result(count_, packed.cols());
  for (const Chunk& chunk : chunks_) {
    const Matrix& columns = chunk.in(Real{});
    blas::gemm('T', 'N', size(columns.cols()), size(packed.cols()), size(columns.rows()), Real{1}, columns.data(),
               size(columns.rows()), packed.data(), size(packed.rows()), Real{0}, result.data() + chunk.first,
               size(count_));
  }
  return result;
}
template Eigen::MatrixXf ReadyColumns::against(const Eigen::MatrixXf&) const;
template Eigen::MatrixXd ReadyColumns::against(const Eigen::MatrixXd&) const;

}  // namespace calot
