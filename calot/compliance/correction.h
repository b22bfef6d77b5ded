// What cuts have changed since the base compliance was computed.
#pragma once
#include <vector>

#include "calot/compliance/compliance_base.h"

namespace calot {

/// One update in rows of the base, so that it can be played again on a newer base.
struct UpdateStep {
  std::vector<std::uint32_t> rows;  ///< struck rows, then touched rows
  Eigen::Index struck = 0;          ///< how many of them are struck
  Eigen::MatrixXd change;           ///< Â' − Â on the touched rows [N/m], symmetric; need not be definite
};

/// What factoring a correction found.
struct CorrectionHealth {
  bool definite = true;            ///< S' is positive definite to working precision
  double smallest_eigenvalue = 1;  ///< estimate, of S' against S0: 1 costs no digits, 1e-6 costs six
  double error = 0;  ///< estimate, of the relative error of what S' answers: ε ‖S0‖ κ(C0_TT) / λ_min(S')
};

/// The exact correction, by condensing on the rows T that were touched since the base was made:
///
///   S0 = (C0_TT)⁻¹          stiffness of the uncut body as seen at T        [N/m]
///   S' = S0 + Σ changes     the same after the cuts; struck rows left out
///   G  = C0_:T S0           displacement everywhere per displacement at T
///   C' = (C0 − G C0_T:) + G S'⁻¹ Gᵀ
///
/// The first term is the compliance with T held still, the second what T lets through; both are positive semidefinite,
/// and S' is always summed from the start, so rounding does not pile up over many cuts. The same matrix as Woodbury's
/// formula gives [Hager1989] eq. 3; derivation and a comparison: docs/math.md §4.
class Correction {
 public:
  explicit Correction(std::size_t base_size = 0) : place_(base_size, -1) {}

  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return rows_; }  ///< T
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  [[nodiscard]] std::uint64_t bytes() const;

  /// Makes rows part of T at once, which is quicker than update by update; rows may repeat.
  void extend(ComplianceBase& base, const std::vector<std::uint32_t>& rows);
  /// Takes in one more update; `factor` must follow before the next query.
  void add(ComplianceBase& base, const UpdateStep& step);
  /// Factors S' and says how far it can be trusted. Nothing may be asked while it is not definite.
  CorrectionHealth factor();

  /// C'_IJ.
  [[nodiscard]] Eigen::MatrixXd block(const ComplianceBase& base, Rows rows, Rows columns) const;
  /// C' X.
  [[nodiscard]] Eigen::MatrixXd apply(const ComplianceBase& base, const Eigen::MatrixXd& x) const;

 private:
  void reserve(Eigen::Index size);
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
  [[nodiscard]] CorrectionHealth health();
  /// H with H_I H_Jᵀ = G_I S'⁻¹ G_Jᵀ, from C0_IT; and G_I in `at_touched`.
  [[nodiscard]] Eigen::MatrixXd transmitted(const Eigen::MatrixXd& base_rows, Eigen::MatrixXd& at_touched) const;

  std::vector<std::uint32_t> rows_;   // T
  std::vector<std::int32_t> place_;   // of each base row, its place in T, or −1
  std::vector<std::uint8_t> struck_;  // a flag for each of T
  Eigen::VectorXd weakest_mode_;      // of S' against S0, from the last `factor`: where the next one starts
  bool failed_ = false;               // C0_TT is not positive definite to working precision
  double largest_compliance_ = 0;     // on the diagonal of C0_TT
  // Square, of a capacity that grows by doubling; only the first |T| rows and columns count.
  Eigen::MatrixXd condensed_;  // S0, both triangles
  Eigen::MatrixXd change_;     // Σ changes on T, both triangles
  Eigen::MatrixXd factor_;     // lower Cholesky factor of S'; a struck row counts as a row of the identity
};

}  // namespace calot
