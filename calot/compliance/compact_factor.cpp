#include "calot/compliance/compact_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#endif

namespace calot {
namespace {

constexpr std::size_t width = 8;
static_assert(CompactFactor::slack == 2 * width);

// Both loops run on to a whole number of registers: over the column's end there are the next one's numbers, and in the
// vector room that nobody reads (`subtract`) or zeros (`dot`).

// y ← y − three columns times x.
[[maybe_unused]] void subtract_plain(float* y, const std::int16_t* a, std::size_t ld, const float* x,
                                     std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    y[i] -= (static_cast<float>(a[i]) * x[0] + static_cast<float>(a[ld + i]) * x[1]) +
            static_cast<float>(a[2 * ld + i]) * x[2];
}

// Three columns, each times x.
[[maybe_unused]] void dot_plain(const std::int16_t* a, std::size_t ld, const float* x, std::size_t count, float* sums) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<float, 2 * width> sum{};
    for (std::size_t i = 0; i < count; i += 2 * width)
      for (std::size_t l = 0; l < 2 * width; ++l) sum[l] += static_cast<float>(a[c * ld + i + l]) * x[i + l];
    for (std::size_t half = width; half > 0; half /= 2)
      for (std::size_t l = 0; l < half; ++l) sum[l] += sum[l + half];
    sums[c] = sum[0];
  }
}

#if defined(__x86_64__) && defined(__GNUC__)
// The same arithmetic, eight at a time; compilers don't find the instruction that widens eight numbers at once.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256 widened(const std::int16_t* from) {
  return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
}

[[gnu::target("avx2")]] void subtract_wide(float* y, const std::int16_t* a, std::size_t ld, const float* x,
                                           std::size_t count) {
  const __m256 x0 = _mm256_set1_ps(x[0]), x1 = _mm256_set1_ps(x[1]), x2 = _mm256_set1_ps(x[2]);
  const std::int16_t *b = a + ld, *c = b + ld;
  for (std::size_t i = 0; i < count; i += width) {
    const __m256 two = _mm256_add_ps(_mm256_mul_ps(widened(a + i), x0), _mm256_mul_ps(widened(b + i), x1));
    const __m256 all = _mm256_add_ps(two, _mm256_mul_ps(widened(c + i), x2));
    _mm256_storeu_ps(y + i, _mm256_sub_ps(_mm256_loadu_ps(y + i), all));
  }
}

[[gnu::target("avx2"), gnu::always_inline]] inline float sum_of(__m256 first, __m256 second) {
  const __m256 eight = _mm256_add_ps(first, second);
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

[[gnu::target("avx2")]] void dot_wide(const std::int16_t* a, std::size_t ld, const float* x, std::size_t count,
                                      float* sums) {
  __m256 a0 = _mm256_setzero_ps(), a1 = a0, b0 = a0, b1 = a0, c0 = a0, c1 = a0;
  const std::int16_t *b = a + ld, *c = b + ld;
  for (std::size_t i = 0; i < count; i += 2 * width) {
    const __m256 x0 = _mm256_loadu_ps(x + i), x1 = _mm256_loadu_ps(x + i + width);
    a0 = _mm256_add_ps(a0, _mm256_mul_ps(widened(a + i), x0));
    a1 = _mm256_add_ps(a1, _mm256_mul_ps(widened(a + i + width), x1));
    b0 = _mm256_add_ps(b0, _mm256_mul_ps(widened(b + i), x0));
    b1 = _mm256_add_ps(b1, _mm256_mul_ps(widened(b + i + width), x1));
    c0 = _mm256_add_ps(c0, _mm256_mul_ps(widened(c + i), x0));
    c1 = _mm256_add_ps(c1, _mm256_mul_ps(widened(c + i + width), x1));
  }
  sums[0] = sum_of(a0, a1);
  sums[1] = sum_of(b0, b1);
  sums[2] = sum_of(c0, c1);
}

const bool is_wide = __builtin_cpu_supports("avx2") != 0;
const auto subtract_three = is_wide ? subtract_wide : subtract_plain;
const auto dot_three = is_wide ? dot_wide : dot_plain;
#else
constexpr auto subtract_three = subtract_plain;
constexpr auto dot_three = dot_plain;
#endif

}  // namespace

CompactFactor::CompactFactor(const SparseFactor& factor)
    : pattern_(factor.shared_pattern()),
      values_(Buffer::recycled((pattern_->panel_start.back() + 2 * slack) / 4)),
      diagonal_(pattern_->vertices()) {
  auto* const values = reinterpret_cast<std::int16_t*>(values_.data());
  std::fill_n(values + pattern_->panel_start.back(), slack, std::int16_t{0});
  for (std::size_t s = 0; s < pattern_->supernodes(); ++s) {
    const std::size_t own = 3 * pattern_->own(s), ld = own + 3 * pattern_->below(s);
    const double* panel = factor.panel(s);
    std::int16_t* to = values + pattern_->panel_start[s];
    for (std::size_t j = 0; j < own; ++j) {
      const double* column = panel + j * ld;
      Diagonal& diagonal = diagonal_[pattern_->super_start[s] + j / 3];
      const std::size_t first = 3 * (j / 3), c = j % 3;
      diagonal.inverse[c] = static_cast<float>(1 / column[j]);
      if (c == 0) diagonal.below[0] = static_cast<float>(column[first + 1]);
      if (c < 2) diagonal.below[1 + c] = static_cast<float>(column[first + 2]);
      double most = 0;
      for (std::size_t i = first + 3; i < ld; ++i) most = std::max(most, std::abs(column[i]));
      diagonal.scale[c] = static_cast<float>(most / 32767);
      const double inverse = most > 0 ? 32767 / most : 0;
      for (std::size_t i = first + 3; i < ld; ++i)
        to[j * ld + i] = static_cast<std::int16_t>(column[i] * inverse + (column[i] > 0 ? 0.5 : -0.5));
    }
  }
}

void CompactFactor::eliminate(std::size_t s, float* x, float* work) const {
  const FactorPattern& f = *pattern_;
  const std::size_t own = 3 * f.own(s), below = 3 * f.below(s), ld = own + below;
  const std::int16_t* values = panel(s);
  float* mine = x + 3 * std::size_t{f.super_start[s]};
  std::copy_n(mine, own, work);
  std::fill_n(work + own, below, 0.0F);
  for (std::size_t j = 0; j < own; j += 3) {  // a vertex at a time
    const Diagonal& d = diagonal_[f.super_start[s] + j / 3];
    float* y = work + j;
    y[0] *= d.inverse[0];
    y[1] = (y[1] - d.below[0] * y[0]) * d.inverse[1];
    y[2] = (y[2] - d.below[1] * y[0] - d.below[2] * y[1]) * d.inverse[2];
    const float scaled[3] = {d.scale[0] * y[0], d.scale[1] * y[1], d.scale[2] * y[2]};
    subtract_three(y + 3, values + j * ld + j + 3, ld, scaled, ld - j - 3);
  }
  std::copy_n(work, own, mine);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) x[3 * std::size_t{rows[i]} + a] += work[own + 3 * i + a];
}

void CompactFactor::substitute(std::size_t s, float* x, float* work) const {
  const FactorPattern& f = *pattern_;
  const std::size_t own = 3 * f.own(s), ld = own + 3 * f.below(s);
  const std::int16_t* values = panel(s);
  float* mine = x + 3 * std::size_t{f.super_start[s]};
  std::copy_n(mine, own, work);
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) work[own + 3 * i + a] = x[3 * std::size_t{rows[i]} + a];
  std::fill_n(work + ld, slack, 0.0F);
  for (std::size_t j = own; j > 0;) {
    j -= 3;
    const Diagonal& d = diagonal_[f.super_start[s] + j / 3];
    float* y = work + j;
    float sums[3];
    dot_three(values + j * ld + j + 3, ld, y + 3, ld - j - 3, sums);
    y[2] = (y[2] - d.scale[2] * sums[2]) * d.inverse[2];
    y[1] = (y[1] - d.scale[1] * sums[1] - d.below[2] * y[2]) * d.inverse[1];
    y[0] = (y[0] - d.scale[0] * sums[0] - d.below[0] * y[1] - d.below[1] * y[2]) * d.inverse[0];
  }
  std::copy_n(work, own, mine);
}

}  // namespace calot
