// From one grid to another along the same axes.
#pragma once
#include "calot/image/volume.h"
#include "calot/image/voxel_box.h"

namespace calot {

/// Where the voxels of `to` lie in `from`, axis by axis; the axes must be parallel.
class AxisMap {
 public:
  AxisMap(const VoxelGrid& from, const VoxelGrid& to);

  /// Coordinate in `from` of voxel o of `to`.
  [[nodiscard]] double at(std::size_t axis, std::size_t o) const {
    return first_[axis] + step_[axis] * static_cast<double>(o);
  }
  struct Linear {
    std::size_t low, high;
    float part;  ///< of `high`
  };
  /// Neighbours along an axis, clamped to the ends.
  [[nodiscard]] std::vector<Linear> linear(std::size_t axis) const;
  struct Cubic {
    std::array<std::size_t, 4> from;
    std::array<float, 4> weight;
  };
  /// Catmull-Rom weights for voxels [begin, end) of `to`, with neighbours counted from `origin` and clamped to `size`.
  [[nodiscard]] std::vector<Cubic> cubic(std::size_t axis, std::size_t begin, std::size_t end, std::size_t origin,
                                         std::size_t size) const;
  [[nodiscard]] std::vector<std::size_t> nearest(std::size_t axis) const;
  /// Whether a voxel's centre lies in a voxel of `from`.
  [[nodiscard]] bool inside(std::size_t i, std::size_t j, std::size_t k) const;
  /// The voxels of `to` whose centres lie in a box of `from`, a voxel of `from` more on every side.
  [[nodiscard]] VoxelBox covered(const VoxelBox& box) const;

 private:
  VoxelSize from_size_, to_size_;
  std::array<double, 3> first_{}, step_{};
};

/// Values on a box of `from` (in box order), interpolated (Catmull-Rom) on a box of `to`. Threads don't matter.
std::vector<float> interpolated(const std::vector<float>& values, const VoxelBox& from_box, const VoxelBox& to_box,
                                const AxisMap& map);

}  // namespace calot
