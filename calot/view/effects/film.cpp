#include "calot/view/effects/film.h"

#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

constexpr double earth = 9.81;         // [m/s²]
constexpr double falling_share = 0.6;  // of a hanging drop; the rest stays at the neck

}  // namespace

double film_time(const Liquid& liquid, double thickness) {
  return liquid.density * thickness * thickness / (3 * liquid.viscosity);
}

double film_speed(const Liquid& liquid, double thickness, double acceleration) {
  return film_time(liquid, thickness) * acceleration;
}

double LensShape::mean_thickness(double volume) const {
  return radius > 0 ? volume / (std::numbers::pi * radius * radius) : 0;
}

LensShape lens_shape(const Liquid& liquid, double volume, double angle) {
  if (!(volume > 0)) return {};
  const double slope = std::tan(angle / 2);  // depth of a cap by its radius
  const double deepest = 2 * std::sqrt(liquid.tension / (liquid.density * earth)) * std::sin(angle / 2);
  const double radius = std::cbrt(6 * volume / (std::numbers::pi * slope * (3 + slope * slope)));
  if (radius * slope <= deepest) return {radius, radius * slope};
  return {std::sqrt((6 * volume / (std::numbers::pi * deepest) - deepest * deepest) / 3), deepest};
}

double holding_force(const Liquid& liquid, double radius, double share) {
  return share * liquid.tension * 2 * radius;
}

double drip_volume(const Liquid& liquid, double neck_radius) {
  return falling_share * 2 * std::numbers::pi * neck_radius * liquid.tension / (liquid.density * earth);
}

}  // namespace calot::detail
