#include "calot/picture/color.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

Vec3 linear_of_oklab(double lightness, double a, double b) {
  const auto cube = [](double x) { return x * x * x; };
  const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
  const Vec3 rgb{4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                 -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                 -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
  return rgb.cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace

Vec3 linear_of(const Vec3& srgb) {
  return srgb.unaryExpr([](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); });
}

Vec3 srgb_of(const Vec3& linear) {
  return linear.unaryExpr([](double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055; });
}

Vec3 colormap(double t) {
  t = std::clamp(t, 0.0, 1.0);
  const double lightness = 0.28 + 0.65 * t;
  const double hue = (285 - 180 * t) * std::numbers::pi / 180;
  const double chroma = 0.105 + 0.055 * t;
  return linear_of_oklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
}

}  // namespace calot::detail
