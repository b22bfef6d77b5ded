// Opening, closing, parts and holes of one voxel region.
#pragma once
#include <Eigen/Core>

#include "calot/image/voxel_box.h"

namespace calot {

/// The region grown by a ball of `radius` [the unit of spacing]: voxels whose centre is that near to a centre in it.
Mask dilated(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius);
/// The region shrunk by a ball. Beyond the volume counts as inside: an organ isn't eaten from where the image ends.
Mask eroded(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius);
/// Dilated, then eroded: gaps narrower than the ball are filled. The volume must have room for the dilation, or end
/// there.
Mask closed(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius);
/// Eroded, then dilated: what is thinner than the ball goes.
Mask opened(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius);

/// Area [spacing²] of the voxel faces between the region and its outside, without those on the volume's border.
double face_area(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing);

enum class Joined { by_faces, by_corners };

/// Leaves the region its largest part, the first of equals.
/// @return parts that went
std::size_t keep_largest_part(Mask& mask, const VoxelSize& size, Joined joined);

/// A part of the outside that the region encloses: it touches neither the volume's border nor, through faces, anything
/// that does.
struct Hole {
  std::vector<std::size_t> voxels;
};
std::vector<Hole> holes_in(const Mask& mask, const VoxelSize& size);

}  // namespace calot
