#include "calot/patient/label_cleaning.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/image/morphology.h"

namespace calot {
namespace {

bool is_layer(Structure s) {
  return s == Structure::hepatocystic_fat || s == Structure::gallbladder_bed || s == Structure::gallbladder_wall;
}

/// One structure in its box.
struct Region {
  Structure structure;
  VoxelBox box;
  Mask mask;
};

/// Makes the labels agree with the mask, taking voxels from nothing but the background.
void write_back(LabelEdit& edit, const WorkLabels& labels, const Region& region) {
  for_voxels(region.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
    if (region.mask[b] != 0 && labels.at(v) == Structure::none) edit.set(v, region.structure);
    if (region.mask[b] == 0 && labels.at(v) == region.structure) edit.set(v, Structure::none);
  });
}

/// Leaves a layer its largest part. Thick slices cut a thin one that slants into strips, which lie side by side from
/// slice to slice and which resampling joins again: those belong together. In cubes it is what hangs together by
/// corners.
std::size_t keep_largest_layer(Mask& mask, const VoxelSize& size, const Vec3& spacing) {
  Mask near = dilated(mask, size, spacing, spacing.maxCoeff() / std::numbers::sqrt2);
  const std::size_t specks = keep_largest_part(near, size, Joined::by_corners);
  for (std::size_t v = 0; v < mask.size(); ++v) mask[v] &= near[v];
  return specks;
}

void keep_largest(LabelEdit& edit, const WorkLabels& labels, Region& region, std::vector<CompletionStep>& steps) {
  const VoxelSize size = region.box.size();
  const Joined joined = is_tube(region.structure) ? Joined::by_corners : Joined::by_faces;
  const std::size_t specks = is_layer(region.structure) ? keep_largest_layer(region.mask, size, labels.grid.spacing())
                                                        : keep_largest_part(region.mask, size, joined);
  if (specks == 0) return;
  write_back(edit, labels, region);
  edit.report(steps, region.structure, "largest part kept",
              text_of("%zu other part%s removed", specks, specks == 1 ? "" : "s"));
}

void fill_holes(LabelEdit& edit, const WorkLabels& labels, Region& region, double largest,
                std::vector<CompletionStep>& steps) {
  std::vector<std::size_t> whole(region.box.count());
  for_voxels(region.box, labels.grid.size, [&](std::size_t v, std::size_t b) { whole[b] = v; });
  std::size_t filled = 0, kept = 0;
  for (const Hole& hole : holes_in(region.mask, region.box.size())) {
    const bool background = std::all_of(hole.voxels.begin(), hole.voxels.end(),
                                        [&](std::size_t b) { return labels.at(whole[b]) == Structure::none; });
    if (!background) continue;  // another structure lies in it
    if (static_cast<double>(hole.voxels.size()) * labels.grid.voxel_volume() > largest) {
      ++kept;
      continue;
    }
    ++filled;
    for (const std::size_t b : hole.voxels) {
      region.mask[b] = 1;
      edit.set(whole[b], region.structure);
    }
  }
  if (filled > 0)
    edit.report(steps, region.structure, "hole filling",
                text_of("%zu enclosed hole%s of at most %.3g mL; %zu larger left", filled, filled == 1 ? "" : "s",
                        1e6 * largest, kept));
}

void smooth(LabelEdit& edit, const WorkLabels& labels, Region& region, const CompletionOptions& options,
            std::vector<CompletionStep>& steps) {
  const Vec3 spacing = labels.grid.spacing();
  if (!(options.closing > 0) || is_layer(region.structure)) return;
  const VoxelSize size = region.box.size();
  Mask self = region.mask;
  if (!is_tube(region.structure)) self = opened(self, size, spacing, options.closing);
  self = closed(self, size, spacing, options.closing);
  const double before = face_area(region.mask, size, spacing), after = face_area(self, size, spacing);
  if (!(after > 0) || before <= options.ragged_above * after) return;
  region.mask = std::move(self);
  keep_largest_part(region.mask, size, is_tube(region.structure) ? Joined::by_corners : Joined::by_faces);
  write_back(edit, labels, region);
  edit.report(steps, region.structure, is_tube(region.structure) ? "closing" : "opening and closing",
              text_of("ball of %.3g mm; the surface was %.2f times that of the smoothed label, more than %.2f",
                      1e3 * options.closing, before / after, options.ragged_above));
}

}  // namespace

void clean_labels(WorkLabels& labels, const CompletionOptions& options, const std::set<Structure>& leave,
                  std::vector<CompletionStep>& steps, Progress& progress) {
  progress.phase("completing: cleaning the labels");
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  const Vec3 spacing = labels.grid.spacing();
  VoxelSize room{};
  for (std::size_t d = 0; d < 3; ++d)
    room[d] = 2 + static_cast<std::size_t>(std::ceil(options.closing / spacing[static_cast<Eigen::Index>(d)]));
  LabelEdit edit(labels);
  const auto region_of = [&](Structure s) {
    Region region{s, padded(boxes[label_of(s)], room, labels.grid.size), {}};
    region.mask =
        cut_out(labels.voxels, labels.grid.size, region.box, [&](std::uint8_t label) { return label == label_of(s); });
    return region;
  };
  std::vector<Structure> here;
  for (const Structure s : all_structures())
    if (!leave.contains(s) && !boxes[label_of(s)].empty()) here.push_back(s);
  for (const Structure s : here) {  // specks first: one may lie in another structure's hole
    Region region = region_of(s);
    keep_largest(edit, labels, region, steps);
  }
  for (std::size_t n = 0; n < here.size(); ++n) {
    progress.at(static_cast<double>(1 + n) / static_cast<double>(1 + here.size()));
    Region region = region_of(here[n]);
    fill_holes(edit, labels, region, options.largest_hole, steps);
    smooth(edit, labels, region, options, steps);
  }
  progress.at(1);
}

}  // namespace calot
