// Where on a sheet something is: a grid of its triangles, renewed when they have moved too far.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/view/effects/sheet.h"

namespace calot::detail {
namespace {

constexpr float usual_cell = 4e-3F;       // [m]
constexpr float largest_slack = 1.5e-3F;  // the triangles may be this far from where the grid has them [m]
constexpr int most_cells = 96;            // along an axis

}  // namespace

void Sheet::renew_grid() {
  if (!stale_ && !moved_) return;
  moved_ = false;
  slack_ = 0;
  if (!stale_) {
    float most = 0;
    for (std::size_t v = 0; v < now_.size(); ++v) {
      const float moved = (now_[v] - then_[v]).squaredNorm();
      if (moved > most) most = moved;  // not a number: not usable either
    }
    slack_ = std::sqrt(most);
    if (!(slack_ > largest_slack)) return;
  }
  slack_ = 0;
  stale_ = false;
  build_grid();
}

void Sheet::build_grid() {
  then_ = now_;
  Eigen::AlignedBox3f box;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    if (usable(t))
      for (const Vec3f& p : corners(t)) box.extend(p);
  cells_ = {0, 0, 0};
  cell_start_.assign(1, 0);
  cell_items_.clear();
  if (box.isEmpty()) return;
  corner_ = box.min();
  cell_ = std::max(usual_cell, box.sizes().maxCoeff() / most_cells);
  for (int i = 0; i < 3; ++i)
    cells_[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(box.sizes()[i] / cell_) + 1, 1, most_cells + 1);
  cell_start_.assign(static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2] + 1, 0);
  const auto each = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (!usable(t)) continue;
      const auto c = corners(t);
      const Vec3f low = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
      std::array<int, 3> first{}, last{};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto k = static_cast<int>(i);
        first[i] = std::clamp(static_cast<int>((low[k] - corner_[k]) / cell_), 0, cells_[i] - 1);
        last[i] = std::clamp(static_cast<int>((high[k] - corner_[k]) / cell_), 0, cells_[i] - 1);
      }
      for (int z = first[2]; z <= last[2]; ++z)
        for (int y = first[1]; y <= last[1]; ++y)
          for (int x = first[0]; x <= last[0]; ++x)
            visit(static_cast<std::size_t>(x + cells_[0] * (y + cells_[1] * z)), t);
    }
  };
  each([&](std::size_t cell, std::uint32_t) { ++cell_start_[cell + 1]; });
  for (std::size_t c = 1; c < cell_start_.size(); ++c) cell_start_[c] += cell_start_[c - 1];
  cell_items_.resize(cell_start_.back());
  std::vector<std::uint32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  each([&](std::size_t cell, std::uint32_t t) { cell_items_[next[cell]++] = t; });
}

/// Visits every triangle whose box may meet [low, high], once.
template <class Visit>
void Sheet::each_near(const Vec3f& low, const Vec3f& high, const Visit& visit) {
  renew_grid();
  if (cell_items_.empty()) return;
  if (++query_ == 0) {
    std::fill(seen_.begin(), seen_.end(), 0);
    query_ = 1;
  }
  std::array<int, 3> first{}, last{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<int>(i);
    const auto most = static_cast<float>(cells_[i]);
    const float a = (low[k] - slack_ - corner_[k]) / cell_, b = (high[k] + slack_ - corner_[k]) / cell_;
    if (!(a < most) || !(b >= 0)) return;
    first[i] = std::max(0, static_cast<int>(a));
    last[i] = static_cast<int>(std::min(b, most - 1));
  }
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int x = first[0]; x <= last[0]; ++x) {
        const auto cell = static_cast<std::size_t>(x + cells_[0] * (y + cells_[1] * z));
        for (std::uint32_t i = cell_start_[cell]; i < cell_start_[cell + 1]; ++i) {
          const std::uint32_t t = cell_items_[i];
          if (seen_[t] == query_) continue;
          seen_[t] = query_;
          visit(t);
        }
      }
}

std::optional<Sheet::Nearest> Sheet::nearest(const Vec3f& p, float reach, const Vec3f& facing) {
  std::optional<Nearest> best;
  if (!p.allFinite()) return best;
  float closest = reach * reach;
  each_near(p - Vec3f::Constant(reach), p + Vec3f::Constant(reach), [&](std::uint32_t t) {
    if (!usable(t)) return;
    if (!facing.isZero() && normal(t).dot(facing) <= 0) return;
    const auto c = corners(t);
    const Vec3f weights = nearest_on_triangle(p, c);
    const float squared = (weights[0] * c[0] + weights[1] * c[1] + weights[2] * c[2] - p).squaredNorm();
    if (!(squared < closest || (squared == closest && best && t < best->seat.triangle))) return;
    closest = squared;
    best = Nearest{{t, weights}, std::sqrt(squared)};
  });
  return best;
}

std::optional<Seat> Sheet::hit(const Vec3f& a, const Vec3f& b, bool both) {
  std::optional<Seat> first;
  if (!a.allFinite() || !b.allFinite()) return first;
  const Vec3f way = b - a;
  float soonest = 2;
  each_near(a.cwiseMin(b), a.cwiseMax(b), [&](std::uint32_t t) {
    if (!usable(t)) return;
    const auto c = corners(t);
    const Vec3f area = (c[1] - c[0]).cross(c[2] - c[0]);
    const float falling = way.dot(area);
    if (falling == 0 || (falling > 0 && !both)) return;
    const float share = (c[0] - a).dot(area) / falling;
    if (!(share >= 0 && share <= 1) || share > soonest) return;
    const Vec3f p = a + share * way;
    Vec3f weights;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>((k + 1) % 3), j = static_cast<std::size_t>((k + 2) % 3);
      weights[k] = area.dot((c[j] - c[i]).cross(p - c[i])) / area.squaredNorm();
      if (weights[k] < -1e-5F) return;
    }
    if (share == soonest && first && first->triangle < t) return;
    soonest = share;
    weights = weights.cwiseMax(0);
    first = Seat{t, weights / weights.sum()};
  });
  return first;
}

}  // namespace calot::detail
