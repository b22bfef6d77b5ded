#include "calot/compliance/path_solve.h"

#include <cstring>

#include "calot/base/wide.h"

namespace calot::detail {
namespace {

template <class Real>
struct Wide;
template <>
struct Wide<float> {
  typedef float Lanes __attribute__((vector_size(32)));
};
template <>
struct Wide<double> {
  typedef double Lanes __attribute__((vector_size(32)));
};

template <class Real>
[[gnu::always_inline]] inline void subtract(Real* __restrict y, const Real* __restrict a, std::size_t ld, const Real* x,
                                            std::size_t count) {
  const Real x0 = x[0], x1 = x[1], x2 = x[2];
  const Real *a0 = a, *a1 = a + ld, *a2 = a + 2 * ld;
  for (std::size_t i = 0; i < count; ++i) y[i] -= a0[i] * x0 + a1[i] * x1 + a2[i] * x2;
}

// Two groups of lanes a column, so that additions don't wait for each other.
template <class Real>
[[gnu::always_inline]] inline void dot(const Real* a, std::size_t ld, const Real* x, std::size_t count, Real* sums) {
  using Lanes = typename Wide<Real>::Lanes;
  constexpr std::size_t width = sizeof(Lanes) / sizeof(Real);
  Lanes sum[3][2] = {};
  std::size_t i = 0;
  for (; i + 2 * width <= count; i += 2 * width)
    for (std::size_t half = 0; half < 2; ++half) {
      Lanes factor;
      std::memcpy(&factor, x + i + half * width, sizeof factor);
      for (std::size_t c = 0; c < 3; ++c) {
        Lanes column;
        std::memcpy(&column, a + c * ld + i + half * width, sizeof column);
        sum[c][half] += column * factor;
      }
    }
  for (std::size_t c = 0; c < 3; ++c) {
    Lanes both = sum[c][0] + sum[c][1];
    Real total = 0;
    for (std::size_t l = 0; l < width / 2; ++l) total += both[l] + both[l + width / 2];
    for (std::size_t k = i; k < count; ++k) total += a[c * ld + k] * x[k];
    sums[c] = total;
  }
}

}  // namespace

std::vector<std::uint32_t> elimination_path(const FactorPattern& f, std::span<const std::uint32_t> positions) {
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

CALOT_WIDE void subtract_three(float* y, const float* a, std::size_t ld, const float* x, std::size_t count) {
  subtract(y, a, ld, x, count);
}

CALOT_WIDE void subtract_three(double* y, const double* a, std::size_t ld, const double* x, std::size_t count) {
  subtract(y, a, ld, x, count);
}

CALOT_WIDE void dot_three(const float* a, std::size_t ld, const float* x, std::size_t count, float* sums) {
  dot(a, ld, x, count, sums);
}

CALOT_WIDE void dot_three(const double* a, std::size_t ld, const double* x, std::size_t count, double* sums) {
  dot(a, ld, x, count, sums);
}

}  // namespace calot::detail
