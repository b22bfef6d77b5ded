// Drops in flight: they fall, land on tissue or what is still, and splash a little.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/view/effects/surface_fluid.h"

namespace calot::detail {
namespace {

constexpr float longest_flight = 2;        // [s]
constexpr float splashing_speed = 0.6F;    // [m/s]
constexpr double splashing_volume = 3e-9;  // [m³]

float radius_of(double volume) {
  return static_cast<float>(std::cbrt(3 * volume / (4 * std::numbers::pi)));
}

}  // namespace

void SurfaceFluid::drip(const Place& place, Fluid fluid, double volume, float depth) {
  Drop drop;
  drop.position = position(place) + (depth + radius_of(volume)) * down_;
  drop.volume = volume;
  drop.fluid = fluid;
  add_drop(drop);
}

/// Beyond the limit, it joins the oldest of its kind.
void SurfaceFluid::add_drop(Drop drop) {
  if (drops_.size() < options_.drops) {
    drops_.push_back(drop);
    return;
  }
  for (Drop& other : drops_)
    if (other.fluid == drop.fluid) {
      other.volume += drop.volume;
      return;
    }
  ledger(drop.fluid).gone += drop.volume;
}

void SurfaceFluid::fall(double dt) {
  const auto h = static_cast<float>(dt);
  const std::size_t flying = drops_.size();  // those that a splash throws up begin with the next step
  for (std::size_t i = 0; i < flying; ++i) {
    Drop drop = drops_[i];
    const Vec3f from = drop.position;
    drop.age += h;
    drop.velocity += h * gravity_;
    drop.position += h * drop.velocity;
    const bool lost = !drop.position.allFinite() || drop.position.dot(down_) > floor_ || drop.age > longest_flight;
    drops_[i] = drop;
    if (lost) {
      ledger(drop.fluid).gone += drop.volume;
      drops_[i].volume = 0;
      continue;
    }
    for (const bool still : {false, true}) {
      const auto seat = sheets_[still ? 1 : 0].hit(from, drop.position, still);
      if (!seat || !land(drop, {still, *seat})) continue;
      drops_[i].volume = 0;
      break;
    }
  }
  std::erase_if(drops_, [](const Drop& drop) { return !(drop.volume > 0); });
}

bool SurfaceFluid::land(const Drop& drop, const Place& place) {
  const Sheet& here = sheet(place);
  Vec3f normal = here.normal(place.seat.triangle);
  if (normal.dot(drop.velocity) > 0) normal = -normal;
  Parcel parcel;
  parcel.place = place;
  parcel.fluid = drop.fluid;
  parcel.volume = drop.volume;
  parcel.velocity = 0.3F * (drop.velocity - normal * normal.dot(drop.velocity));
  const float speed = -normal.dot(drop.velocity);
  if (speed > splashing_speed && drop.volume > splashing_volume && drops_.size() + 3 <= options_.drops) {
    splash(drop, position(place), normal);
    parcel.volume *= 1 - 3 * 0.02;
  }
  add_parcel(parcel);
  return true;
}

/// Three small drops that fly on, with a fiftieth of it each.
void SurfaceFluid::splash(const Drop& drop, const Vec3f& at, const Vec3f& normal) {
  for (int k = 0; k < 3; ++k) {
    Drop small;
    small.fluid = drop.fluid;
    small.volume = 0.02 * drop.volume;
    const Vec3f thrown = random_.in_ball();
    small.velocity = drop.velocity.norm() * (0.2F * normal + 0.25F * (thrown - normal * normal.dot(thrown)));
    small.position = at + 0.3e-3F * normal;
    drops_.push_back(small);
  }
}

}  // namespace calot::detail
