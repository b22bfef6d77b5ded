// Inside the library only: forward solves along the paths of the elimination tree that few right-hand sides touch.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "calot/compliance/blas.h"
#include "calot/compliance/sparse_factor.h"

namespace calot::detail {

/// The supernodes on the paths from those of `positions` to the roots, ascending.
inline std::vector<std::uint32_t> elimination_path(const FactorPattern& f, std::span<const std::uint32_t> positions) {
  std::vector<std::uint8_t> on_path(f.supernodes(), 0);
  for (const std::uint32_t p : positions)
    for (auto s = static_cast<std::int32_t>(f.super_of[p]); s >= 0 && !on_path[static_cast<std::size_t>(s)];
         s = f.parent[static_cast<std::size_t>(s)])
      on_path[static_cast<std::size_t>(s)] = 1;
  std::vector<std::uint32_t> path;
  for (std::size_t s = 0; s < on_path.size(); ++s)
    if (on_path[s]) path.push_back(static_cast<std::uint32_t>(s));
  return path;
}

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

}  // namespace calot::detail
