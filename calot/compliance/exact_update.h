// The exact update of a compliance when tets go: a low-rank correction on the rows they touched.
#pragma once
#include <Eigen/Core>

namespace calot {

/// C' = C − (C_:q minus)(C_:q minus)ᵀ + (C_:q plus)(C_:q plus)ᵀ, where q are the struck rows, then the touched ones.
struct UpdateFactors {
  Eigen::MatrixXd minus;           ///< q×d: strikes the d rows
  Eigen::MatrixXd plus;            ///< q×r [(N/m)^½]: takes the stiffness of the removed tets away
  double smallest_eigenvalue = 1;  ///< estimate, of I − Bᵀ C_SS B; 0 when its Cholesky factorisation broke down
  [[nodiscard]] bool definite() const { return smallest_eigenvalue > 0; }
};

/// Removes tets from a compliance exactly: rows D are struck from Â, then Σ Â_e of the removed tets leaves rows S.
/// @param block    C_qq of the compliance before, q = D then S [m/N]
/// @param struck   d, how many of the rows are D
/// @param removed  Σ Â_e of the removed tets on S, (q−d)×(q−d) [N/m], symmetric positive semidefinite
/// @return factors on the rows q; not definite() where the remaining stiffness has no inverse to working precision.
/// Source: [Hager1989] eq. 3; docs/math.md §4.
UpdateFactors exact_update(const Eigen::MatrixXd& block, Eigen::Index struck, const Eigen::MatrixXd& removed);

}  // namespace calot
