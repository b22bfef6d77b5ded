#include "calot/picture/shading.h"

#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

double soft_lambert(const Vec3& normal, const Vec3& light) {
  return std::max(0.0, (normal.dot(light) + 0.2) / 1.2);
}

double power(double x, int exponent) {
  double result = 1;
  for (; exponent > 0; exponent /= 2, x *= x)
    if (exponent % 2 == 1) result *= x;
  return result;
}

}  // namespace

Vec3 shade(const SurfacePoint& point, const Camera& camera) {
  const Vec3 to_eye = (camera.eye - point.position).normalized();
  const double facing = point.normal.dot(to_eye);
  const Vec3 normal = facing < 0 ? Vec3(-point.normal) : point.normal;  // the inside, seen through an opening
  const double turned = 1 - std::abs(facing);
  const Vec3 key = (-0.50 * camera.right + 0.62 * camera.up - 0.60 * camera.forward).normalized();
  const Vec3 fill = (0.85 * camera.right - 0.05 * camera.up - 0.52 * camera.forward).normalized();
  const double sky = 0.5 + 0.5 * normal.dot(camera.up);
  const double even = point.mapped ? 0.35 : 0.0;  // values must stay readable in the shade
  double light =
      even + (1 - even) * (0.16 + 0.17 * sky + 0.78 * soft_lambert(normal, key) + 0.22 * soft_lambert(normal, fill));
  light *= 1 - 0.45 * power(turned, 3);
  if (facing < 0) light *= 0.55;
  const double gloss = point.mapped ? 0.04 : 0.16;
  const double spark = std::max(0.0, normal.dot((key + to_eye).normalized()));
  const double sheen = gloss * (power(spark, 48) + 0.25 * power(spark, 10));
  return light * point.albedo + Vec3::Constant(sheen);
}

}  // namespace calot::detail
