// Inside this room only. Labels of one grid put onto another.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "calot/image/volume.h"

namespace calot {

/// Where the voxels of a part lie in a whole whose voxels are at the same places, whatever the order and the sense of
/// the axes: voxel v of the part is voxel first + Σ step[d]·v[d] of the whole.
struct Placement {
  std::array<std::ptrdiff_t, 3> step{};  ///< in voxel numbers of the whole
  std::ptrdiff_t first = 0;
  double off = 0;  ///< largest distance between a voxel and its counterpart [voxels]
  [[nodiscard]] bool is_identity(const VoxelGrid& whole, const VoxelGrid& part) const;
};

/// Empty where the part has voxels outside the whole or more than a tenth of a voxel from all of its voxels.
std::optional<Placement> placement_in(const VoxelGrid& whole, const VoxelGrid& part);

/// The part's values at their places in the whole, 0 elsewhere.
template <class T>
std::vector<T> placed(const std::vector<T>& part_values, const VoxelGrid& part, const VoxelGrid& whole,
                      const Placement& placement) {
  std::vector<T> values(whole.count());
  std::size_t v = 0;
  for (std::size_t k = 0; k < part.size[2]; ++k)
    for (std::size_t j = 0; j < part.size[1]; ++j) {
      std::ptrdiff_t at = placement.first + placement.step[1] * static_cast<std::ptrdiff_t>(j) +
                          placement.step[2] * static_cast<std::ptrdiff_t>(k);
      for (std::size_t i = 0; i < part.size[0]; ++i, at += placement.step[0])
        values[static_cast<std::size_t>(at)] = part_values[v++];
    }
  return values;
}

/// The value of the voxel of `from` that is nearest to each voxel of `to`; 0 outside of all voxels of `from`.
template <class T>
std::vector<T> resampled(const std::vector<T>& values, const VoxelGrid& from, const VoxelGrid& to);

}  // namespace calot
