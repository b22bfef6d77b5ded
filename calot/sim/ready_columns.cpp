#include <algorithm>

#include "calot/compliance/blas.h"
#include "calot/sim/warped_compliance.h"

namespace calot {
namespace {

using Index = Eigen::Index;

// Room for at least `rows` × `columns`, what was there kept, new entries zero.
template <class Matrix>
void grow(Matrix& matrix, Index rows, Index columns) {
  if (rows <= matrix.rows() && columns <= matrix.cols()) return;
  Matrix grown = Matrix::Zero(std::max(rows, matrix.rows() + matrix.rows() / 2),
                              std::max(columns, matrix.cols() + matrix.cols() / 2));
  grown.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
  matrix = std::move(grown);
}

}  // namespace

void ReadyColumns::add(const SparseFactor& factor, std::span<const std::uint32_t> first_rows) {
  const std::size_t n = factor.size();
  if (place_of_row_.empty()) {
    place_of_row_.assign(n, -1);
    column_of_row_.assign(n, -1);
  }
  std::vector<std::uint32_t> fresh;
  for (const std::uint32_t row : first_rows)
    if (column_of_row_[row] < 0) {
      column_of_row_[row] = static_cast<std::int32_t>(count_ + 3 * static_cast<Index>(fresh.size()));
      fresh.push_back(row);
    }
  if (fresh.empty()) return;
  const std::size_t columns = 3 * fresh.size();
  std::vector<double> x(n * columns, 0.0);
  for (std::size_t k = 0; k < columns; ++k) x[n * k + fresh[k / 3] + k % 3] = 1;
  factor.solve_forward(x.data(), columns);
  const FactorPattern& pattern = factor.pattern();
  std::vector<std::uint8_t> on_path(pattern.supernodes(), 0);
  for (const std::uint32_t row : fresh)
    for (auto s = static_cast<std::int32_t>(pattern.super_of[row / 3]); s >= 0 && !on_path[static_cast<std::size_t>(s)];
         s = pattern.parent[static_cast<std::size_t>(s)])
      on_path[static_cast<std::size_t>(s)] = 1;
  for (std::size_t s = 0; s < on_path.size(); ++s)
    for (std::uint32_t row = 3 * pattern.super_start[s]; on_path[s] && row < 3 * pattern.super_start[s + 1]; ++row)
      if (place_of_row_[row] < 0) {
        place_of_row_[row] = static_cast<std::int32_t>(rows_.size());
        rows_.push_back(row);
      }
  const auto rows = static_cast<Index>(rows_.size()), all = count_ + static_cast<Index>(columns);
  grow(packed_, rows, all);
  for (Index k = count_; k < all; ++k) {
    const double* from = x.data() + n * static_cast<std::size_t>(k - count_);
    for (Index i = 0; i < rows; ++i) packed_(i, k) = from[rows_[static_cast<std::size_t>(i)]];
  }
  grow(single_, packed_.rows(), packed_.cols());
  single_.block(0, count_, packed_.rows(), all - count_) =
      packed_.block(0, count_, packed_.rows(), all - count_).cast<float>();
  grow(gram_, all, all);
  Eigen::MatrixXd fresh_gram(all, all - count_);
  const auto size = [](Index i) { return static_cast<std::size_t>(i); };
  blas::gemm('T', 'N', size(all), columns, size(rows), 1, packed_.data(), size(packed_.rows()),
             packed_.data() + count_ * packed_.rows(), size(packed_.rows()), 0, fresh_gram.data(), size(all));
  gram_.block(0, count_, all, all - count_) = fresh_gram;
  gram_.block(count_, 0, all - count_, all) = fresh_gram.transpose();
  count_ = all;
}

}  // namespace calot
