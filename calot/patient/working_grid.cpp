#include "calot/patient/working_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/image/distance_map.h"
#include "calot/patient/line_of_label.h"
#include "calot/patient/shape_interpolation.h"

namespace calot {
namespace {

constexpr double most_voxels = 80e6;
constexpr double finest = 0.4e-3;

/// Labels and lines with the margin, in the source's voxel coordinates, within its volume (faces, not centres).
Eigen::AlignedBox3d region(const WorkLabels& labels, const VoxelGrid& source, const std::vector<Centreline>& lines,
                           double margin) {
  Eigen::AlignedBox3d box;
  const Eigen::Affine3d from_labels = source.to_world.inverse() * labels.grid.to_world;
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  for (const Structure s : all_structures()) {
    const VoxelBox& b = boxes[label_of(s)];
    if (b.empty()) continue;
    const auto corner = [](const VoxelSize& at) {
      return Vec3(static_cast<double>(at[0]) - 0.5, static_cast<double>(at[1]) - 0.5, static_cast<double>(at[2]) - 0.5);
    };
    box.extend(Vec3(from_labels * corner(b.first)));
    box.extend(Vec3(from_labels * corner(b.last)));
  }
  const Vec3 spacing = source.spacing();
  for (const Centreline& line : lines)
    for (std::size_t p = 0; p < line.points.size(); ++p) {
      const Vec3 at = source.to_world.inverse() * line.points[p], reach = line.radii[p] * spacing.cwiseInverse();
      box.extend(Vec3(at - reach));
      box.extend(Vec3(at + reach));
    }
  const Vec3 more = margin * spacing.cwiseInverse();
  const Vec3 last(static_cast<double>(source.size[0]), static_cast<double>(source.size[1]),
                  static_cast<double>(source.size[2]));
  return {(box.min() - more).cwiseMax(Vec3::Constant(-0.5)), (box.max() + more).cwiseMin(last - Vec3::Constant(0.5))};
}

WorkingGrid cropped(const VoxelGrid& source, const Eigen::AlignedBox3d& box) {
  WorkingGrid chosen{source, true, {}};
  Vec3 first;
  for (int d = 0; d < 3; ++d) {
    const auto a = static_cast<std::size_t>(d);
    first[d] = std::floor(box.min()[d] + 0.5 + 1e-6);
    const double last = std::ceil(box.max()[d] + 0.5 - 1e-6);
    chosen.grid.size[a] = static_cast<std::size_t>(std::max(1.0, last - first[d]));
  }
  chosen.grid.to_world = source.to_world * Eigen::Translation3d(first);
  return chosen;
}

WorkingGrid resampled_grid(const VoxelGrid& source, const Eigen::AlignedBox3d& box, double spacing) {
  WorkingGrid chosen;
  const Vec3 own = source.spacing();
  Vec3 first;
  for (int d = 0; d < 3; ++d) {
    const double extent = box.sizes()[d] * own[d], count = std::max(1.0, std::round(extent / spacing));
    chosen.grid.size[static_cast<std::size_t>(d)] = static_cast<std::size_t>(count);
    first[d] = box.min()[d] + ((extent - count * spacing) / 2 + spacing / 2) / own[d];
  }
  chosen.grid.to_world = source.to_world;
  chosen.grid.to_world.linear() = source.to_world.linear() * (spacing * own.cwiseInverse()).asDiagonal();
  chosen.grid.to_world.translation() = source.to_world * first;
  return chosen;
}

/// Of the lines, and of the tubes that are given as labels only: those by their mean, because radii found in a few
/// voxels waver.
double thinnest_radius(const WorkLabels& labels, const std::vector<Centreline>& lines) {
  double radius = 1;
  for (const Centreline& line : lines)
    for (const double r : line.radii) radius = std::min(radius, r);
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  for (const Structure s : all_structures()) {
    const bool drawn = std::any_of(lines.begin(), lines.end(),
                                   [&](const Centreline& line) { return structure_named(line.name) == s; });
    if (!is_tube(s) || drawn || boxes[label_of(s)].empty()) continue;
    const std::vector<double> radii = line_of_label(labels, s).radii;
    radius = std::min(radius, std::accumulate(radii.begin(), radii.end(), 0.0) / static_cast<double>(radii.size()));
  }
  return radius;
}

double voxels_of(const WorkingGrid& chosen) {
  const auto& n = chosen.grid.size;
  return static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
}

/// The finest grid that fits, given that `spacing` doesn't; the source's own voxels where they are no coarser.
WorkingGrid within_limit(const VoxelGrid& source, const Eigen::AlignedBox3d& box, double spacing, bool own_are_good) {
  const Vec3 own = source.spacing();
  spacing = std::max(spacing, std::cbrt(box.sizes().cwiseProduct(own).prod() / most_voxels));
  WorkingGrid chosen = resampled_grid(source, box, spacing);
  while (voxels_of(chosen) > most_voxels) chosen = resampled_grid(source, box, spacing *= 1.001);  // counts are rounded
  if (!own_are_good || own.maxCoeff() > spacing) return chosen;
  WorkingGrid whole = cropped(source, box);
  return voxels_of(whole) > most_voxels ? chosen : whole;
}

}  // namespace

WorkingGrid choose_working_grid(const WorkLabels& labels, const VoxelGrid& source, const std::vector<Centreline>& lines,
                                const CompletionOptions& options) {
  const Vec3 own = source.spacing();
  const bool good = own.maxCoeff() <= 1.05 * own.minCoeff() && own.maxCoeff() <= 1e-3 * (1 + 1e-6);
  const Eigen::AlignedBox3d box = region(labels, source, lines, options.margin);
  double spacing = good ? own.maxCoeff() : options.spacing;
  std::string why = good ? "the CT's own voxels" : "as asked for";
  const double thin = 2 * thinnest_radius(labels, lines), need = std::max(finest, thin / 2.2);
  const bool finer = need < spacing * (1 - 1e-9);
  if (finer) {
    spacing = need;
    why = text_of("for a tube that is %.2g mm wide", 1e3 * thin);
  }
  WorkingGrid chosen = good && !finer ? cropped(source, box) : resampled_grid(source, box, spacing);
  if (voxels_of(chosen) > most_voxels) {
    chosen = within_limit(source, box, spacing, good);
    why += text_of(", but not more than %.0f million voxels", most_voxels / 1e6);
    chosen.warning = text_of(
        "the working grid has voxels of %.3g mm, not of %.3g mm (%s); crop CT and labels, or lower "
        "the margin",
        1e3 * chosen.grid.spacing().maxCoeff(), 1e3 * spacing, why.c_str());
  }
  const Vec3 mm = 1e3 * chosen.grid.spacing();
  chosen.detail = text_of("%zu x %zu x %zu voxels of %.3g x %.3g x %.3g mm (%s), from %.3g x %.3g x %.3g mm",
                          chosen.grid.size[0], chosen.grid.size[1], chosen.grid.size[2], mm[0], mm[1], mm[2],
                          why.c_str(), 1e3 * own[0], 1e3 * own[1], 1e3 * own[2]);
  return chosen;
}

CtImage resample_ct(const CtImage& ct, const VoxelGrid& grid, Progress& progress) {
  progress.phase("completing: resampling the CT");
  CtImage out;
  out.grid = grid;
  out.hounsfield.resize(grid.count());
  const AxisMap map(ct.grid, grid);
  const std::array<std::vector<AxisMap::Linear>, 3> at{map.linear(0), map.linear(1), map.linear(2)};
  const std::size_t row = ct.grid.size[0], slice = row * ct.grid.size[1];
  constexpr std::size_t block = 16;
  for (std::size_t from = 0; from < grid.size[2]; from += block) {
    progress.at(static_cast<double>(from) / static_cast<double>(grid.size[2]));
    parallel_for(std::min(block, grid.size[2] - from), [&](std::size_t b) {
      const std::size_t k = from + b;
      const AxisMap::Linear& z = at[2][k];
      for (std::size_t j = 0; j < grid.size[1]; ++j) {
        const AxisMap::Linear& y = at[1][j];
        const std::array<const std::int16_t*, 4> rows{
            &ct.hounsfield[z.low * slice + y.low * row], &ct.hounsfield[z.low * slice + y.high * row],
            &ct.hounsfield[z.high * slice + y.low * row], &ct.hounsfield[z.high * slice + y.high * row]};
        const std::array<float, 4> weight{(1 - z.part) * (1 - y.part), (1 - z.part) * y.part, z.part * (1 - y.part),
                                          z.part * y.part};
        for (std::size_t i = 0; i < grid.size[0]; ++i) {
          const AxisMap::Linear& x = at[0][i];
          float sum = 0;
          for (std::size_t r = 0; r < 4; ++r)
            sum += weight[r] *
                   ((1 - x.part) * static_cast<float>(rows[r][x.low]) + x.part * static_cast<float>(rows[r][x.high]));
          out.hounsfield[grid.index(i, j, k)] = static_cast<std::int16_t>(std::lround(sum));
        }
      }
    });
  }
  progress.at(1);
  return out;
}

void report_resampling(const WorkLabels& before, const WorkLabels& after, const std::string& detail,
                       std::vector<CompletionStep>& steps) {
  const AxisMap map(before.grid, after.grid);
  const std::array<std::vector<std::size_t>, 3> at{map.nearest(0), map.nearest(1), map.nearest(2)};
  std::array<std::size_t, 256> added{}, removed{};
  std::size_t v = 0;
  for (std::size_t k = 0; k < after.grid.size[2]; ++k)
    for (std::size_t j = 0; j < after.grid.size[1]; ++j)
      for (std::size_t i = 0; i < after.grid.size[0]; ++i, ++v) {
        const std::uint8_t was =
            map.inside(i, j, k) ? before.voxels[before.grid.index(at[0][i], at[1][j], at[2][k])] : std::uint8_t{0};
        if (was == after.voxels[v]) continue;
        ++removed[was];
        ++added[after.voxels[v]];
      }
  const double ml = 1e6 * after.grid.voxel_volume();
  for (const Structure s : all_structures()) {
    const std::size_t a = added[label_of(s)], r = removed[label_of(s)];
    if (a + r > 0)
      steps.push_back({"resampling, against the nearest voxel", s, a, r, ml * static_cast<double>(a),
                       ml * static_cast<double>(r), detail});
  }
}

}  // namespace calot
