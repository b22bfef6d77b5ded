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

/// C0, constant once made; what cuts change is kept beside it as a Correction. Vertices that edits add are appended
/// uncoupled, three rows each with one compliance of their own; the correction joins them to the others.
class ComplianceBase {
 public:
  virtual ~ComplianceBase() = default;
  [[nodiscard]] std::size_t size() const { return own_size() + 3 * appended_.size(); }
  /// The block C0_IJ, |rows|×|columns|.
  [[nodiscard]] Eigen::MatrixXd gather(Rows rows, Rows columns) const;
  /// C0 X.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const;
  /// Announces rows that will be asked for again and again.
  void prepare(Rows rows);
  /// Appends a vertex of this compliance > 0 [m/N]. @return its first row
  std::uint32_t append(double compliance);
  [[nodiscard]] std::size_t appended() const { return appended_.size(); }
  void forget_appended(std::size_t kept) { appended_.resize(kept); }
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;

 protected:
  [[nodiscard]] virtual std::size_t own_size() const = 0;

 private:
  [[nodiscard]] virtual Eigen::MatrixXd own_gather(Rows rows, Rows columns) const = 0;
  [[nodiscard]] virtual Eigen::MatrixXd own_apply(const Eigen::MatrixXd& x) const = 0;
  virtual void own_prepare(Rows /*rows*/) {}
  std::vector<double> appended_;  // compliance of each appended vertex
};

class DenseBase final : public ComplianceBase {
 public:
  /// @param matrix  size² values and, after them, perhaps room for a larger one
  DenseBase(Buffer matrix, std::size_t size) : matrix_(std::move(matrix)), size_(size) {}
  [[nodiscard]] std::uint64_t bytes() const override { return size_ * size_ * sizeof(double); }
  [[nodiscard]] const double* column(std::size_t c) const { return matrix_.data() + c * size_; }
  [[nodiscard]] Buffer take() { return std::move(matrix_); }

 private:
  [[nodiscard]] std::size_t own_size() const override { return size_; }
  [[nodiscard]] Eigen::MatrixXd own_gather(Rows rows, Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd own_apply(const Eigen::MatrixXd& x) const override;
  Buffer matrix_;  // size×size, symmetric, both triangles
  std::size_t size_;
};

class SparseBase final : public ComplianceBase {
 public:
  explicit SparseBase(SparseFactor factor) : factor_(std::move(factor)), prepared_(factor_.size(), -1) {}
  [[nodiscard]] std::uint64_t bytes() const override { return factor_.bytes(); }
  [[nodiscard]] const SparseFactor& factor() const { return factor_; }

 private:
  [[nodiscard]] std::size_t own_size() const override { return factor_.size(); }
  [[nodiscard]] Eigen::MatrixXd own_gather(Rows rows, Rows columns) const override;
  [[nodiscard]] Eigen::MatrixXd own_apply(const Eigen::MatrixXd& x) const override;
  /// Keeps L⁻¹ P e_row for these rows.
  void own_prepare(Rows rows) override;
  [[nodiscard]] Eigen::MatrixXd forward(Rows rows) const;  // L⁻¹ P E_rows
  SparseFactor factor_;
  std::vector<std::int32_t> prepared_;  // of each row, its place in `forward_`, or −1
  std::vector<Eigen::VectorXd> forward_;
};

}  // namespace calot
