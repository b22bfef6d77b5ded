#include "calot/fem/block_matrix.h"

#include <algorithm>

#include "calot/base/parallel.h"

namespace calot {

const Mat3* BlockMatrix::find(std::size_t row, std::size_t col) const {
  const auto first = column.begin() + row_start[row], last = column.begin() + row_start[row + 1];
  const auto found = std::lower_bound(first, last, static_cast<std::uint32_t>(col));
  return found != last && *found == col ? &block[static_cast<std::size_t>(found - column.begin())] : nullptr;
}

Mat3* BlockMatrix::find(std::size_t row, std::size_t col) {
  return const_cast<Mat3*>(static_cast<const BlockMatrix*>(this)->find(row, col));
}

void BlockMatrix::grow(std::size_t count, std::span<const std::pair<std::uint32_t, std::uint32_t>> places) {
  if (row_start.empty()) row_start.push_back(0);
  row_start.resize(std::max(count, rows()) + 1, row_start.back());
  const std::size_t old_size = column.size(), size = old_size + places.size();
  if (size > column.capacity()) {  // rarely: edits come one after another
    column.reserve(size + size / 4);
    block.reserve(size + size / 4);
  }
  column.resize(size);
  block.resize(size, Mat3::Zero());
  // From the back, so that nothing is written over before it has moved.
  std::size_t from = old_size, to = size, next = places.size();
  for (std::size_t row = rows(); row-- > 0 && next > 0;) {
    const std::size_t first = row_start[row];
    row_start[row + 1] = static_cast<std::uint32_t>(to);
    while (from > first || (next > 0 && places[next - 1].first == row)) {
      const bool fresh =
          next > 0 && places[next - 1].first == row && (from == first || places[next - 1].second > column[from - 1]);
      --to;
      column[to] = fresh ? places[--next].second : column[--from];
      block[to] = fresh ? Mat3::Zero() : block[from];
    }
  }
}

void BlockMatrix::multiply(std::span<const double> x, std::span<double> y) const {
  for (std::size_t row = 0; row < rows(); ++row) {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t k = row_start[row]; k < row_start[row + 1]; ++k)
      sum += block[k] * Eigen::Map<const Vec3>(x.data() + 3 * std::size_t{column[k]});
    Eigen::Map<Vec3>(y.data() + 3 * row) = sum;
  }
}

double BlockMatrix::norm1() const {
  // Symmetric: the largest row sum is the largest column sum.
  double largest = 0;
  for (std::size_t row = 0; row < rows(); ++row) {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t k = row_start[row]; k < row_start[row + 1]; ++k) sum += block[k].cwiseAbs().rowwise().sum();
    largest = std::max(largest, sum.maxCoeff());
  }
  return largest;
}

}  // namespace calot
