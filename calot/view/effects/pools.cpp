// Lenses of blood and bile: wells, pools in hollows, and what hangs under an overhang.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/view/effects/surface_fluid.h"

namespace calot::detail {
namespace {

constexpr float down_facing = 0.25F;
constexpr double neck = 1.5e-3;            // of what hangs [m]; assumed
constexpr float redraped_after = 25;       // steps: the surface bends meanwhile
constexpr double smallest_spill = 0.4e-9;  // [m³]

}  // namespace

void SurfaceFluid::add_pool(const Place& place, Fluid fluid, double volume) {
  if (!usable(place)) {
    film_.absorb(fluid, volume);
    return;
  }
  const Vec3f here = position(place);
  const auto own = static_cast<float>(shape(volume, fluid, 1).radius);
  Lens* nearest = nullptr;
  float least = 1e30F;
  for (Lens& pool : pools_) {
    if (pool.fluid != fluid) continue;
    const float gap = (position(pool.place) - here).norm() - pool.radius - 0.7F * own;
    if (!(gap < least)) continue;
    least = gap;
    nearest = &pool;
  }
  if (nearest != nullptr && (least < 0 || pools_.size() >= options_.pools)) {
    nearest->volume += volume;
    return;
  }
  if (pools_.size() >= options_.pools) {
    film_.absorb(fluid, volume);
    return;
  }
  Lens pool;
  pool.place = place;
  pool.fluid = fluid;
  pool.volume = volume;
  shape_lens(pool);
  pools_.push_back(pool);
}

/// Radius and depth of its volume; the ring is found anew once it has grown or the surface may have bent.
void SurfaceFluid::shape_lens(Lens& lens) {
  const LensShape form = shape(lens.volume, lens.fluid, 1);
  lens.radius = static_cast<float>(form.radius);
  if (lens.draped == 0) lens.depth = static_cast<float>(form.depth);
  ++lens.since;
  const bool grown = std::abs(lens.radius - lens.draped) > 0.06F * lens.draped;
  if (grown || static_cast<float>(lens.since) > redraped_after) drape(lens);
}

/// Walks out on all sides, at most as far as the liquid would climb.
void SurfaceFluid::drape(Lens& lens) {
  lens.draped = std::max(lens.radius, 1e-6F);
  lens.since = 0;
  lens.steepest = 0;
  const Sheet& here = sheet(lens.place);
  const Vec3f middle = here.position(lens.place.seat), rest = here.rest(lens.place.seat);
  const Vec3f normal = here.normal(lens.place.seat.triangle), side = normal.unitOrthogonal(),
              other = normal.cross(side);
  float area = 0, before = 0, first = 0;
  for (std::size_t k = 0; k < Lens::rays; ++k) {
    const float angle = static_cast<float>(k) * static_cast<float>(2 * std::numbers::pi / Lens::rays);
    const Vec3f way = std::cos(angle) * side + std::sin(angle) * other;
    float far = lens.radius * (1 + 0.3F * value_noise(rest / 4e-3F + 1.3F * way, 23));
    Walked rim = walk(here, lens.place.seat, far * way);
    const float fall = (here.position(rim.seat) - middle).dot(down_);
    if (normal.dot(down_) < down_facing && -fall > 0.8F * lens.depth && lens.depth > 0) {
      far *= std::max(0.15F, std::sqrt(0.8F * lens.depth / -fall));
      rim = walk(here, lens.place.seat, far * way);
    }
    if (fall / lens.radius > lens.steepest) {
      lens.steepest = fall / lens.radius;
      lens.lowest = static_cast<std::uint32_t>(k);
    }
    lens.ring[k] = {lens.place.still, walk(here, lens.place.seat, 0.55F * far * way).seat};
    lens.ring[Lens::rays + k] = {lens.place.still, rim.seat};
    if (k == 0) first = far;
    if (k > 0) area += before * far;
    before = far;
  }
  area = (area + before * first) * 0.5F * static_cast<float>(std::sin(2 * std::numbers::pi / Lens::rays));
  // A bowl whose edge is as deep as a paraboloid's.
  if (area > 0) lens.depth = static_cast<float>(2 * lens.volume) / area;
}

/// What a pool on a slope, or one that has filled its hollow, lets go. @return whether it did
bool SurfaceFluid::spill(Lens& pool, double dt) {
  if (pool.draped == 0 || !(pool.steepest > 0.02F)) return false;
  const Place& over = pool.ring[Lens::rays + pool.lowest];
  if (!usable(over)) return false;
  const Liquid& what = liquid(pool.fluid);
  const double slope = static_cast<double>(pool.steepest) / std::hypot(1.0, static_cast<double>(pool.steepest));
  const Vec3f rest = sheet(over).rest(over.seat);
  const double wet = static_cast<double>(film_.film(rest, pool.fluid) * film_.wet(rest));
  const double held = holding_force(what, static_cast<double>(pool.radius), options_.retention) * (1 - 0.85 * wet);
  const double weight = what.density * static_cast<double>(gravity_.norm()) * slope;  // [N/m³]
  const double free = pool.volume - held / weight;
  if (!(free > smallest_spill)) return false;
  // As a film of the pool's depth over a weir of its radius, but in pieces that are worth a parcel.
  const double depth = static_cast<double>(pool.depth);
  const double most = static_cast<double>(pool.radius) * depth *
                      film_speed(what, depth, static_cast<double>(gravity_.norm()) * slope) * dt * 4;
  const double some = std::min(free, std::max(smallest_spill, most));
  if (parcels_.size() >= options_.parcels) return false;
  Parcel parcel;
  parcel.place = over;
  parcel.fluid = pool.fluid;
  parcel.volume = some;
  parcel.progress = 5e-3F;
  const Vec3f out = position(over) - position(pool.place);
  parcel.velocity = 5e-3F * out.normalized();
  add_parcel(parcel);
  pool.volume -= some;
  return true;
}

void SurfaceFluid::tend_pools(double dt) {
  for (std::size_t k = 0; k < pools_.size(); ++k) {
    Lens& pool = pools_[k];
    if (!usable(pool.place)) {
      film_.absorb(pool.fluid, pool.volume);
      pool.volume = 0;
      continue;
    }
    if (pool.fluid == Fluid::blood)
      pool.clot = std::min(1.0F, pool.clot + static_cast<float>(dt / options_.clotting_time));
    shape_lens(pool);
    const Sheet& here = sheet(pool.place);
    const Vec3f normal = here.normal(pool.place.seat.triangle);
    const double hanging = drip_volume(liquid(pool.fluid), neck);
    if (normal.dot(down_) > down_facing && pool.volume > hanging) {
      drip(pool.place, pool.fluid, hanging, pool.depth);
      pool.volume -= hanging;
    }
    if ((k + steps_) % 4 != 0) continue;
    spill(pool, dt);
    if ((k + steps_) % 40 != 0) continue;
    const double thickness = 60e-6;
    pool.volume -= film_.lay(
        pool.fluid,
        {here.rest(pool.place.seat), here.rest_normal(pool.place.seat.triangle), std::min(0.9F * pool.radius, 8e-3F)},
        thickness, pool.volume);
  }
  // Less than a lens: what stays is a film.
  for (Lens& pool : pools_) {
    if (pool.volume >= 0.3e-9) continue;
    film_.absorb(pool.fluid, pool.volume);
    pool.volume = 0;
  }
  std::erase_if(pools_, [](const Lens& pool) { return !(pool.volume > 0); });
}

}  // namespace calot::detail
