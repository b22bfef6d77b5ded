// Connected parts of voxel regions.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace calot {

/// What cleaning did to one region.
struct RegionCleaning {
  std::size_t voxels = 0;  ///< of its largest part (joined through faces), which stays
  std::size_t specks = 0;  ///< other parts
  std::size_t moved = 0;   ///< voxels of those
};

/// Leaves each region 1 … count its largest part, and gives every smaller one to the region (or the outside, 0) that it
/// touches most, so that no hole is left inside another organ.
/// @param regions  size[0]·size[1]·size[2] region numbers, 0 … count
/// @return one a region, from 1; `voxels` counts those that a region got from others too
std::vector<RegionCleaning> keep_largest_parts(std::vector<std::uint8_t>& regions,
                                               const std::array<std::size_t, 3>& size, std::size_t count);

}  // namespace calot
