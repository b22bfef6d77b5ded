#include "calot/view/effects/gas.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

constexpr double extinction = 4400;      // of smoke that smoulders [m²/kg], [Seader1977]
constexpr double joules_per_puff = 1.2;  // of smoke
constexpr double steam_per_smoke = 2.0;  // as much more mass, which is gone in a moment; assumed
constexpr double steam_life = 0.5;       // [s]
constexpr float first_spread = 1.5e-3F;  // [m]
constexpr float diffusion = 6e-5F;       // turbulent, of a puff [m²/s]; assumed
constexpr float rise = 0.11F;            // of hot smoke [m/s]; assumed
constexpr float cooling = 1.6F;          // time until it rises no more [s]
constexpr float drag = 0.12F;            // time in which it takes the gas's speed [s]
constexpr float swirl = 0.045F;          // speed of the eddies [m/s]
constexpr float eddy = 16e-3F;           // their size [m]
constexpr float thin = 20e-3F;           // spread from which a puff is haze within a second [m]

}  // namespace

Gas::Gas(const EffectsOptions& options) : options_(options), random_(options.seed + 0x5eed) {}

double Gas::smoke_in_puffs() const {
  double sum = 0;
  for (const Puff& puff : puffs_)
    if (puff.kind == PuffKind::smoke) sum += puff.mass;
  return sum;
}

/// Beyond the limit the oldest is taken as haze.
void Gas::add(Puff puff) {
  if (options_.puffs == 0) {
    if (puff.kind == PuffKind::smoke) haze_ += puff.mass;
    return;
  }
  if (puffs_.size() >= options_.puffs) {
    if (puffs_.front().kind == PuffKind::smoke) haze_ += puffs_.front().mass;
    puffs_.erase(puffs_.begin());
  }
  puffs_.push_back(puff);
}

void Gas::give_off(double dt, const BurningTip& tip, std::size_t index) {
  due_[index] += tip.power * dt;
  while (due_[index] >= joules_per_puff) {
    due_[index] -= joules_per_puff;
    Puff puff;
    puff.position = tip.place + first_spread * random_.in_ball();
    puff.velocity = (0.08F + 0.14F * random_.unit()) * tip.outwards + 0.05F * random_.in_ball();
    puff.mass = options_.smoke_per_joule * joules_per_puff * static_cast<double>(0.5F + random_.unit());
    puff.spread = first_spread * (0.8F + 0.5F * random_.unit());
    puff.seed = random_.unit();
    puff.turn = 6.2831853F * random_.unit();
    puff.spin = 1.2F * random_.symmetric();
    made_ += puff.mass;
    const bool steams = random_.unit() < 0.5F;
    Puff steam = puff;
    add(puff);
    if (!steams) continue;
    steam.kind = PuffKind::steam;
    steam.mass *= steam_per_smoke;
    steam.velocity *= 1.6F;
    add(steam);
  }
}

void Gas::move(Puff& puff, double dt, std::span<const Vec3f> suctions, const Vec3f& up, float ceiling) {
  const auto h = static_cast<float>(dt);
  const Vec3f drift = up * (0.35F * static_cast<float>(time_));
  Vec3f wind = swirl * curl_noise(puff.position / eddy - drift, 41) +
               0.5F * swirl * curl_noise(puff.position / (0.4F * eddy) - 1.7F * drift, 43);
  wind += rise * puff.heat * up;
  for (const Vec3f& tip : suctions) {
    // A sink: the gas that the tube takes comes from all sides.
    const Vec3f to = tip - puff.position;
    const float distance = std::max(to.norm(), 2e-3F);
    const auto speed = static_cast<float>(options_.gas_suction / (4 * std::numbers::pi)) / (distance * distance);
    wind += std::min(speed, 0.5F * distance / h) * to / distance;
  }
  const float room = ceiling - puff.position.dot(up);  // it spreads under the dome
  const float above = wind.dot(up);
  if (above > 0 && room < 0.02F) wind -= up * above * (1 - std::max(0.0F, room) / 0.02F);
  puff.velocity += (wind - puff.velocity) * (1 - std::exp(-h / drag));
  puff.position += h * puff.velocity;
  puff.heat *= std::exp(-h / cooling);
  puff.spread = std::sqrt(puff.spread * puff.spread + 2 * diffusion * h);
  puff.turn += h * puff.spin;
  puff.age += h;
}

void Gas::step(double dt, std::span<const BurningTip> tips, std::span<const Vec3f> suctions, const Vec3f& up,
               float ceiling) {
  time_ += dt;
  due_.resize(std::max(due_.size(), tips.size()), 0.0);
  for (std::size_t i = 0; i < tips.size(); ++i) give_off(dt, tips[i], i);
  const double steam_left = std::exp(-dt / steam_life);
  for (Puff& puff : puffs_) {
    move(puff, dt, suctions, up, ceiling);
    if (!puff.position.allFinite()) puff.mass = 0;
    if (puff.kind == PuffKind::steam) {
      puff.mass *= steam_left;
      if (puff.age > 5 * steam_life) puff.mass = 0;
      continue;
    }
    for (const Vec3f& tip : suctions) {
      if ((puff.position - tip).norm() > 6e-3F + 0.5F * puff.spread) continue;
      const double gone = puff.mass * (1 - std::exp(-dt / 0.08));
      puff.mass -= gone;
      taken_ += gone;
    }
    const double widening = static_cast<double>(std::max(0.0F, puff.spread / thin - 0.4F));
    const double to_haze = puff.mass * (1 - std::exp(-dt * widening));
    puff.mass -= to_haze;
    haze_ += to_haze;
    if (puff.mass < 2e-11) {
      haze_ += puff.mass;
      puff.mass = 0;
    }
  }
  std::erase_if(puffs_, [](const Puff& puff) { return !(puff.mass > 0); });
  const double flow = options_.gas_exchange + options_.gas_suction * static_cast<double>(suctions.size());
  const double cleared = haze_ * (1 - std::exp(-dt * flow / options_.gas_volume));
  haze_ -= cleared;
  taken_ += cleared;
}

void Gas::tell(EffectsState& state) const {
  state.puffs.clear();
  for (const Puff& puff : puffs_) {
    PuffState out;
    out.position = puff.position;
    out.radius = 2 * puff.spread;
    const auto spread = static_cast<double>(puff.spread);
    out.depth = static_cast<float>(extinction * puff.mass / (2 * std::numbers::pi * spread * spread));
    out.turn = puff.turn;
    out.seed = puff.seed;
    out.kind = puff.kind;
    state.puffs.push_back(out);
  }
  state.haze = static_cast<float>(extinction * haze_ / options_.gas_volume);
}

}  // namespace calot::detail
