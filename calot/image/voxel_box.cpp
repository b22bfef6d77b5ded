#include "calot/image/voxel_box.h"

#include <algorithm>

namespace calot {

VoxelBox padded(const VoxelBox& box, const VoxelSize& by, const VoxelSize& limit) {
  if (box.empty()) return box;
  VoxelBox larger;
  for (std::size_t d = 0; d < 3; ++d) {
    larger.first[d] = box.first[d] - std::min(box.first[d], by[d]);
    larger.last[d] = std::min(box.last[d] + by[d], limit[d]);
  }
  return larger;
}

VoxelBox joined(const VoxelBox& a, const VoxelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  VoxelBox both;
  for (std::size_t d = 0; d < 3; ++d) {
    both.first[d] = std::min(a.first[d], b.first[d]);
    both.last[d] = std::max(a.last[d], b.last[d]);
  }
  return both;
}

std::array<VoxelBox, 256> boxes_of(const std::vector<std::uint8_t>& labels, const VoxelSize& size) {
  std::array<VoxelBox, 256> boxes;
  for (std::size_t k = 0; k < size[2]; ++k)
    for (std::size_t j = 0; j < size[1]; ++j) {
      const std::size_t row = size[0] * (j + size[1] * k);
      for (std::size_t i = 0; i < size[0];) {  // runs of one label
        const std::uint8_t label = labels[row + i];
        std::size_t end = i + 1;
        while (end < size[0] && labels[row + end] == label) ++end;
        boxes[label] = joined(boxes[label], {{i, j, k}, {end, j + 1, k + 1}});
        i = end;
      }
    }
  return boxes;
}

}  // namespace calot
