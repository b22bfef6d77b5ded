// Voxel volumes in patient space.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace calot {

/// Where the voxels of a volume lie. Voxel (i, j, k) is number i + size[0]·(j + size[1]·k).
struct VoxelGrid {
  std::array<std::size_t, 3> size{};                       ///< voxels along i, j, k
  Eigen::Affine3d to_world = Eigen::Affine3d::Identity();  ///< (i, j, k) of a voxel's centre → RAS [m]; no shear

  [[nodiscard]] std::size_t count() const { return size[0] * size[1] * size[2]; }
  [[nodiscard]] std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
    return i + size[0] * (j + size[1] * k);
  }
  /// Edge lengths of a voxel along i, j, k [m].
  [[nodiscard]] Eigen::Vector3d spacing() const { return to_world.linear().colwise().norm(); }
  /// Volume of one voxel [m³].
  [[nodiscard]] double voxel_volume() const { return std::abs(to_world.linear().determinant()); }
};

/// Throws InputError, beginning with `where`, unless the voxel axes are finite, between 0 and 1 m long and at right
/// angles (to 1e-3).
void check_axes(const Eigen::Affine3d& to_world, const std::string& where);

/// A CT image.
struct CtImage {
  VoxelGrid grid;
  std::vector<std::int16_t> hounsfield;  ///< grid.count() values [HU]
};

/// How two grids differ, in words that go behind "they differ: " ("spacing 0.7 x 0.7 x 3.0 mm against 0.8 x 0.8 x 3.0
/// mm", "the second is moved by (7.3, 0, 0) mm"); empty when they have the same size and every voxel lies within a
/// hundredth of a voxel of its counterpart.
std::string grid_difference(const VoxelGrid& a, const VoxelGrid& b);

/// Where voxel (0, 0, 0) of `part` lies in `whole`, when part's voxels are some of whole's (same spacing,
/// axes in the same order); empty when they are not.
std::optional<std::array<std::ptrdiff_t, 3>> offset_in(const VoxelGrid& whole, const VoxelGrid& part);

}  // namespace calot
