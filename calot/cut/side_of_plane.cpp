// The exact sign of (x − p)·n: a floating-point filter, then fixed-point arithmetic wide enough for any double.
#include <array>
#include <cmath>
#include <cstdint>

#include "calot/cut/cut.h"

namespace calot {
namespace {

/// A sum of products of doubles without any rounding, underflow or overflow: one binary number with a digit for every
/// bit from 2^-2148 (the square of the smallest double) to 2^2048, in limbs of 32 bits. Source: [Kulisch2002].
class ExactSum {
 public:
  /// Adds sign·a·b for finite a, b.
  void add_product(double a, double b, int sign) {
    if (a == 0 || b == 0) return;
    const Split u = split(a), v = split(b);
    const std::int64_t signum = u.negative == v.negative ? sign : -sign;
    const int bit = u.exponent + v.exponent - lowest_exponent;
    add(u.low * v.low, bit, signum);
    add(u.low * v.high, bit + 32, signum);
    add(u.high * v.low, bit + 32, signum);
    add(u.high * v.high, bit + 64, signum);
  }
  [[nodiscard]] int sign() {
    bool zero = true;
    for (std::size_t k = 0; k + 1 < limbs_.size(); ++k) {
      const std::int64_t carry = limbs_[k] >> 32;  // rounds down, so that what stays is ≥ 0
      limbs_[k] -= carry * (std::int64_t{1} << 32);
      limbs_[k + 1] += carry;
      zero = zero && limbs_[k] == 0;
    }
    if (limbs_.back() != 0) return limbs_.back() < 0 ? -1 : 1;
    return zero ? 0 : 1;
  }

 private:
  static constexpr int lowest_exponent = -2148;
  // |value| = (high·2^32 + low)·2^exponent, a whole number of 53 bits.
  struct Split {
    std::uint64_t high, low;
    int exponent;
    bool negative;
  };
  static Split split(double value) {
    int exponent = 0;
    const double fraction = std::frexp(std::abs(value), &exponent);
    auto whole = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
    exponent -= 53;
    // A subnormal's last bits are zero: move them out, so that no exponent falls below -1074.
    for (; exponent < -1074; ++exponent) whole >>= 1;
    return {whole >> 32, whole & 0xffffffffu, exponent, std::signbit(value)};
  }
  void add(std::uint64_t value, int bit, std::int64_t sign) {
    const auto limb = static_cast<std::size_t>(bit / 32);
    const int shift = bit % 32;
    constexpr std::uint64_t mask = 0xffffffffu;
    limbs_[limb] += sign * static_cast<std::int64_t>((value << shift) & mask);
    limbs_[limb + 1] += sign * static_cast<std::int64_t>((value >> (32 - shift)) & mask);
    if (shift > 0) limbs_[limb + 2] += sign * static_cast<std::int64_t>(value >> (64 - shift));
  }

  std::array<std::int64_t, (2148 + 2048) / 32 + 6> limbs_{};
};

int exact_side(const Vec3& x, const Vec3& p, const Vec3& n) {
  ExactSum sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum.add_product(x[axis], n[axis], 1);
    sum.add_product(p[axis], n[axis], -1);
  }
  return sum.sign();
}

}  // namespace

int side_of_plane(const Vec3& x, const Vec3& p, const Vec3& n) {
  const Vec3 product = (x - p).cwiseProduct(n);
  const double value = product[0] + product[1] + product[2];
  const double size = std::abs(product[0]) + std::abs(product[1]) + std::abs(product[2]);
  // One rounding in each difference, one in each product, two in the sum: below 4.1 · 2^-53 · size; the constant covers
  // products that underflow. An overflow makes the comparison false.
  if (std::abs(value) > 1e-15 * size + 1e-300) return value > 0 ? 1 : -1;
  return exact_side(x, p, n);
}

}  // namespace calot
