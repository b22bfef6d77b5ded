#include "calot/fem/element.h"

#include <Eigen/Geometry>

namespace calot {

Lame lame(const Material& material) {
  const double e = material.young, nu = material.poisson;
  return {e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
}

TetShape tet_shape(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const Vec3 normal_b = ac.cross(ad), normal_c = ad.cross(ab), normal_d = ab.cross(ac);
  const double six_volumes = ab.dot(normal_b);
  TetShape shape;
  shape.gradient[1] = normal_b / six_volumes;
  shape.gradient[2] = normal_c / six_volumes;
  shape.gradient[3] = normal_d / six_volumes;
  shape.gradient[0] = -(shape.gradient[1] + shape.gradient[2] + shape.gradient[3]);
  shape.volume = six_volumes / 6;
  return shape;
}

Eigen::Matrix<double, 12, 12> stiffness(const TetShape& shape, const Lame& lame) {
  Eigen::Matrix<double, 12, 12> k;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) k.block<3, 3>(3 * a, 3 * b) = stiffness_block(shape, lame, a, b);
  return k;
}

}  // namespace calot
