#include "calot/patient/phantom.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/image/voxel_parts.h"
#include "calot/patient/phantom_tree.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

/// An organ as it is painted: later ones win where two meet.
struct Organ {
  Label label;
  std::string name;
  double hounsfield;  ///< mean of its content, docs/patient.md
  BallChain shape;
};

struct Anatomy {
  std::vector<Organ> organs;
  std::vector<Centreline> ducts;
  PhantomFacts facts;
};

Anatomy draw_anatomy(std::uint64_t seed) {
  Random random(seed);
  Anatomy anatomy;
  constexpr double bile = 3;  // HU; measured in a native CT's gallbladder
  constexpr double neck_radius = gallbladder_neck_radius;
  const Centreline common = draw_bile_duct(random, anatomy.facts);
  draw_cystic_duct_sizes(random, anatomy.facts);
  const Centreline cystic = draw_cystic_duct(random, neck_radius, common, anatomy.facts);
  const BallChain sac = draw_gallbladder(random, cystic.points.front(), neck_radius, anatomy.facts);
  anatomy.organs = {
      {label_of(Structure::cystic_duct), "cystic duct", bile, balls_along(cystic.points, cystic.radii)},
      {label_of(Structure::gallbladder), "gallbladder", bile, sac},
      {label_of(Structure::common_bile_duct), "common bile duct", bile, balls_along(common.points, common.radii)}};
  anatomy.ducts = {cystic, common};
  return anatomy;
}

VoxelGrid grid_around(const std::vector<Organ>& organs, double voxel) {
  Eigen::AlignedBox3d box;
  for (const Organ& organ : organs) box.extend(bounds(organ.shape));
  const double margin = 6 * mm;
  VoxelGrid grid;
  Vec3 origin;
  for (int d = 0; d < 3; ++d) {  // whole voxels from the origin, so that every seed's grid has the same raster
    const double first = std::floor((box.min()[d] - margin) / voxel), last = std::ceil((box.max()[d] + margin) / voxel);
    grid.size[static_cast<std::size_t>(d)] = static_cast<std::size_t>(last - first) + 1;
    origin[d] = first * voxel;
  }
  grid.to_world = Eigen::Translation3d(origin) * Eigen::Scaling(voxel);
  return grid;
}

/// Labels and CT, slice by slice; noise is a function of seed and voxel number, so threads don't matter.
void paint(const Anatomy& anatomy, std::uint64_t seed, double voxel, Phantom& phantom) {
  constexpr double fat = -75, noise = 11;  // HU
  const VoxelGrid& grid = phantom.labels.grid;
  const std::size_t slice = grid.size[0] * grid.size[1];
  parallel_for(grid.size[2], [&](std::size_t k) {
    std::vector<float> hounsfield(slice, static_cast<float>(fat)), distance(slice);
    for (const Organ& organ : anatomy.organs) {
      std::fill(distance.begin(), distance.end(), static_cast<float>(voxel));
      lower_to_distance(organ.shape, grid, k, voxel, distance);
      for (std::size_t v = 0; v < slice; ++v) {
        if (distance[v] < 0) phantom.labels.voxels[k * slice + v] = organ.label;
        const float share = std::clamp(0.5f - distance[v] / static_cast<float>(voxel), 0.0f, 1.0f);
        hounsfield[v] += share * (static_cast<float>(organ.hounsfield) - hounsfield[v]);
      }
    }
    for (std::size_t v = 0; v < slice; ++v) {
      Random random(seed ^ scramble(k * slice + v + 1));
      phantom.ct.hounsfield[k * slice + v] =
          static_cast<std::int16_t>(std::lround(hounsfield[v] + noise * random.normal()));
    }
  });
}

/// Where two ducts meet at an acute angle single voxels of one can be left beside the other.
void clean_labels(LabelMap& map) {
  std::vector<std::uint8_t> regions(map.voxels.begin(), map.voxels.end());
  keep_largest_parts(regions, map.grid.size, map.names.rbegin()->first);
  std::copy(regions.begin(), regions.end(), map.voxels.begin());
}

}  // namespace

Phantom make_biliary_tree(std::uint64_t seed, double voxel, Progress* progress) {
  if (!(voxel >= 0.3e-3 && voxel <= 0.7e-3))
    throw InputError("phantom", "the voxel size isn't in 0.3 … 0.7 mm", "use 0.6 mm");
  if (progress) progress->phase("phantom");
  const Anatomy anatomy = draw_anatomy(seed);
  Phantom phantom;
  phantom.facts = anatomy.facts;
  phantom.lines = anatomy.ducts;
  phantom.labels.grid = phantom.ct.grid = grid_around(anatomy.organs, voxel);
  phantom.labels.voxels.resize(phantom.labels.grid.count());
  phantom.ct.hounsfield.resize(phantom.labels.grid.count());
  for (const Organ& organ : anatomy.organs) phantom.labels.names[organ.label] = organ.name;
  paint(anatomy, seed, voxel, phantom);
  clean_labels(phantom.labels);
  if (progress) progress->at(1);
  return phantom;
}

}  // namespace calot
