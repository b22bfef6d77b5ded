#include "calot/compliance/inverse.h"

#include <algorithm>
#include <cstring>

#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot {
namespace {

constexpr std::size_t tile = 256;

// H = L_rs L_ss⁻¹, 3·below × 3·own.
std::vector<double> elimination_matrix(const SparseFactor& factor, std::size_t s) {
  const std::size_t c = 3 * factor.pattern().own(s), r = 3 * factor.pattern().below(s);
  std::vector<double> h(r * c);
  for (std::size_t j = 0; j < c; ++j) std::copy_n(factor.panel(s) + j * (c + r) + c, r, h.data() + j * r);
  blas::trsm('R', 'N', r, c, 1, factor.panel(s), c + r, h.data(), r);
  return h;
}

// Rows [begin, end) of C(later, s) = −C(later, r) H, and their mirror image in the rows of s.
void fill_tile(const SparseFactor& factor, std::size_t s, const std::vector<double>& h, double* inverse,
               std::size_t begin, std::size_t end) {
  const FactorPattern& f = factor.pattern();
  const std::size_t n = factor.size(), first = 3 * std::size_t{f.super_start[s]}, c = 3 * f.own(s), r = 3 * f.below(s);
  const std::size_t height = end - begin;
  thread_local std::vector<double> gathered;
  gathered.resize(height * r);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      std::memcpy(gathered.data() + (3 * i + a) * height, inverse + (3 * std::size_t{rows[i]} + a) * n + begin,
                  height * sizeof(double));
  blas::gemm('N', 'N', height, c, r, -1, gathered.data(), height, h.data(), r, 0, inverse + first * n + begin, n);
  for (std::size_t i = begin; i < end; ++i)
    for (std::size_t j = 0; j < c; ++j) inverse[i * n + first + j] = inverse[(first + j) * n + i];
}

// C(s, s) = L_ss⁻ᵀ L_ss⁻¹ − Hᵀ C(r, s).
void fill_diagonal(const SparseFactor& factor, std::size_t s, const std::vector<double>& h, double* inverse) {
  const FactorPattern& f = factor.pattern();
  const std::size_t n = factor.size(), first = 3 * std::size_t{f.super_start[s]}, c = 3 * f.own(s), r = 3 * f.below(s);
  std::vector<double> own(c * c), below(r * c);
  for (std::size_t j = 0; j < c; ++j) std::copy_n(factor.panel(s) + j * (c + r), c, own.data() + j * c);
  blas::trtri(c, own.data(), c);
  blas::lauum(c, own.data(), c);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t j = 0; j < c; ++j)
    for (std::size_t i = 0; i < rows.size(); ++i)
      std::copy_n(inverse + (first + j) * n + 3 * std::size_t{rows[i]}, 3, below.data() + j * r + 3 * i);
  if (r > 0) blas::gemm('T', 'N', c, c, r, -1, h.data(), r, below.data(), r, 1, own.data(), c);
  for (std::size_t j = 0; j < c; ++j)
    for (std::size_t i = j; i < c; ++i)
      inverse[(first + j) * n + first + i] = inverse[(first + i) * n + first + j] = own[j * c + i];
}

}  // namespace

void invert(const SparseFactor& factor, double* inverse, Progress* progress) {
  const FactorPattern& f = factor.pattern();
  const std::size_t n = factor.size();
  double done = 0;
  for (std::size_t s = f.supernodes(); s-- > 0;) {
    const std::vector<double> h = elimination_matrix(factor, s);
    const std::size_t later = 3 * std::size_t{f.super_start[s + 1]};
    parallel_blocks(n - later, tile, [&](std::size_t begin, std::size_t end, std::size_t) {
      fill_tile(factor, s, h, inverse, later + begin, later + end);
    });
    fill_diagonal(factor, s, h, inverse);
    done += static_cast<double>(3 * f.own(s)) * static_cast<double>(2 * (n - later) + 3 * f.own(s));
    if (progress) progress->at(done / (static_cast<double>(n) * static_cast<double>(n)));
  }
}

}  // namespace calot
