// A symmetric sparse matrix of 3×3 blocks, one block row a vertex.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "calot/base/ids.h"

namespace calot {

using Mat3 = Eigen::Matrix3d;
using Vec3 = Eigen::Vector3d;

/// Block rows in compressed form; both triangles are stored, columns ascend within a row.
struct BlockMatrix {
  std::vector<std::uint32_t> row_start;  ///< n + 1
  std::vector<std::uint32_t> column;     ///< k block columns
  std::vector<Mat3> block;               ///< k

  [[nodiscard]] std::size_t rows() const { return row_start.empty() ? 0 : row_start.size() - 1; }
  /// The block at (row, column), or nullptr outside the pattern.
  [[nodiscard]] Mat3* find(std::size_t row, std::size_t col);
  [[nodiscard]] const Mat3* find(std::size_t row, std::size_t col) const;
  /// Makes room for zero blocks, in place; the matrix grows to `rows` rows.
  /// @param places  (row, column) not in the pattern, ascending, unique
  void grow(std::size_t rows, std::span<const std::pair<std::uint32_t, std::uint32_t>> places);
  /// y = A x for x, y of 3n values.
  void multiply(std::span<const double> x, std::span<double> y) const;
  /// Largest absolute column sum, ‖A‖₁.
  [[nodiscard]] double norm1() const;
};

}  // namespace calot
