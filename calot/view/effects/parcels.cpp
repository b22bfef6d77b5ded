// Blood and bile on their way down a surface.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/view/effects/surface_fluid.h"

namespace calot::detail {
namespace {

constexpr float down_facing = 0.25F;   // of a normal along gravity: what is there hangs
constexpr double neck = 1.5e-3;        // of what hangs [m]; assumed
constexpr float resting = 0.5e-3F;     // progress below which it rests [m/s]
constexpr float settling_time = 0.6F;  // [s]
constexpr double pool_from = 1.5e-9;   // less stays a film [m³]
constexpr float soaking_time = 12;     // what rests and is less dries to a film [s]

}  // namespace

void SurfaceFluid::run(double dt) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < parcels_.size(); ++i)
    if (run(parcels_[i], dt)) parcels_[kept++] = parcels_[i];
  parcels_.resize(kept);
}

/// Which way is down, turned a little by the roughness of the surface and towards what is wet already.
Vec3f SurfaceFluid::heading(const Parcel& parcel, const Vec3f& down, const Vec3f& normal) const {
  const Sheet& here = sheet(parcel.place);
  const Vec3f rest = here.rest(parcel.place.seat), side = normal.cross(down);
  const float grain = value_noise(rest / 4e-3F, 3) + 0.5F * value_noise(rest / 1.7e-3F, 5);
  // The side in the rest shape: near enough to that in the world for a few tenths of a millimetre.
  const Vec3f ahead = rest + 1.2e-3F * down;
  const float right = film_.film(ahead + 1.1e-3F * side, parcel.fluid),
              left = film_.film(ahead - 1.1e-3F * side, parcel.fluid);
  // One in sixteen leaves the beaten track.
  const std::uint32_t word = mix3(parcel.id, 17, 0)[0];
  const float fork = (static_cast<float>(word) * 4.6566129e-10F - 1) * (word % 16 == 0 ? 0.8F : 0.1F);
  const float angle = std::clamp(0.55F * grain + 0.7F * (right - left) + fork, -0.9F, 0.9F);
  return std::cos(angle) * down + std::sin(angle) * side;
}

/// @return false once nothing is left of it here
bool SurfaceFluid::run(Parcel& parcel, double dt) {
  if (!usable(parcel.place)) return true;  // until the next skin, or until it settles
  parcel.age += static_cast<float>(dt);
  const Sheet& here = sheet(parcel.place);
  const Liquid& what = liquid(parcel.fluid);
  const Vec3f normal = here.normal(parcel.place.seat.triangle), rest = here.rest(parcel.place.seat);
  const float wet = film_.film(rest, parcel.fluid) * film_.wet(rest);
  const LensShape form = shape(parcel.volume, parcel.fluid, wet);
  const double thickness = form.mean_thickness(parcel.volume);
  if (normal.dot(down_) > down_facing && parcel.volume > drip_volume(what, neck)) {
    drip(parcel.place, parcel.fluid, parcel.volume, static_cast<float>(form.depth));
    return false;
  }
  const Vec3f pull = gravity_ - normal * normal.dot(gravity_);
  const double slope = static_cast<double>(pull.norm());
  const double held = holding_force(what, form.radius, options_.retention) * (1 - 0.85 * static_cast<double>(wet));
  const double drive = std::max(0.0, slope - held / (what.density * parcel.volume));
  const Vec3f way = slope > 1e-3 ? heading(parcel, pull.normalized(), normal) : Vec3f::Zero();
  const Vec3f goal = way * static_cast<float>(film_speed(what, thickness, drive));
  const auto relax = static_cast<float>(std::exp(-dt / std::max(film_time(what, thickness), 1e-9)));
  const Vec3f along = parcel.velocity - normal * normal.dot(parcel.velocity);
  const Vec3f velocity = goal + relax * (along - goal);
  // The mean speed over the step, exactly, from the same relaxation.
  const auto time = static_cast<float>(film_time(what, thickness));
  const Vec3f way_gone = goal * static_cast<float>(dt) + (along - goal) * (time * (1 - relax));
  const Vec3f before = here.position(parcel.place.seat);
  const Walked to = walk(here, parcel.place.seat, way_gone.norm() > 0.03F ? 0.03F * way_gone.normalized() : way_gone);
  parcel.place.seat = to.seat;
  parcel.velocity = to.blocked ? Vec3f::Zero() : Vec3f(velocity.norm() * to.direction);
  const float fallen = (here.position(to.seat) - before).dot(down_) / static_cast<float>(dt);
  parcel.progress += (fallen - parcel.progress) * std::min(1.0F, static_cast<float>(dt) / 0.25F);
  if (to.blocked && slope > 3 && parcel.volume > 0.2 * drip_volume(what, neck)) {  // over the border
    drip(parcel.place, parcel.fluid, parcel.volume, static_cast<float>(form.depth));
    return false;
  }
  lay_film(parcel, thickness, static_cast<float>(form.radius));
  return parcel.volume > 0;
}

void SurfaceFluid::lay_film(Parcel& parcel, double thickness, float radius) {
  const Sheet& here = sheet(parcel.place);
  const Vec3f rest = here.rest(parcel.place.seat);
  if ((rest - parcel.laid).norm() < 0.4F * film_.mask().voxel()) return;
  // A fast one has gone farther than its spot is wide: spots between, so that it draws a line.
  const float gap = (rest - parcel.laid).norm(), stride = std::max(0.5F * radius, 0.5F * film_.mask().voxel());
  const int spots = gap < 30e-3F ? std::clamp(static_cast<int>(gap / stride), 1, 16) : 1;
  const Vec3f normal = here.rest_normal(parcel.place.seat.triangle);
  const double left = std::max(12e-6, options_.left_behind * thickness);
  for (int k = 1; k <= spots; ++k) {
    const float share = static_cast<float>(k) / static_cast<float>(spots);
    const Vec3f spot = spots == 1 ? rest : Vec3f(parcel.laid + share * (rest - parcel.laid));
    const double available = options_.left_behind > 0 ? parcel.volume : 0;
    parcel.volume -= film_.lay(parcel.fluid, {spot, normal, std::min(0.55F * radius, 4e-3F)}, left, available);
  }
  parcel.laid = rest;
  if (parcel.volume < 0.02e-9) {
    film_.absorb(parcel.fluid, parcel.volume);
    parcel.volume = 0;
  }
}

/// What runs joins what rests before it.
void SurfaceFluid::join_resting() {
  constexpr std::size_t slots = 4096;
  constexpr float cell = 2.5e-3F;
  std::vector<std::uint32_t> first(slots, no_triangle), next(parcels_.size(), no_triangle);
  const auto slot_of = [&](const Vec3f& p, int dx, int dy, int dz) {
    const auto word = [&](float x, int d) {
      return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x / cell)) + d);
    };
    return mix3(word(p[0], dx), word(p[1], dy), word(p[2], dz))[0] % slots;
  };
  std::vector<Vec3f> at(parcels_.size());
  for (std::uint32_t i = 0; i < parcels_.size(); ++i) {
    at[i] = position(parcels_[i].place);
    if (!at[i].allFinite()) continue;
    if (std::abs(parcels_[i].progress) > resting || parcels_[i].age < 0.2F) continue;
    const std::size_t slot = slot_of(at[i], 0, 0, 0);
    next[i] = first[slot];
    first[slot] = i;
  }
  for (std::uint32_t i = 0; i < parcels_.size(); ++i) {
    Parcel& runner = parcels_[i];
    if (!at[i].allFinite() || (i + steps_) % 2 != 0) continue;
    for (int n = 0; n < 8 && runner.volume > 0; ++n) {
      // The cell it is in and those on its nearer sides.
      std::array<int, 3> d{};
      for (std::size_t k = 0; k < 3; ++k) {
        const float x = at[i][static_cast<int>(k)] / cell;
        if (((n >> k) & 1) != 0) d[k] = x - std::floor(x) < 0.5F ? -1 : 1;
      }
      for (std::uint32_t j = first[slot_of(at[i], d[0], d[1], d[2])]; j != no_triangle; j = next[j]) {
        Parcel& rester = parcels_[j];
        if (j == i || rester.fluid != runner.fluid || rester.place.still != runner.place.still || !(rester.volume > 0))
          continue;
        const double reach = 0.8 * shape(std::max(runner.volume, rester.volume), runner.fluid, 1).radius;
        if (!(static_cast<double>((at[i] - at[j]).norm()) < reach)) continue;
        const auto share = static_cast<float>(runner.volume / (runner.volume + rester.volume));
        rester.velocity = (1 - share) * rester.velocity + share * runner.velocity;
        rester.progress += share * (runner.progress - rester.progress);
        rester.volume += runner.volume;
        runner.volume = 0;
        break;
      }
    }
  }
  std::erase_if(parcels_, [](const Parcel& parcel) { return !(parcel.volume > 0); });
}

/// What has come to rest becomes a pool, or a film.
void SurfaceFluid::settle() {
  join_pools();
  for (Parcel& parcel : parcels_) {
    if (parcel.age < settling_time || std::abs(parcel.progress) > resting) continue;
    if (parcel.volume >= pool_from) {
      add_pool(parcel.place, parcel.fluid, parcel.volume);
      parcel.volume = 0;
    } else if (parcel.age > soaking_time) {
      film_.absorb(parcel.fluid, parcel.volume);
      parcel.volume = 0;
    }
  }
  std::erase_if(parcels_, [](const Parcel& parcel) { return !(parcel.volume > 0); });
}

void SurfaceFluid::join_pools() {
  if (pools_.empty()) return;
  std::vector<Vec3f> middles;
  for (const Lens& pool : pools_) middles.push_back(position(pool.place));
  for (Parcel& parcel : parcels_) {
    if ((parcel.id + steps_) % 4 != 0 || parcel.age < 0.03F) continue;
    const Vec3f here = position(parcel.place);
    for (std::size_t k = 0; k < pools_.size(); ++k) {
      Lens& pool = pools_[k];
      const Vec3f off = here - middles[k];
      if (pool.fluid != parcel.fluid || pool.place.still != parcel.place.still || !(off.norm() < 0.8F * pool.radius))
        continue;
      // What has just spilled over runs on.
      if (off.dot(down_) > 0.3F * pool.radius && parcel.velocity.dot(off) > 0 && pool.steepest > 0.3F) continue;
      pool.clot *= static_cast<float>(pool.volume / (pool.volume + parcel.volume));
      pool.volume += parcel.volume;
      parcel.volume = 0;
      break;
    }
  }
  std::erase_if(parcels_, [](const Parcel& parcel) { return !(parcel.volume > 0); });
}

}  // namespace calot::detail
