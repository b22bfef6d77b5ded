// Small generated label maps for the tests of this room.
#pragma once
#include <functional>

#include "calot/image/label_map.h"

namespace calot::test {

/// A grid of `size` voxels of `spacing` [m], turned about all three axes (no axis stays where it was) and moved.
VoxelGrid oblique_grid(std::array<std::size_t, 3> size, const Eigen::Vector3d& spacing);

/// A map that takes its label from a voxel's (i, j, k).
LabelMap map_of(const VoxelGrid& grid, const std::function<Label(int, int, int)>& label);

/// Two halves of a ball of `radius` voxels, labels 1 ("left half") and 2 ("right half"), in a volume that fits it.
LabelMap half_balls(int radius, const VoxelGrid& like);

}  // namespace calot::test
