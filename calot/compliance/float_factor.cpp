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

}  // namespace

FloatFactor::FloatFactor(const SparseFactor& factor)
    : pattern_(factor.shared_pattern()), values_(pattern_->panel_start.back()), inverted_(size()) {
  for (std::size_t s = 0; s < pattern_->supernodes(); ++s) {
    const std::size_t own = 3 * pattern_->own(s), ld = own + 3 * pattern_->below(s);
    const double* from = factor.panel(s);
    float* to = values_.data() + pattern_->panel_start[s];
    for (std::size_t k = 0; k < own * ld; ++k) to[k] = static_cast<float>(from[k]);
    for (std::size_t j = 0; j < own; ++j)
      inverted_[3 * std::size_t{pattern_->super_start[s]} + j] = static_cast<float>(1 / from[j * ld + j]);
  }
}

void FloatFactor::forward(float* x, std::vector<float>& work) const {
  const FactorPattern& f = *pattern_;
  work.resize(size());
  for (std::size_t s = 0; s < f.supernodes(); ++s) {
    const std::size_t own = 3 * f.own(s), below = 3 * f.below(s), ld = own + below;
    const float* panel = values_.data() + f.panel_start[s];
    float* y = x + 3 * std::size_t{f.super_start[s]};
    const float* inverse = inverted_.data() + 3 * std::size_t{f.super_start[s]};
    std::fill(work.begin(), work.begin() + static_cast<std::ptrdiff_t>(below), 0.0f);
    for (std::size_t j = 0; j < own; j += 3) {  // a vertex at a time
      const float* c = panel + j * ld;
      y[j] *= inverse[j];
      y[j + 1] = (y[j + 1] - c[j + 1] * y[j]) * inverse[j + 1];
      y[j + 2] = (y[j + 2] - c[j + 2] * y[j] - c[ld + j + 2] * y[j + 1]) * inverse[j + 2];
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
    const float* inverse = inverted_.data() + 3 * std::size_t{f.super_start[s]};
    const std::span<const std::uint32_t> rows = f.rows_of(s);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) work[3 * i + a] = x[3 * std::size_t{rows[i]} + a];
    for (std::size_t j = own; j-- > 0;) {
      const float* c = panel + j * ld;
      const float sum = dot(c + j + 1, y + j + 1, own - j - 1) + dot(c + own, work.data(), below);
      y[j] = (y[j] - sum) * inverse[j];
    }
  }
}

}  // namespace calot
