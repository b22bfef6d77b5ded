#include "calot/sim/instrument.h"

#include <gtest/gtest.h>

namespace calot {
namespace {

TEST(Articulate, OpensBothJawsByHalfTheAngle) {
  const ArticulatedPoses poses = articulate({}, 0.6);
  const Vec3 a = poses.jaw_a * Vec3(0, 0, 0.02), b = poses.jaw_b * Vec3(0, 0, 0.02);
  EXPECT_NEAR(std::acos(a.dot(b) / (a.norm() * b.norm())), 0.6, 1e-12);
  EXPECT_EQ(poses.shaft * Vec3(1, 2, 3), Vec3(1, 2, 3));
}

}  // namespace
}  // namespace calot
