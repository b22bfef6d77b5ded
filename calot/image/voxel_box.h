// Boxes of voxels, and regions cut out of label volumes: what is done to one organ needs only its surroundings.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace calot {

using VoxelSize = std::array<std::size_t, 3>;
using Mask = std::vector<std::uint8_t>;  ///< a byte a voxel, 0 or 1

/// Voxels first … last − 1 along each axis.
struct VoxelBox {
  VoxelSize first{}, last{};

  [[nodiscard]] bool empty() const { return last[0] <= first[0] || last[1] <= first[1] || last[2] <= first[2]; }
  [[nodiscard]] VoxelSize size() const { return {last[0] - first[0], last[1] - first[1], last[2] - first[2]}; }
  [[nodiscard]] std::size_t count() const { return empty() ? 0 : size()[0] * size()[1] * size()[2]; }
};

/// The box made larger by `by` on every side, within a volume of `limit` voxels; an empty box stays empty.
VoxelBox padded(const VoxelBox& box, const VoxelSize& by, const VoxelSize& limit);
/// The smallest box around both.
VoxelBox joined(const VoxelBox& a, const VoxelBox& b);

/// The box of each label 0 … 255.
std::array<VoxelBox, 256> boxes_of(const std::vector<std::uint8_t>& labels, const VoxelSize& size);

/// Calls visit(voxel of the whole, voxel of the box) for every voxel of the box, in order.
template <class Visit>
void for_voxels(const VoxelBox& box, const VoxelSize& size, const Visit& visit) {
  std::size_t inside = 0;
  for (std::size_t k = box.first[2]; k < box.last[2]; ++k)
    for (std::size_t j = box.first[1]; j < box.last[1]; ++j) {
      const std::size_t row = size[0] * (j + size[1] * k);
      for (std::size_t i = box.first[0]; i < box.last[0]; ++i) visit(row + i, inside++);
    }
}

/// Calls visit(w) for the up to six voxels that share a face with voxel v.
template <class Visit>
void for_face_neighbours(std::size_t v, const VoxelSize& size, const Visit& visit) {
  const std::size_t slice = size[0] * size[1], i = v % size[0], j = v / size[0] % size[1], k = v / slice;
  if (i > 0) visit(v - 1);
  if (i + 1 < size[0]) visit(v + 1);
  if (j > 0) visit(v - size[0]);
  if (j + 1 < size[1]) visit(v + size[0]);
  if (k > 0) visit(v - slice);
  if (k + 1 < size[2]) visit(v + slice);
}

/// 1 where test(label) holds, in a box of a volume.
template <class Test>
Mask cut_out(const std::vector<std::uint8_t>& labels, const VoxelSize& size, const VoxelBox& box, const Test& test) {
  Mask mask(box.count());
  for_voxels(box, size, [&](std::size_t v, std::size_t b) { mask[b] = test(labels[v]) ? 1 : 0; });
  return mask;
}

}  // namespace calot
