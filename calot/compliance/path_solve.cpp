#include "calot/compliance/path_solve.h"

namespace calot::detail {

CALOT_WIDE void subtract_three(float* __restrict y, const float* __restrict a, std::size_t ld, const float* x,
                               std::size_t count) {
  const float x0 = x[0], x1 = x[1], x2 = x[2];
  const float *a0 = a, *a1 = a + ld, *a2 = a + 2 * ld;
  for (std::size_t i = 0; i < count; ++i) y[i] -= a0[i] * x0 + a1[i] * x1 + a2[i] * x2;
}

CALOT_WIDE void subtract_three(double* __restrict y, const double* __restrict a, std::size_t ld, const double* x,
                               std::size_t count) {
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  const double *a0 = a, *a1 = a + ld, *a2 = a + 2 * ld;
  for (std::size_t i = 0; i < count; ++i) y[i] -= a0[i] * x0 + a1[i] * x1 + a2[i] * x2;
}

CALOT_WIDE float interleaved_dot(const float* __restrict a, const float* __restrict x, std::size_t count) {
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

CALOT_WIDE double interleaved_dot(const double* __restrict a, const double* __restrict x, std::size_t count) {
  constexpr std::size_t width = 16;
  double sums[width] = {};
  std::size_t i = 0;
  for (; i + width <= count; i += width)
    for (std::size_t l = 0; l < width; ++l) sums[l] += a[i + l] * x[i + l];
  for (std::size_t l = 0; i < count; ++i, ++l) sums[l] += a[i] * x[i];
  for (std::size_t half = width / 2; half > 0; half /= 2)
    for (std::size_t l = 0; l < half; ++l) sums[l] += sums[l + half];
  return sums[0];
}

}  // namespace calot::detail
