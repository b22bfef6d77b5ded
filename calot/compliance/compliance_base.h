// The two homes of a compliance as computed: the dense matrix and the sparse factor. Rows count the free degrees of
// freedom in the factor's order.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "calot/base/memory.h"
#include "calot/compliance/sparse_factor.h"

namespace calot {

using Rows = std::span<const std::uint32_t>;

/// C0, constant once made; what cuts change is kept beside it as a Correction.
class ComplianceBase {
 public:
  virtual ~ComplianceBase() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// The block C0_IJ, |rows|×|columns|.
  [[nodiscard]] virtual Eigen::MatrixXd gather(Rows rows, Rows columns) const = 0;
  /// Whole columns, size()×|columns|.
  [[nodiscard]] virtual Eigen::MatrixXd columns(Rows columns) const = 0;
  /// C0 X.
  [[nodiscard]] virtual Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const = 0;
  /// Announces rows that will be asked for again and again.
  virtual void prepare(Rows /*rows*/) {}
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;
};

class DenseBase final : public ComplianceBase {
 public:
  DenseBase(Buffer matrix, std::size_t size) : matrix_(std::move(matrix)), size_(size) {}
  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] Eigen::MatrixXd gather(Rows rows, Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd columns(Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const override;
  [[nodiscard]] std::uint64_t bytes() const override { return size_ * size_ * sizeof(double); }
  [[nodiscard]] const double* column(std::size_t c) const { return matrix_.data() + c * size_; }
  [[nodiscard]] Buffer take() { return std::move(matrix_); }

 private:
  Buffer matrix_;  // size×size, symmetric, both triangles
  std::size_t size_;
};

class SparseBase final : public ComplianceBase {
 public:
  explicit SparseBase(SparseFactor factor) : factor_(std::move(factor)), prepared_(factor_.size(), -1) {}
  [[nodiscard]] std::size_t size() const override { return factor_.size(); }
  [[nodiscard]] Eigen::MatrixXd gather(Rows rows, Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd columns(Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const override;
  /// Keeps L⁻¹ P e_row for these rows.
  void prepare(Rows rows) override;
  [[nodiscard]] std::uint64_t bytes() const override { return factor_.bytes(); }
  [[nodiscard]] const SparseFactor& factor() const { return factor_; }

 private:
  [[nodiscard]] Eigen::MatrixXd forward(Rows rows) const;  // L⁻¹ P E_rows
  SparseFactor factor_;
  std::vector<std::int32_t> prepared_;  // of each row, its place in `forward_`, or −1
  std::vector<Eigen::VectorXd> forward_;
};

}  // namespace calot
