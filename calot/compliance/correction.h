// What cuts have changed since the base compliance was computed: C = C0 + C0_:T M C0_T:.
#pragma once
#include <vector>

#include "calot/compliance/compliance_base.h"
#include "calot/compliance/exact_update.h"

namespace calot {

/// One update, in rows of the base, so that it can be played again on a newer base.
struct UpdateStep {
  std::vector<std::uint32_t> rows;  ///< q: struck rows, then touched rows
  UpdateFactors factors;
};

/// The accumulated low-rank correction. T are all rows touched since the base was made; M is symmetric, |T|×|T|.
class Correction {
 public:
  explicit Correction(std::size_t base_size = 0) : place_(base_size, -1) {}

  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return rows_; }
  [[nodiscard]] const Eigen::MatrixXd& core() const { return core_; }  ///< M
  [[nodiscard]] bool empty() const { return rows_.empty(); }

  /// C_IJ, corrected.
  [[nodiscard]] Eigen::MatrixXd block(const ComplianceBase& base, Rows rows, Rows columns) const;
  /// C X, corrected.
  [[nodiscard]] Eigen::MatrixXd apply(const ComplianceBase& base, const Eigen::MatrixXd& x) const;
  /// Takes in one more update.
  void add(ComplianceBase& base, const UpdateStep& step);

 private:
  void extend(ComplianceBase& base, const std::vector<std::uint32_t>& rows);

  std::vector<std::uint32_t> rows_;  // T
  std::vector<std::int32_t> place_;  // of each base row, its place in T, or −1
  Eigen::MatrixXd core_;             // M
  Eigen::MatrixXd base_block_;       // C0_TT
};

}  // namespace calot
