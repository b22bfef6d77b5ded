#include "calot/view/effects/noise.h"

#include <cmath>

namespace calot::detail {
namespace {

using Vec3f = Eigen::Vector3f;

constexpr float of_word = 1.0F / 4294967296.0F;

/// A lattice cell: the corner below, and how far p is in it with the fade 6t⁵ − 15t⁴ + 10t³ and its derivative.
struct Cell {
  std::array<std::int32_t, 3> corner;
  Vec3f fade, slope;
};

Cell cell_of(const Vec3f& p) {
  Cell cell{};
  for (int i = 0; i < 3; ++i) {
    const float x = std::isfinite(p[i]) ? std::fmod(p[i], 1e6F) : 0;
    const float below = std::floor(x), t = x - below;
    cell.corner[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(below);
    cell.fade[i] = t * t * t * (t * (t * 6 - 15) + 10);
    cell.slope[i] = 30 * t * t * (t * (t - 2) + 1);
  }
  return cell;
}

std::array<std::uint32_t, 3> corner_words(const Cell& cell, int k, std::uint32_t seed) {
  return mix3(static_cast<std::uint32_t>(cell.corner[0] + (k & 1)) + seed,
              static_cast<std::uint32_t>(cell.corner[1] + ((k >> 1) & 1)) + 0x9e3779b9U * seed,
              static_cast<std::uint32_t>(cell.corner[2] + ((k >> 2) & 1)));
}

}  // namespace

std::array<std::uint32_t, 3> mix3(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  x = x * 1664525U + 1013904223U;
  y = y * 1664525U + 1013904223U;
  z = z * 1664525U + 1013904223U;
  x += y * z;
  y += z * x;
  z += x * y;
  x ^= x >> 16U;
  y ^= y >> 16U;
  z ^= z >> 16U;
  x += y * z;
  y += z * x;
  z += x * y;
  return {x, y, z};
}

float RandomLine::unit() {
  const std::uint64_t n = count_++;
  const auto words = mix3(static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(n >> 32U) ^ 0x51ed270bU,
                          static_cast<std::uint32_t>(seed_ ^ (seed_ >> 32U)));
  return static_cast<float>(words[0] >> 8U) / 16777216.0F;
}

float RandomLine::symmetric() {
  return 2 * unit() - 1;
}

Vec3f RandomLine::in_ball() {
  for (;;) {
    const float x = symmetric(), y = symmetric(), z = symmetric();
    const Vec3f p(x, y, z);
    if (p.squaredNorm() <= 1) return p;
  }
}

float value_noise(const Vec3f& p, std::uint32_t seed) {
  const Cell cell = cell_of(p);
  float sum = 0;
  for (int k = 0; k < 8; ++k) {
    float weight = 1;
    for (int i = 0; i < 3; ++i) weight *= ((k >> i) & 1) != 0 ? cell.fade[i] : 1 - cell.fade[i];
    sum += weight * (static_cast<float>(corner_words(cell, k, seed)[0]) * 2 * of_word - 1);
  }
  return sum;
}

Vec3f curl_noise(const Vec3f& p, std::uint32_t seed) {
  const Cell cell = cell_of(p);
  Vec3f curl = Vec3f::Zero();
  for (int k = 0; k < 8; ++k) {
    Vec3f side, rise;  // of the weight in each direction
    for (int i = 0; i < 3; ++i) {
      const bool upper = ((k >> i) & 1) != 0;
      side[i] = upper ? cell.fade[i] : 1 - cell.fade[i];
      rise[i] = upper ? cell.slope[i] : -cell.slope[i];
    }
    const Vec3f gradient(rise[0] * side[1] * side[2], side[0] * rise[1] * side[2], side[0] * side[1] * rise[2]);
    const auto words = corner_words(cell, k, seed);
    const Vec3f potential(static_cast<float>(words[0]) * 2 * of_word - 1,
                          static_cast<float>(words[1]) * 2 * of_word - 1,
                          static_cast<float>(words[2]) * 2 * of_word - 1);
    curl += gradient.cross(potential);
  }
  return curl;
}

}  // namespace calot::detail
