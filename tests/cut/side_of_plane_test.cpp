#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "calot/cut/cut.h"
#include "tests/cut/exact.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

Vec3 random_vector(Random& random) {
  return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
}

TEST(SideOfPlane, AgreesWithRationalArithmetic) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = random_vector(random), p = random_vector(random), n = random_vector(random);
    EXPECT_EQ(side_of_plane(x, p, n), rational_side(x, p, n));
  }
}

// A point computed to lie in the plane misses it by rounding; the sign must be that of the doubles.
TEST(SideOfPlane, DecidesWhatRoundingHides) {
  Random random(2);
  int zeros = 0, both = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random_vector(random), n = random_vector(random);
    const Vec3 u = n.cross(random_vector(random));
    const Vec3 x = p + u * random.between(-1, 1);
    const int side = side_of_plane(x, p, n);
    EXPECT_EQ(side, rational_side(x, p, n));
    zeros += side == 0 ? 1 : 0;
    both |= side > 0 ? 1 : side < 0 ? 2 : 0;
  }
  EXPECT_EQ(both, 3);
  EXPECT_LT(zeros, 200);
}

TEST(SideOfPlane, NextDoubleIsOnTheOtherSide) {
  const Vec3 p(0.1, 0.2, 0.3), n(1, 0, 0);
  EXPECT_EQ(side_of_plane(p, p, n), 0);
  EXPECT_EQ(side_of_plane({std::nextafter(0.1, 1), 5, -7}, p, n), 1);
  EXPECT_EQ(side_of_plane({std::nextafter(0.1, 0), 5, -7}, p, n), -1);
}

TEST(SideOfPlane, AnyMagnitude) {
  const double tiny = std::numeric_limits<double>::denorm_min(), huge = std::numeric_limits<double>::max();
  const double values[] = {0, tiny, -tiny, 3e-310, 1e-300, -1e-160, 1, -1e10, 1e160, -1e300, huge, -huge};
  const std::size_t count = std::size(values);
  Random random(3);
  const auto pick = [&] {
    return Vec3(values[random.below(count)], values[random.below(count)], values[random.below(count)]);
  };
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x = pick(), p = pick(), n = pick();
    EXPECT_EQ(side_of_plane(x, p, n), rational_side(x, p, n))
        << x.transpose() << " | " << p.transpose() << " | " << n.transpose();
  }
}

TEST(SideOfPlane, LengthOfTheNormalDoesNotMatter) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = random_vector(random), p = random_vector(random), n = random_vector(random);
    EXPECT_EQ(side_of_plane(x, p, n), side_of_plane(x, p, n * 0x1p-500));
    EXPECT_EQ(side_of_plane(x, p, n), -side_of_plane(x, p, n * -0x1p900));
  }
}

}  // namespace
}  // namespace calot::test
