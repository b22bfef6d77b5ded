// Exact Euclidean distance maps of voxel regions.
#pragma once
#include <Eigen/Core>
#include <limits>

#include "calot/image/voxel_box.h"

namespace calot {

/// Distance [the unit of spacing] of every voxel's centre from the nearest centre of a voxel that is set; 0 at those,
/// infinite where none is set at all. Spacing may differ between the axes. The result doesn't depend on threads.
/// Source: the lower envelope of parabolas, one axis after the other [Felzenszwalb2012].
std::vector<float> distance_to_set(const Mask& set, const VoxelSize& size, const Eigen::Vector3d& spacing);

/// The same for voxels that aren't set.
std::vector<float> distance_to_unset(const Mask& set, const VoxelSize& size, const Eigen::Vector3d& spacing);

}  // namespace calot
