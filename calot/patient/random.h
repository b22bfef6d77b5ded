// Random numbers that are the same on every machine and compiler: std::'s distributions are not.
#pragma once
#include <cstdint>

namespace calot {

/// Scrambles a number (SplitMix64's finaliser); random(seed, n) is a stream that can be entered anywhere.
constexpr std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// A stream of numbers from a seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(scramble(seed)) {}
  std::uint64_t next() { return scramble(state_ += 0x9e3779b97f4a7c15u); }
  /// Uniform in [low, high).
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53;
  }
  /// Mean 0, deviation 1, within ±6: the sum of twelve uniform numbers, so that no library function is involved.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  /// The same from a quarter of the numbers: twelve of 16 bits each, in steps of 1/65536.
  double quick_normal() {
    std::uint64_t sum = 0;
    for (int i = 0; i < 3; ++i)
      for (std::uint64_t bits = next(), part = 0; part < 4; ++part, bits >>= 16) sum += bits & 0xffff;
    return static_cast<double>(sum + 6) * 0x1p-16 - 6;
  }

 private:
  std::uint64_t state_;
};

}  // namespace calot
