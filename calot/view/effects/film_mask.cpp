#include "calot/view/effects/film_mask.h"

#include <algorithm>
#include <cmath>

#include "calot/view/effects/noise.h"

namespace calot::detail {
namespace {

constexpr double full_film = 60e-6;  // of a value of 255 [m]
constexpr double layers = 2;         // of voxels that a film on a surface fills
constexpr int drying_step = 8;       // of 255, so that a brick changes seldom

constexpr MaskChannel channel_of(Fluid fluid) {
  return fluid == Fluid::blood ? MaskChannel::blood : MaskChannel::bile;
}

}  // namespace

double FilmMask::unit() const {
  const auto voxel = static_cast<double>(mask_.voxel());
  return full_film * voxel * voxel / (255 * layers);
}

double FilmMask::volume(Fluid fluid) const {
  return static_cast<double>(units_[index(fluid)]) * unit() + loose_[index(fluid)];
}

double FilmMask::lay(Fluid fluid, const FilmSpot& spot, double thickness, double available) {
  const float voxel = mask_.voxel();
  const float rough = 1 + 0.2F * value_noise(spot.rest / 3e-3F, 11);
  const float radius = std::max(0.5F * voxel, spot.radius * rough);
  // The box of the disc, two voxels thick on either side.
  const Eigen::Vector3f extent = radius * (Eigen::Vector3f::Ones() - spot.normal.cwiseAbs2()).cwiseMax(0).cwiseSqrt() +
                                 2 * voxel * spot.normal.cwiseAbs() + Eigen::Vector3f::Constant(0.5F * voxel);
  const VoxelBlock block = mask_.around(spot.rest, extent);
  const auto wanted = static_cast<float>(255 * std::clamp(thickness / full_film, 0.0, 1.0));
  auto left = static_cast<std::int64_t>(available / std::max(unit(), 1e-30));
  std::int64_t used = 0;
  const auto c = static_cast<std::size_t>(channel_of(fluid)), w = static_cast<std::size_t>(MaskChannel::wet);
  for (int z = block.first[2]; z < block.first[2] + block.size[2]; ++z)
    for (int y = block.first[1]; y < block.first[1] + block.size[1]; ++y)
      for (int x = block.first[0]; x < block.first[0] + block.size[0]; ++x) {
        const Eigen::Vector3f d = mask_.middle(x, y, z) - spot.rest;
        const float off = d.dot(spot.normal), aside = std::sqrt(std::max(0.0F, d.squaredNorm() - off * off));
        const float in =
            std::clamp((radius - aside) / voxel + 0.5F, 0.0F, 1.0F) * std::clamp(2 - std::abs(off) / voxel, 0.0F, 1.0F);
        if (in <= 0) continue;
        std::uint8_t* now = mask_.at(x, y, z);
        const float round = 1 - 0.6F * std::min(1.0F, aside * aside / (radius * radius));  // thicker in the middle
        const auto more = std::min<std::int64_t>(static_cast<std::int64_t>(wanted * in * round) - now[c], left);
        const auto wetter = static_cast<int>(255 * in);
        if (more <= 0 && wetter < now[w] + drying_step) continue;
        if (more > 0) {
          now[c] = static_cast<std::uint8_t>(now[c] + more);
          left -= more;
          used += more;
        }
        now[w] = static_cast<std::uint8_t>(std::max<int>(now[w], wetter));
        mask_.touch(x, y, z);
      }
  units_[index(fluid)] += used;
  return static_cast<double>(used) * unit();
}

std::array<double, 2> FilmMask::wipe(const Eigen::Vector3f& rest, float radius, double room) {
  const VoxelBlock block = mask_.around(rest, radius);
  auto left = static_cast<std::int64_t>(room / std::max(unit(), 1e-30));
  std::array<std::int64_t, 2> taken{};
  for (int z = block.first[2]; z < block.first[2] + block.size[2]; ++z)
    for (int y = block.first[1]; y < block.first[1] + block.size[1]; ++y)
      for (int x = block.first[0]; x < block.first[0] + block.size[0]; ++x) {
        std::uint8_t* now = mask_.at(x, y, z);
        const float share = 1 - (mask_.middle(x, y, z) - rest).norm() / radius;
        if (share <= 0 || (now[0] == 0 && now[2] == 0)) continue;
        for (const Fluid fluid : {Fluid::blood, Fluid::bile}) {
          std::uint8_t& film = now[static_cast<std::size_t>(channel_of(fluid))];
          // A tenth of it in a step in the middle: a tube that passes thins the film, one that stays takes it away.
          const auto some = std::min<std::int64_t>(
              {film, 1 + static_cast<std::int64_t>(0.1F * share * static_cast<float>(film)), left});
          film = static_cast<std::uint8_t>(film - some);
          left -= some;
          taken[index(fluid)] += some;
        }
        mask_.touch(x, y, z);
      }
  std::array<double, 2> volumes{};
  for (std::size_t i = 0; i < 2; ++i) {
    units_[i] -= taken[i];
    volumes[i] = static_cast<double>(taken[i]) * unit();
  }
  return volumes;
}

void FilmMask::dry(double dt, double time) {
  const std::vector<std::uint32_t>& used = mask_.used_bricks();
  if (used.empty()) return;
  drying_ += static_cast<double>(used.size()) * dt / time * 255 / drying_step;
  drying_ = std::min(drying_, static_cast<double>(used.size()));
  for (; drying_ >= 1; drying_ -= 1) {
    next_ = (next_ + 1) % used.size();
    const VoxelBlock block = mask_.brick(used[next_]);
    bool changed = false;
    for (int z = block.first[2]; z < block.first[2] + block.size[2]; ++z)
      for (int y = block.first[1]; y < block.first[1] + block.size[1]; ++y) {
        std::uint8_t* row = mask_.at(block.first[0], y, z);
        for (int x = 0; x < block.size[0]; ++x) {
          std::uint8_t& wet = row[4 * x + 3];
          changed = changed || wet != 0;
          wet = static_cast<std::uint8_t>(std::max(0, wet - drying_step));
        }
      }
    if (changed) mask_.touch_brick(used[next_]);
  }
}

float FilmMask::value(const Eigen::Vector3f& rest, MaskChannel channel) const {
  if (mask_.bytes() == 0 || !rest.allFinite()) return 0;
  const Eigen::Vector3f p = (rest - mask_.origin()) / mask_.voxel();
  if (p.minCoeff() < 0 || p.maxCoeff() > 4096) return 0;
  const std::uint8_t* bytes = mask_.at(static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2]));
  return bytes != nullptr ? static_cast<float>(bytes[static_cast<std::size_t>(channel)]) / 255 : 0;
}

float FilmMask::film(const Eigen::Vector3f& rest, Fluid fluid) const {
  return value(rest, channel_of(fluid));
}

float FilmMask::wet(const Eigen::Vector3f& rest) const {
  return value(rest, MaskChannel::wet);
}

}  // namespace calot::detail
