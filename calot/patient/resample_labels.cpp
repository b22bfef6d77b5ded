// Shape-based interpolation of label maps.
#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/image/distance_map.h"
#include "calot/patient/shape_interpolation.h"
#include "calot/patient/working_grid.h"

namespace calot {
namespace {

constexpr std::int16_t far = 32767;

/// Spacing with coarse axes stretched.
Vec3 stretched(const Vec3& spacing) {
  Vec3 counts = spacing;
  for (int d = 0; d < 3; ++d)
    if (spacing[d] > 1.5 * spacing.minCoeff()) counts[d] *= 3;
  return counts;
}

/// Signed distance from the surface halfway between inner and outer voxels, negative inside, in units of the finest
/// spacing, at most 100.
std::vector<float> signed_distance(const Mask& mask, const VoxelSize& size, const Vec3& spacing) {
  const Vec3 unit = stretched(spacing) / spacing.minCoeff();
  std::vector<float> outside = distance_to_set(mask, size, unit);
  const std::vector<float> inside = distance_to_unset(mask, size, unit);
  for (std::size_t v = 0; v < mask.size(); ++v)
    outside[v] = mask[v] != 0 ? -std::min(inside[v] - 0.5f, 100.0f) : std::min(outside[v] - 0.5f, 100.0f);
  return outside;
}

/// Takes the voxels' steps out of a distance: a binomial filter (σ = 1 voxel) along each axis. What it takes from round
/// bodies the level for their volume gives back.
void soften(std::vector<float>& distance, const VoxelSize& size) {
  constexpr std::array<float, 5> weight{1 / 16.0f, 4 / 16.0f, 6 / 16.0f, 4 / 16.0f, 1 / 16.0f};
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; stride *= size[axis++]) {
    const std::vector<float> before = distance;
    const auto last = static_cast<std::ptrdiff_t>(size[axis]) - 1;
    parallel_blocks(distance.size(), 1u << 14, [&](std::size_t begin, std::size_t end, std::size_t) {
      for (std::size_t v = begin; v < end; ++v) {
        const auto at = static_cast<std::ptrdiff_t>(v / stride % size[axis]);
        float sum = 0;
        for (std::ptrdiff_t n = -2; n <= 2; ++n) {
          const std::ptrdiff_t moved = std::clamp<std::ptrdiff_t>(at + n, 0, last) - at;
          sum += weight[static_cast<std::size_t>(n + 2)] *
                 before[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(v) +
                                                 moved * static_cast<std::ptrdiff_t>(stride))];
        }
        distance[v] = sum;
      }
    });
  }
}

/// The level below which as many voxels lie as wanted, within ±`most`. Where many lie at one level, as along a straight
/// thin tube, all or none of them do, whichever is nearer; with `at_least`, all.
float level_for_volume(const std::vector<float>& distance, double voxels, float most, bool at_least) {
  constexpr std::size_t bins = 4096;
  std::vector<std::size_t> histogram(bins + 1, 0);
  std::size_t below = 0;
  for (const float d : distance) {
    if (d < -most)
      ++below;
    else if (d < most)
      ++histogram[static_cast<std::size_t>((d + most) / (2 * most) * static_cast<float>(bins))];
  }
  double sum = static_cast<double>(below);
  for (std::size_t b = 0; b < bins; ++b) {
    const double next = sum + static_cast<double>(histogram[b]);
    if (next >= voxels) {
      const bool all = at_least || next - voxels < voxels - sum;
      return most * (2 * static_cast<float>(b + (all ? 1 : 0)) / static_cast<float>(bins) - 1);
    }
    sum = next;
  }
  return most;
}

/// The two smallest distances met so far at every voxel of the new grid, a thousandth of the finest spacing each.
struct Nearest {
  std::vector<std::int16_t> first, second;
};

void take(const std::vector<float>& distance, float level, Structure s, const VoxelBox& box, const VoxelGrid& grid,
          Nearest& nearest, WorkLabels& out) {
  for_voxels(box, grid.size, [&](std::size_t v, std::size_t b) {
    const auto d = static_cast<std::int16_t>(std::floor(std::clamp(1000 * (distance[b] - level), -32000.0f, 32000.0f)));
    if (d < nearest.first[v]) {
      nearest.second[v] = nearest.first[v];
      nearest.first[v] = d;
      out.voxels[v] = static_cast<std::uint8_t>(label_of(s));
    } else {
      nearest.second[v] = std::min(nearest.second[v], d);
    }
  });
}

/// Outside is where no structure is; but where two come close from both sides there is nothing between them.
void clear_outside(const Nearest& nearest, WorkLabels& out) {
  constexpr std::int16_t sliver = 300;
  parallel_blocks(out.voxels.size(), 1u << 16, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t v = begin; v < end; ++v) {
      const bool between = nearest.first[v] < sliver && nearest.second[v] < sliver;
      if (nearest.first[v] >= 0 && !between) out.voxels[v] = 0;
    }
  });
}

WorkLabels same_voxels(const WorkLabels& labels, const VoxelGrid& grid, const AxisMap& map) {
  WorkLabels out{grid, std::vector<std::uint8_t>(grid.count(), 0)};
  const std::array<std::vector<std::size_t>, 3> at{map.nearest(0), map.nearest(1), map.nearest(2)};
  std::size_t v = 0;
  for (std::size_t k = 0; k < grid.size[2]; ++k)
    for (std::size_t j = 0; j < grid.size[1]; ++j)
      for (std::size_t i = 0; i < grid.size[0]; ++i, ++v)
        if (map.inside(i, j, k)) out.voxels[v] = labels.voxels[labels.grid.index(at[0][i], at[1][j], at[2][k])];
  return out;
}

}  // namespace

WorkLabels resample_labels(const WorkLabels& labels, const WorkingGrid& to, Progress& progress) {
  progress.phase("completing: resampling the labels");
  const VoxelGrid& grid = to.grid;
  const AxisMap map(labels.grid, grid);
  if (to.same_voxels) return same_voxels(labels, grid, map);
  const Vec3 spacing = labels.grid.spacing();
  const bool coarse_cubes =  // thick slices have other steps, which `stretched` takes care of
      spacing.minCoeff() > 1.8 * grid.spacing().maxCoeff() && spacing.maxCoeff() < 1.5 * spacing.minCoeff();
  WorkLabels out{grid, std::vector<std::uint8_t>(grid.count(), 0)};
  Nearest nearest{std::vector<std::int16_t>(grid.count(), far), std::vector<std::int16_t>(grid.count(), far)};
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  double done = 0;
  for (const Structure s : all_structures()) {
    progress.at(done++ / static_cast<double>(all_structures().size()));
    const VoxelBox& own = boxes[label_of(s)];
    if (own.empty()) continue;
    const VoxelBox box = padded(own, {4, 4, 4}, labels.grid.size);
    const Mask mask = cut_out(labels.voxels, labels.grid.size, box, [&](std::uint8_t l) { return l == label_of(s); });
    const auto voxels = static_cast<double>(std::count(mask.begin(), mask.end(), 1));
    const VoxelBox target = map.covered(own);
    if (target.empty()) continue;
    std::vector<float> coarse = signed_distance(mask, box.size(), spacing);
    if (coarse_cubes && !is_tube(s)) soften(coarse, box.size());  // tubes may be two voxels wide
    const std::vector<float> distance = interpolated(coarse, box, target, map);
    const float most = is_tube(s) ? 1.0f : 0.5f;
    const float level =
        level_for_volume(distance, voxels * labels.grid.voxel_volume() / grid.voxel_volume(), most, is_tube(s));
    take(distance, level, s, target, grid, nearest, out);
  }
  clear_outside(nearest, out);
  progress.at(1);
  return out;
}

}  // namespace calot
