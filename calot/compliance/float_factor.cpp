#include "calot/compliance/float_factor.h"

#include <algorithm>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define CALOT_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define CALOT_WIDE
#endif

namespace calot {
namespace {

// Three columns of a panel at once: y is read and written once for all of them.
CALOT_WIDE void subtract_three(float* __restrict y, const float* __restrict a, std::size_t ld, const float* x,
                               std::size_t count) {
  const float x0 = x[0], x1 = x[1], x2 = x[2];
  const float *a0 = a, *a1 = a + ld, *a2 = a + 2 * ld;
  for (std::size_t i = 0; i < count; ++i) y[i] -= a0[i] * x0 + a1[i] * x1 + a2[i] * x2;
}

// The sum stands in sixteen interleaved parts, so that its order doesn't depend on the width of the registers.
CALOT_WIDE float dot(const float* __restrict a, const float* __restrict x, std::size_t count) {
  constexpr std::size_t width = 16;
  float sums[width] = {};
  std::size_t i = 0;
  for (; i + width <= count; i += width)
    for (std::size_t l = 0; l < width; ++l) sums[l] += a[i + l] * x[i + l];
  for (std::size_t l = 0; i < count; ++i, ++l) sums[l] += a[i] * x[i];
  for (std::size_t half = width / 2; half > 0; half /= 2)
    for (std::size_t l = 0; l < half; ++l) sums[l] += sums[l + half];
  return sums[0];
}

// The lower triangle of a supernode, its diagonal inverted, on sixteen right-hand sides; then its rows below.
CALOT_WIDE void eliminate_many(const float* panel, std::size_t own, std::size_t ld, float* __restrict x,
                               float* __restrict below) {
  constexpr std::size_t w = FloatFactor::lanes;
  for (std::size_t j = 0; j < own; ++j) {
    const float* column = panel + j * ld;
    float pivot[w];
    for (std::size_t l = 0; l < w; ++l) pivot[l] = x[w * j + l] = x[w * j + l] * column[j];
    for (std::size_t i = j + 1; i < own; ++i)
      for (std::size_t l = 0; l < w; ++l) x[w * i + l] -= column[i] * pivot[l];
  }
  // Rows below in tiles of four, so that their sums stay in registers.
  const std::size_t rows = ld - own;
  for (std::size_t i = 0; i < rows; i += 4) {
    const std::size_t tall = std::min<std::size_t>(4, rows - i);
    float sum[4][w] = {};
    if (tall == 4) {
      for (std::size_t j = 0; j < own; ++j) {
        const float* a = panel + j * ld + own + i;
        for (std::size_t k = 0; k < 4; ++k)
          for (std::size_t l = 0; l < w; ++l) sum[k][l] += a[k] * x[w * j + l];
      }
    } else {
      for (std::size_t j = 0; j < own; ++j)
        for (std::size_t k = 0; k < tall; ++k)
          for (std::size_t l = 0; l < w; ++l) sum[k][l] += panel[j * ld + own + i + k] * x[w * j + l];
    }
    for (std::size_t k = 0; k < tall; ++k)
      for (std::size_t l = 0; l < w; ++l) below[w * (i + k) + l] = sum[k][l];
  }
}

}  // namespace

FloatFactor::FloatFactor(const SparseFactor& factor)
    : pattern_(factor.shared_pattern()), values_(pattern_->panel_start.back()) {
  for (std::size_t s = 0; s < pattern_->supernodes(); ++s) {
    const std::size_t own = 3 * pattern_->own(s), ld = own + 3 * pattern_->below(s);
    const double* from = factor.panel(s);
    float* to = values_.data() + pattern_->panel_start[s];
    for (std::size_t k = 0; k < own * ld; ++k) to[k] = static_cast<float>(from[k]);
    for (std::size_t j = 0; j < own; ++j) to[j * ld + j] = static_cast<float>(1 / from[j * ld + j]);
  }
}

void FloatFactor::forward(float* x, std::vector<float>& work) const {
  const FactorPattern& f = *pattern_;
  work.resize(size());
  for (std::size_t s = 0; s < f.supernodes(); ++s) {
    const std::size_t own = 3 * f.own(s), below = 3 * f.below(s), ld = own + below;
    const float* panel = values_.data() + f.panel_start[s];
    float* y = x + 3 * std::size_t{f.super_start[s]};
    std::fill(work.begin(), work.begin() + static_cast<std::ptrdiff_t>(below), 0.0f);
    for (std::size_t j = 0; j < own; j += 3) {  // a vertex at a time
      const float* c = panel + j * ld;
      y[j] *= c[j];
      y[j + 1] = (y[j + 1] - c[j + 1] * y[j]) * c[ld + j + 1];
      y[j + 2] = (y[j + 2] - c[j + 2] * y[j] - c[ld + j + 2] * y[j + 1]) * c[2 * ld + j + 2];
      subtract_three(y + j + 3, c + j + 3, ld, y + j, own - j - 3);
      subtract_three(work.data(), c + own, ld, y + j, below);
    }
    const std::span<const std::uint32_t> rows = f.rows_of(s);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) x[3 * std::size_t{rows[i]} + a] += work[3 * i + a];
  }
}

void FloatFactor::backward(float* x, std::vector<float>& work) const {
  const FactorPattern& f = *pattern_;
  work.resize(size());
  for (std::size_t s = f.supernodes(); s-- > 0;) {
    const std::size_t own = 3 * f.own(s), below = 3 * f.below(s), ld = own + below;
    const float* panel = values_.data() + f.panel_start[s];
    float* y = x + 3 * std::size_t{f.super_start[s]};
    const std::span<const std::uint32_t> rows = f.rows_of(s);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) work[3 * i + a] = x[3 * std::size_t{rows[i]} + a];
    for (std::size_t j = own; j-- > 0;) {
      const float* c = panel + j * ld;
      const float sum = dot(c + j + 1, y + j + 1, own - j - 1) + dot(c + own, work.data(), below);
      y[j] = (y[j] - sum) * c[j];
    }
  }
}

void FloatFactor::forward_many(float* x, std::span<const std::uint32_t> starts, std::vector<std::uint32_t>& path,
                               std::vector<float>& work) const {
  const FactorPattern& f = *pattern_;
  path.clear();
  for (const std::uint32_t start : starts)
    for (std::int32_t s = static_cast<std::int32_t>(start); s >= 0; s = f.parent[static_cast<std::size_t>(s)])
      path.push_back(static_cast<std::uint32_t>(s));
  std::sort(path.begin(), path.end());
  path.erase(std::unique(path.begin(), path.end()), path.end());
  for (const std::uint32_t s : path) {
    const std::size_t own = 3 * f.own(s), ld = own + 3 * f.below(s);
    work.resize(std::max(work.size(), lanes * (ld - own)));
    eliminate_many(values_.data() + f.panel_start[s], own, ld, x + lanes * 3 * std::size_t{f.super_start[s]},
                   work.data());
    const std::span<const std::uint32_t> rows = f.rows_of(s);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      float* to = x + lanes * 3 * std::size_t{rows[i]};
      for (std::size_t k = 0; k < 3 * lanes; ++k) to[k] -= work[lanes * 3 * i + k];
    }
  }
}

}  // namespace calot
