// The supernodal Cholesky factor of the step stiffness, P Â Pᵀ = L Lᵀ.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "calot/base/memory.h"
#include "calot/base/progress.h"
#include "calot/fem/block_matrix.h"

namespace calot {

/// What of the factor depends on the pattern only. Everything counts vertices; a vertex is three consecutive rows.
/// Row positions are in the factor's order: position p holds the active vertex perm[p].
struct FactorPattern {
  std::vector<std::uint32_t> perm;         ///< n, position → active vertex
  std::vector<std::uint32_t> position;     ///< n, active vertex → position
  std::vector<std::uint32_t> super_start;  ///< s + 1, first position of each supernode
  std::vector<std::uint64_t> row_start;    ///< s + 1, into rows
  std::vector<std::uint32_t> rows;         ///< positions below each supernode's own, ascending
  std::vector<std::uint64_t> panel_start;  ///< s + 1, into the values: panel s is 3(own + below) × 3·own, column-major
  std::vector<std::int32_t> parent;        ///< s, the supernode that the first row below belongs to; −1 at a root
  std::vector<std::uint32_t> super_of;     ///< n, supernode of each position
  double flops = 0;                        ///< of the numeric factorisation
  double nonzeros = 0;                     ///< of L, lower triangle

  [[nodiscard]] std::size_t vertices() const { return perm.size(); }
  [[nodiscard]] std::size_t supernodes() const { return parent.size(); }
  [[nodiscard]] std::size_t own(std::size_t s) const { return super_start[s + 1] - super_start[s]; }
  [[nodiscard]] std::size_t below(std::size_t s) const { return row_start[s + 1] - row_start[s]; }
  [[nodiscard]] std::span<const std::uint32_t> rows_of(std::size_t s) const {
    return {rows.data() + row_start[s], below(s)};
  }
};

/// Completes a pattern from its ordering and its rows, as read from a file; everything is checked, as numbers from
/// elsewhere.
/// @param perm         n, position → active vertex, a permutation
/// @param super_start  first position of each supernode and, last, n
/// @param row_start    into `rows`, one a supernode and, last, their number
/// @param rows         positions below each supernode's own, ascending; those beyond its parent are the parent's too
/// Throws InputError saying which of this does not hold.
FactorPattern complete_pattern(std::vector<std::uint32_t> perm, std::vector<std::uint32_t> super_start,
                               std::vector<std::uint64_t> row_start, std::vector<std::uint32_t> rows);

/// Orders (nested dissection) and analyses the rows and columns of `matrix` for which active is 1. Blocks that are zero
/// get no room.
/// @param active  one flag a block row; the k-th active row is active vertex k
/// Source: Davis 2006, ch. 4; METIS (Karypis & Kumar 1998) through CHOLMOD (Chen et al. 2008).
FactorPattern analyse(const BlockMatrix& matrix, std::span<const std::uint8_t> active);

/// The numeric factor. Multifrontal (Duff & Reid 1983), on all threads, with the same bits on any number of them.
class SparseFactor {
 public:
  SparseFactor() = default;
  /// Factors the active rows of `matrix`, which must be positive definite; rows in `dead` count as identity. Every
  /// block that is not zero must have its room in the pattern. Throws Unsupported naming the active vertex where a
  /// pivot is not positive, Interrupted, FailedError (memory).
  SparseFactor(std::shared_ptr<const FactorPattern> pattern, const BlockMatrix& matrix,
               std::span<const std::uint8_t> active, std::span<const std::uint8_t> dead = {},
               Progress* progress = nullptr);

  /// A factor computed before; `values` are its panels, pattern->panel_start.back() of them.
  SparseFactor(std::shared_ptr<const FactorPattern> pattern, Buffer values)
      : pattern_(std::move(pattern)), values_(std::move(values)) {}

  [[nodiscard]] const FactorPattern& pattern() const { return *pattern_; }
  [[nodiscard]] const std::shared_ptr<const FactorPattern>& shared_pattern() const { return pattern_; }
  [[nodiscard]] std::size_t size() const { return 3 * pattern_->vertices(); }
  [[nodiscard]] const double* panel(std::size_t s) const { return values_.data() + pattern_->panel_start[s]; }
  [[nodiscard]] std::uint64_t bytes() const { return values_.size() * sizeof(double); }

  /// X ← L⁻¹ X and X ← L⁻ᵀ X for X 3n×k, column-major, rows in the factor's order; k columns in blocks on all threads.
  /// Rows of zeros before the first non-zero cost nothing in the forward solve.
  void solve_forward(double* x, std::size_t k) const;
  void solve_backward(double* x, std::size_t k) const;

 private:
  std::shared_ptr<const FactorPattern> pattern_;
  Buffer values_;
};

}  // namespace calot
