// What a picture is told of blood and bile.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "calot/view/effects/surface_fluid.h"

namespace calot::detail {
namespace {

constexpr double smallest_seen = 0.2e-9;  // of a lens [m³]
constexpr float above = 30e-6F;           // so that a rim doesn't fight with the tissue for a pixel [m]

}  // namespace

void SurfaceFluid::tell(EffectsState& state) const {
  state.drops.clear();
  for (const Drop& drop : drops_) {
    DropState out;
    out.position = drop.position;
    out.velocity = drop.velocity;
    out.radius = static_cast<float>(std::cbrt(3 * drop.volume / (4 * std::numbers::pi)));
    out.fluid = drop.fluid;
    state.drops.push_back(out);
  }
  state.pools.clear();
  state.pool_vertices.clear();
  state.pool_indices.clear();
  for (const Source& source : sources_) tell(source.well, state);
  for (const Lens& pool : pools_) tell(pool, state);
  std::array<FluidLedger, 2> now = ledgers_;
  const auto of = [&](Fluid fluid) -> FluidLedger& { return now[fluid == Fluid::blood ? 0 : 1]; };
  for (const Source& source : sources_) of(source.well.fluid).wells += source.well.volume;
  for (const Parcel& parcel : parcels_) of(parcel.fluid).running += parcel.volume;
  for (const Lens& pool : pools_) of(pool.fluid).pooled += pool.volume;
  for (const Drop& drop : drops_) of(drop.fluid).flying += drop.volume;
  for (const Fluid fluid : {Fluid::blood, Fluid::bile}) of(fluid).film = film_.volume(fluid);
  state.blood = now[0];
  state.bile = now[1];
}

void SurfaceFluid::tell(const Lens& lens, EffectsState& state) const {
  if (lens.volume < smallest_seen || lens.draped == 0 || !usable(lens.place)) return;
  const Sheet& here = sheet(lens.place);
  PoolState pool;
  pool.position = here.position(lens.place.seat);
  pool.normal = here.normal(lens.place.seat.triangle);
  pool.radius = lens.radius;
  pool.depth = lens.depth;
  pool.volume = static_cast<float>(lens.volume);
  pool.clot = lens.clot;
  pool.fluid = lens.fluid;
  const auto first = static_cast<std::uint32_t>(state.pool_vertices.size());
  const auto add = [&](const Place& place, float share) {
    if (!usable(place)) return false;
    PoolVertex vertex;
    const Vec3f normal = here.normal(place.seat.triangle), base = here.position(place.seat);
    vertex.thickness = lens.depth * (1 - share * share);
    vertex.position = base + (vertex.thickness + above) * normal;
    // A paraboloid falls off by 2 · depth · share / radius there.
    const Vec3f out = base - pool.position;
    const Vec3f along = out - normal * normal.dot(out);
    vertex.normal =
        (normal + 2 * lens.depth * share / std::max(out.norm() / std::max(share, 0.1F), 1e-6F) * along.normalized())
            .normalized();
    vertex.bile = lens.fluid == Fluid::bile ? 1 : 0;
    vertex.clot = lens.clot;
    state.pool_vertices.push_back(vertex);
    return true;
  };
  bool whole = add(lens.place, 0);
  for (std::size_t k = 0; whole && k < 2 * Lens::rays; ++k) whole = add(lens.ring[k], k < Lens::rays ? 0.55F : 1);
  if (!whole) {
    state.pool_vertices.resize(first);
    return;
  }
  state.pools.push_back(pool);
  constexpr auto rays = static_cast<std::uint32_t>(Lens::rays);
  for (std::uint32_t k = 0; k < rays; ++k) {
    const std::uint32_t a = first + 1 + k, b = first + 1 + (k + 1) % rays, c = a + rays, d = b + rays;
    for (const std::uint32_t i : {first, a, b, a, c, d, a, d, b}) state.pool_indices.push_back(i);
  }
}

}  // namespace calot::detail
