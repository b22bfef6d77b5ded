#include "calot/view/effects/effects.h"

#include <cmath>
#include <utility>

#include "calot/base/error.h"
#include "calot/view/effects/burns.h"
#include "calot/view/effects/gas.h"
#include "calot/view/effects/surface_fluid.h"

namespace calot {
namespace {

constexpr float dome = 0.06F;        // of the abdomen above the tissue [m]
constexpr double usual_step = 0.01;  // where a snapshot has none [s]

void check(const EffectsOptions& o) {
  const auto in = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!in(static_cast<double>(o.voxel), 0.2e-3, 5e-3) || o.mask_bytes < 16384 || o.mask_bytes > (1U << 28U))
    throw InputError("effects", "the mask's voxel or memory is out of range",
                     "give 0.2e-3 ... 5e-3 m and 16 KiB ... 256 MiB");
  if (o.parcels == 0 || o.parcels > 20000 || o.pools > 1000 || o.drops > 10000 || o.puffs > 10000 || o.sparks > 10000)
    throw InputError("effects", "a number of parcels, pools, drops, puffs or sparks is out of range",
                     "give at least 1 parcel, and at most 20000 parcels, 1000 pools, 10000 of the others");
  if (!in(o.blood_viscosity, 1e-4, 1) || !in(o.bile_viscosity, 1e-4, 1) || !in(o.retention, 0, 1) ||
      !in(o.left_behind, 0, 1))
    throw InputError("effects", "a figure of a fluid is out of range",
                     "give viscosities of 1e-4 ... 1 Pa s, shares of 0 ... 1");
  if (!in(o.clotting_time, 1e-3, 1e9) || !in(o.drying_time, 1e-3, 1e9) || !in(o.gas_volume, 1e-6, 1) ||
      !in(o.gas_exchange, 0, 1) || !in(o.gas_suction, 0, 1) || !in(o.smoke_per_joule, 0, 1))
    throw InputError("effects", "a time or a figure of the gas is out of range",
                     "give times above 0 s, a volume above 1e-6 m3, flows of at least 0");
}

}  // namespace

struct Effects::Parts {
  detail::SurfaceFluid fluid;
  detail::Gas gas;
  detail::Burns burns;
  EffectsState state;
};

Effects::Effects(const Snapshot& first, std::span<const Surface> still, const EffectsOptions& options) {
  check(options);
  parts_ = std::make_unique<Parts>();
  parts_->fluid = detail::SurfaceFluid(first, still, options);
  parts_->gas = detail::Gas(options);
  parts_->burns = detail::Burns(options);
  std::swap(parts_->state.mask, parts_->fluid.film().mask());
  advance(first, 0);
}

Effects::~Effects() = default;
Effects::Effects(Effects&&) noexcept = default;
Effects& Effects::operator=(Effects&&) noexcept = default;

void Effects::advance(const Snapshot& snapshot, std::uint64_t steps) {
  const bool sound = snapshot.time_step > 0 && snapshot.time_step < 1;
  const double dt = sound ? snapshot.time_step : usual_step;
  detail::SurfaceFluid& fluid = parts_->fluid;
  std::swap(parts_->state.mask, fluid.film().mask());  // the state has it between calls
  fluid.take(snapshot, steps);
  parts_->burns.take(snapshot, fluid.skin());
  const bool weighs = snapshot.gravity.allFinite() && snapshot.gravity.norm() > 1e-3F;
  const Vec3f gravity = weighs ? snapshot.gravity : Vec3f(0, 0, -9.81F), up = -gravity.normalized();
  float ceiling = -1e30F;
  for (const Vec3f& p : snapshot.positions)
    if (p.allFinite()) ceiling = std::max(ceiling, p.dot(up));
  ceiling += dome;
  std::vector<Vec3f> suctions;
  for (const InstrumentSnapshot& tool : snapshot.instruments)
    if (tool.kind == InstrumentKind::suction && tool.energy && tool.pose.position.allFinite())
      suctions.emplace_back(tool.pose.position.cast<float>());
  for (std::uint64_t k = 0; k < steps; ++k) {
    fluid.step(dt);
    parts_->burns.step(dt, gravity, fluid.skin(), fluid.film().mask());
    parts_->gas.step(dt, parts_->burns.tips(), suctions, up, ceiling);
  }
  parts_->state.step = snapshot.step;
  fluid.tell(parts_->state);
  std::swap(parts_->state.mask, fluid.film().mask());
  parts_->gas.tell(parts_->state);
  parts_->burns.tell(parts_->state);
}

const EffectsState& Effects::state() const {
  return parts_->state;
}

}  // namespace calot
