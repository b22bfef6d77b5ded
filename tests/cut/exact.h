// The truth about sides, in rational numbers.
#pragma once
#include <boost/multiprecision/cpp_int.hpp>

#include "calot/mesh/tet_mesh.h"

namespace calot::test {

inline int rational_side(const Vec3& x, const Vec3& p, const Vec3& n) {
  using boost::multiprecision::cpp_rational;
  cpp_rational sum = 0;
  for (int axis = 0; axis < 3; ++axis) sum += (cpp_rational(x[axis]) - cpp_rational(p[axis])) * cpp_rational(n[axis]);
  return sum.sign();
}

}  // namespace calot::test
