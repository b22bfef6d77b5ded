#include "calot/view/effects/surface_fluid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

constexpr float beyond = 0.15F;          // below all surfaces: gone [m]
constexpr double smallest_run = 1.2e-9;  // that runs off from a well [m³]
constexpr double stays = 1.0e-9;         // in a well, when some runs off [m³]
constexpr double run_time = 0.02;        // a well gathers at least what comes in so long [s]
constexpr double spurting = 0.3e-6;      // an artery that bleeds more than this throws blood [m³/s]
constexpr double heart_rate = 1.2;       // [1/s]
constexpr int seeps = 5;                 // places where a raw face oozes

/// The box in which film is kept: around what is operated on, or all tissue.
Eigen::AlignedBox3f mask_box(const TissueSkin& skin, float voxel) {
  Eigen::AlignedBox3f field, all;
  for (const SkinVertex& vertex : skin.vertices) {
    if (!vertex.rest.allFinite()) continue;
    all.extend(vertex.rest);
    if (vertex.look == TissueLook::gallbladder || vertex.look == TissueLook::duct ||
        vertex.look == TissueLook::artery || vertex.look == TissueLook::bed)
      field.extend(vertex.rest);
  }
  if (all.isEmpty()) return all;
  const Vec3f rim = Vec3f::Constant(2 * voxel), near = Vec3f::Constant(12e-3F);
  all = Eigen::AlignedBox3f(all.min() - rim, all.max() + rim);
  if (field.isEmpty()) return all;
  return all.intersection(Eigen::AlignedBox3f(field.min() - near, field.max() + near));
}

}  // namespace

SurfaceFluid::SurfaceFluid(const Snapshot& first, std::span<const Surface> still, const EffectsOptions& options)
    : options_(options), random_(options.seed) {
  liquids_[0] = {options.blood_viscosity, 1060, 0.056};
  liquids_[1] = {options.bile_viscosity, 1010, 0.045};
  const Eigen::AlignedBox3f box = mask_box(first.skin, options.voxel);
  if (!box.isEmpty()) film_ = FilmMask(box, options.voxel, options.mask_bytes);
  sheets_[1].take_still(still);
  skin_version_ = first.skin.version;
  sheets_[0].take_skin(first.skin, first.positions);
  for (const FluidSnapshot& fluid : first.fluids) {
    Source source;
    source.id = fluid.id;
    source.seen = std::isfinite(fluid.shed) ? fluid.shed : 0;
    sources_.push_back(source);
  }
  std::sort(sources_.begin(), sources_.end(), [](const Source& a, const Source& b) { return a.id < b.id; });
  take(first, 0);
}

LensShape SurfaceFluid::shape(double volume, Fluid fluid, float wet) const {
  constexpr double on_dry = 0.7, on_wet = 0.42;  // angles at which it meets the surface [rad]
  return lens_shape(liquid(fluid), volume, on_dry + (on_wet - on_dry) * static_cast<double>(wet));
}

void SurfaceFluid::take(const Snapshot& snapshot, std::uint64_t steps) {
  if (snapshot.gravity.allFinite()) {
    gravity_ = snapshot.gravity;
    if (gravity_.norm() > 1e-3F) down_ = gravity_.normalized();
  }
  if (snapshot.skin.version != skin_version_)
    find_new_seats(snapshot);
  else
    sheets_[0].move(snapshot.positions);
  floor_ = -1e30F;
  for (const Vec3f& p : snapshot.positions)
    if (p.allFinite()) floor_ = std::max(floor_, p.dot(down_));
  for (const Vec3f& p : sheets_[1].rests())
    if (p.allFinite()) floor_ = std::max(floor_, p.dot(down_));
  floor_ += beyond;
  suctions_.clear();
  for (const InstrumentSnapshot& tool : snapshot.instruments)
    if (tool.kind == InstrumentKind::suction && tool.energy && tool.pose.position.allFinite())
      suctions_.push_back({tool.pose.position.cast<float>()});
  take_sources(snapshot, steps);
}

void SurfaceFluid::take_sources(const Snapshot& snapshot, std::uint64_t steps) {
  for (Source& source : sources_) source.due = source.rate = 0;
  for (const FluidSnapshot& fluid : snapshot.fluids) {
    auto found = std::lower_bound(sources_.begin(), sources_.end(), fluid.id,
                                  [](const Source& s, std::uint32_t id) { return s.id < id; });
    if (found == sources_.end() || found->id != fluid.id) {
      found = sources_.insert(found, Source{});
      found->id = fluid.id;
    }
    place_source(*found, fluid);
    const double more = fluid.shed - found->seen;
    if (steps == 0 || !(more > 0) || !std::isfinite(more)) continue;
    found->seen = fluid.shed;
    found->due = more / static_cast<double>(steps);
    found->rate = std::isfinite(fluid.rate) ? std::max(0.0, fluid.rate) : 0;
  }
}

void SurfaceFluid::place_source(Source& source, const FluidSnapshot& fluid) {
  source.well.fluid = fluid.fluid;
  Place place{false, {sheets_[0].triangle_of(fluid.triangle), Vec3f::Constant(1.0F / 3)}};
  if (place.seat.triangle != no_triangle && usable(place) && fluid.position.allFinite()) {
    place.seat.weights = nearest_on_triangle(fluid.position, sheets_[0].corners(place.seat.triangle));
  } else if (const auto near = sheets_[0].nearest(fluid.position, 20e-3F)) {
    place.seat = near->seat;
  } else {
    return;
  }
  if (place.seat.triangle != source.well.place.seat.triangle) source.well.draped = 0;
  source.well.place = place;
  source.raw = sheets_[0].is_raw(place.seat.triangle);
  source.artery = fluid.fluid == Fluid::blood && sheets_[0].is_artery(place.seat.triangle);
}

void SurfaceFluid::pour(const Place& place, Fluid fluid, double volume) {
  ledger(fluid).shed += volume;
  Parcel parcel;
  parcel.place = place;
  parcel.fluid = fluid;
  parcel.volume = volume;
  add_parcel(parcel);
}

void SurfaceFluid::step(double dt) {
  ++steps_;
  time_ += dt;
  well_up(dt);
  run(dt);
  join_resting();
  settle();
  tend_pools(dt);
  fall(dt);
  suck(dt);
  film_.dry(dt, options_.drying_time);
}

void SurfaceFluid::well_up(double dt) {
  for (Source& source : sources_) {
    Lens& well = source.well;
    if (source.due > 0) {
      ledger(well.fluid).shed += source.due;
      well.volume += source.due;
    }
    if (!(well.volume > 0)) continue;
    if (!usable(well.place)) {
      // Nowhere to well up: it falls from where it was last seen, or is gone.
      ledger(well.fluid).gone += well.volume;
      well.volume = 0;
      continue;
    }
    const bool beats = std::fmod(time_ * heart_rate, 1.0) < 0.35;
    if (source.artery && source.rate > spurting && beats) {
      const double thrown = 0.5 * std::min(well.volume, 3 * source.rate * dt);
      well.volume -= thrown;
      throw_spurt(source, thrown);
    }
    shape_lens(well);
    const double enough = stays + std::max(smallest_run, source.rate * run_time);
    if (well.volume < enough || parcels_.size() >= options_.parcels) continue;
    Parcel parcel;
    parcel.place = well.place;
    parcel.fluid = well.fluid;
    parcel.volume = well.volume - stays;
    const std::uint32_t spot = source.raw ? next_id_ % seeps : 0;
    const auto words = mix3(source.id, spot, static_cast<std::uint32_t>(options_.seed));
    const float angle = static_cast<float>(words[0]) * 1.4629180e-9F,
                far = (source.raw ? 4e-3F : 0.3e-3F) * static_cast<float>(words[1]) * 2.3283064e-10F;
    const Sheet& here = sheet(parcel.place);
    const Vec3f normal = here.normal(parcel.place.seat.triangle), side = normal.unitOrthogonal();
    const Vec3f way = far * (std::cos(angle) * side + std::sin(angle) * normal.cross(side));
    const Walked to = walk(here, parcel.place.seat, way);
    if (!source.raw || here.is_raw(to.seat.triangle)) parcel.place.seat = to.seat;
    well.volume = stays;
    add_parcel(parcel);
  }
}

void SurfaceFluid::throw_spurt(Source& source, double volume) {
  if (volume < 1e-12) {
    source.well.volume += volume;
    return;
  }
  const Vec3f normal = sheets_[0].normal(source.well.place.seat.triangle);
  Drop drop;
  drop.position = position(source.well.place) + 0.5e-3F * normal;
  drop.velocity = (0.55F + 0.2F * random_.unit()) * normal + 0.12F * random_.in_ball();
  drop.volume = volume;
  drop.fluid = source.well.fluid;
  add_drop(drop);
}

/// Beyond the limit, it joins the nearest of its kind.
void SurfaceFluid::add_parcel(Parcel parcel) {
  parcel.id = next_id_++;
  if (parcels_.size() < options_.parcels) {
    parcels_.push_back(parcel);
    return;
  }
  const Vec3f here = position(parcel.place);
  Parcel* nearest = nullptr;
  float least = 1e30F;
  for (Parcel& other : parcels_) {
    const float distance = (position(other.place) - here).squaredNorm();
    if (other.fluid != parcel.fluid || !(distance < least)) continue;
    least = distance;
    nearest = &other;
  }
  if (nearest == nullptr)
    film_.absorb(parcel.fluid, parcel.volume);
  else
    nearest->volume += parcel.volume;
}

void SurfaceFluid::suck(double dt) {
  constexpr float reach = 8e-3F;  // as the simulation has it
  constexpr double most = 50e-6;  // [m³/s], as the simulation has it
  for (const Suction& suction : suctions_) {
    double room = most * dt;
    const auto take = [&](double& volume, Fluid fluid, const Vec3f& at, float radius) {
      if (!(volume > 0) || !((at - suction.tip).norm() - radius < reach)) return;
      const double taken = std::min(room, volume);
      volume -= taken;
      room -= taken;
      ledger(fluid).sucked += taken;
    };
    for (Source& source : sources_)
      if (usable(source.well.place)) take(source.well.volume, source.well.fluid, position(source.well.place), 0);
    for (Lens& pool : pools_) take(pool.volume, pool.fluid, position(pool.place), pool.radius);
    for (Parcel& parcel : parcels_) take(parcel.volume, parcel.fluid, position(parcel.place), 0);
    for (Drop& drop : drops_) take(drop.volume, drop.fluid, drop.position, 0);
    for (Sheet& here : sheets_) {
      const auto near = here.nearest(suction.tip, reach);
      if (!near) continue;
      const auto taken = film_.wipe(here.rest(near->seat), reach - near->distance, room);
      ledgers_[0].sucked += taken[0];
      ledgers_[1].sucked += taken[1];
      room -= taken[0] + taken[1];
    }
  }
  if (suctions_.empty()) return;
  const auto empty = [](const auto& some) { return !(some.volume > 0); };
  std::erase_if(pools_, empty);
  std::erase_if(parcels_, empty);
  std::erase_if(drops_, empty);
}

}  // namespace calot::detail
