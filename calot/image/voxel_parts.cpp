#include "calot/image/voxel_parts.h"

#include <algorithm>

#include "calot/image/voxel_box.h"

namespace calot {
namespace {

constexpr std::uint32_t none = 0xffffffffu;

/// Voxels joined through faces where they have the same region; parts are numbered by their first voxel.
struct VoxelParts {
  std::vector<std::uint32_t> of_voxel;
  std::vector<std::size_t> voxels;   // of each part
  std::vector<std::uint8_t> region;  // of each part
};

VoxelParts find_parts(const std::vector<std::uint8_t>& regions, const std::array<std::size_t, 3>& size) {
  VoxelParts parts;
  parts.of_voxel.assign(regions.size(), none);
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < regions.size(); ++first) {
    if (parts.of_voxel[first] != none) continue;
    const auto number = static_cast<std::uint32_t>(parts.voxels.size());
    parts.voxels.push_back(0);
    parts.region.push_back(regions[first]);
    parts.of_voxel[first] = number;
    open.push_back(first);
    while (!open.empty()) {
      const std::size_t v = open.back();
      open.pop_back();
      ++parts.voxels[number];
      for_face_neighbours(v, size, [&](std::size_t w) {
        if (parts.of_voxel[w] != none || regions[w] != regions[v]) return;
        parts.of_voxel[w] = number;
        open.push_back(w);
      });
    }
  }
  return parts;
}

/// The part of each region that has most voxels, the first of equals.
std::vector<std::uint32_t> largest_parts(const VoxelParts& parts, std::size_t count) {
  std::vector<std::uint32_t> largest(count + 1, none);
  for (std::uint32_t p = 0; p < parts.voxels.size(); ++p) {
    std::uint32_t& best = largest[parts.region[p]];
    if (best == none || parts.voxels[p] > parts.voxels[best]) best = p;
  }
  return largest;
}

/// Where each speck goes: the region that most of its outer faces touch.
std::vector<std::uint8_t> receivers(const VoxelParts& parts, const std::vector<std::uint32_t>& row, std::size_t specks,
                                    const std::array<std::size_t, 3>& size, std::size_t width) {
  std::vector<std::size_t> touching(specks * width, 0);
  for (std::size_t v = 0; v < parts.of_voxel.size(); ++v) {
    const std::uint32_t part = parts.of_voxel[v];
    if (row[part] == none) continue;
    for_face_neighbours(v, size, [&](std::size_t w) {
      if (parts.of_voxel[w] != part) ++touching[row[part] * width + parts.region[parts.of_voxel[w]]];
    });
  }
  std::vector<std::uint8_t> receiver(specks);
  for (std::size_t s = 0; s < specks; ++s) {
    const auto begin = touching.begin() + static_cast<std::ptrdiff_t>(s * width);
    receiver[s] =
        static_cast<std::uint8_t>(std::max_element(begin, begin + static_cast<std::ptrdiff_t>(width)) - begin);
  }
  return receiver;
}

}  // namespace

std::vector<RegionCleaning> keep_largest_parts(std::vector<std::uint8_t>& regions,
                                               const std::array<std::size_t, 3>& size, std::size_t count) {
  const VoxelParts parts = find_parts(regions, size);
  const std::vector<std::uint32_t> largest = largest_parts(parts, count);
  std::vector<RegionCleaning> cleaning(count);
  std::vector<std::uint32_t> row(parts.voxels.size(), none);
  std::uint32_t specks = 0;
  for (std::uint32_t p = 0; p < parts.voxels.size(); ++p) {
    if (parts.region[p] == 0 || largest[parts.region[p]] == p) continue;
    row[p] = specks++;
    ++cleaning[parts.region[p] - 1u].specks;
    cleaning[parts.region[p] - 1u].moved += parts.voxels[p];
  }
  const std::vector<std::uint8_t> receiver = receivers(parts, row, specks, size, count + 1);
  for (std::size_t v = 0; v < regions.size(); ++v) {
    if (const std::uint32_t r = row[parts.of_voxel[v]]; r != none) regions[v] = receiver[r];
    if (regions[v] > 0) ++cleaning[regions[v] - 1u].voxels;
  }
  return cleaning;
}

}  // namespace calot
