// Inside the library only: forward solves along the paths of the elimination tree that few right-hand sides touch.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "calot/compliance/blas.h"
#include "calot/compliance/compact_factor.h"
#include "calot/compliance/sparse_factor.h"

namespace calot::detail {

/// The supernodes on the paths from those of `positions` to the roots, ascending.
std::vector<std::uint32_t> elimination_path(const FactorPattern& f, std::span<const std::uint32_t> positions);

/// X ← L⁻¹ X, column-major with `ld` rows a column, k columns, whose non-zeros all lie on `path`; other rows are not
/// looked at. `Factor` is a SparseFactor or a FloatFactor.
template <class Real, class Factor>
void forward_on_path(const Factor& factor, std::span<const std::uint32_t> path, Real* x, std::size_t ld, std::size_t k,
                     std::vector<Real>& work) {
  const FactorPattern& f = factor.pattern();
  for (const std::uint32_t s : path) {
    const std::size_t first = 3 * std::size_t{f.super_start[s]}, own = 3 * f.own(s), below = 3 * f.below(s);
    const Real* panel = factor.panel(s);
    blas::trsm('L', 'N', own, k, Real{1}, panel, own + below, x + first, ld);
    if (below == 0) continue;
    work.resize(std::max(work.size(), below * k));
    blas::gemm('N', 'N', below, k, own, Real{1}, panel + own, own + below, x + first, ld, Real{0}, work.data(), below);
    const std::span<const std::uint32_t> rows = f.rows_of(s);
    for (std::size_t j = 0; j < k; ++j)
      for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t a = 0; a < 3; ++a) x[j * ld + 3 * rows[i] + a] -= work[j * below + 3 * i + a];
  }
}

/// y ← y − three columns of a panel times x: y is read and written once for all of them.
void subtract_three(float* y, const float* a, std::size_t ld, const float* x, std::size_t count);
void subtract_three(double* y, const double* a, std::size_t ld, const double* x, std::size_t count);
/// Three columns of a panel, each times x, summed in interleaved parts, so that the order doesn't depend on the width
/// of the registers.
void dot_three(const float* a, std::size_t ld, const float* x, std::size_t count, float* sums);
void dot_three(const double* a, std::size_t ld, const double* x, std::size_t count, double* sums);

/// One supernode of x ← L⁻¹ x. `work`: as many as its rows.
template <class Real, class Factor>
void eliminate_supernode(const Factor& factor, std::size_t s, Real* x, Real* work) {
  const FactorPattern& f = factor.pattern();
  const std::size_t own = 3 * f.own(s), below = 3 * f.below(s), ld = own + below;
  const Real* panel = factor.panel(s);
  Real* mine = x + 3 * std::size_t{f.super_start[s]};
  std::copy_n(mine, own, work);
  std::fill_n(work + own, below, Real{0});
  for (std::size_t j = 0; j < own; j += 3) {  // a vertex at a time
    const Real* c = panel + j * (ld + 1);
    Real* y = work + j;
    y[0] /= c[0];
    y[1] = (y[1] - c[1] * y[0]) / c[ld + 1];
    y[2] = (y[2] - c[2] * y[0] - c[ld + 2] * y[1]) / c[2 * ld + 2];
    subtract_three(y + 3, c + 3, ld, y, ld - j - 3);
  }
  std::copy_n(work, own, mine);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) x[3 * std::size_t{rows[i]} + a] += work[own + 3 * i + a];
}

/// One supernode of x ← L⁻ᵀ x. `work`: as many as its rows.
template <class Real, class Factor>
void substitute_supernode(const Factor& factor, std::size_t s, Real* x, Real* work) {
  const FactorPattern& f = factor.pattern();
  const std::size_t own = 3 * f.own(s), ld = own + 3 * f.below(s);
  const Real* panel = factor.panel(s);
  Real* mine = x + 3 * std::size_t{f.super_start[s]};
  std::copy_n(mine, own, work);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) work[own + 3 * i + a] = x[3 * std::size_t{rows[i]} + a];
  for (std::size_t j = own; j > 0;) {
    j -= 3;
    const Real* c = panel + j * (ld + 1);
    Real* y = work + j;
    Real sums[3];
    dot_three(c + 3, ld, y + 3, ld - j - 3, sums);
    y[2] = (y[2] - sums[2]) / c[2 * ld + 2];
    y[1] = (y[1] - sums[1] - c[ld + 2] * y[2]) / c[ld + 1];
    y[0] = (y[0] - sums[0] - c[1] * y[1] - c[2] * y[2]) / c[0];
  }
  std::copy_n(work, own, mine);
}

inline void eliminate_supernode(const CompactFactor& factor, std::size_t s, float* x, float* work) {
  factor.eliminate(s, x, work);
}
inline void substitute_supernode(const CompactFactor& factor, std::size_t s, float* x, float* work) {
  factor.substitute(s, x, work);
}

/// x ← L⁻¹ x for one vector, on one thread; `work` is grown once.
template <class Real, class Factor>
void forward_vector(const Factor& factor, Real* x, std::vector<Real>& work) {
  work.resize(std::max(work.size(), factor.size() + CompactFactor::slack));
  for (std::size_t s = 0; s < factor.pattern().supernodes(); ++s) eliminate_supernode(factor, s, x, work.data());
}

/// The same for x whose non-zeros all lie on a path.
template <class Real, class Factor>
void forward_vector(const Factor& factor, std::span<const std::uint32_t> path, Real* x, std::vector<Real>& work) {
  work.resize(std::max(work.size(), factor.size() + CompactFactor::slack));
  for (const std::uint32_t s : path) eliminate_supernode(factor, s, x, work.data());
}

/// x ← L⁻ᵀ x on a path's rows; others are not looked at.
template <class Real, class Factor>
void backward_vector(const Factor& factor, std::span<const std::uint32_t> path, Real* x, std::vector<Real>& work) {
  work.resize(std::max(work.size(), factor.size() + CompactFactor::slack));
  for (std::size_t k = path.size(); k-- > 0;) substitute_supernode(factor, path[k], x, work.data());
}

/// x ← L⁻ᵀ x for one vector.
template <class Real, class Factor>
void backward_vector(const Factor& factor, Real* x, std::vector<Real>& work) {
  work.resize(std::max(work.size(), factor.size() + CompactFactor::slack));
  for (std::size_t s = factor.pattern().supernodes(); s-- > 0;) substitute_supernode(factor, s, x, work.data());
}

}  // namespace calot::detail
