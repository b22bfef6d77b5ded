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
