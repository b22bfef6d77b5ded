#include "calot/image/morphology.h"

#include <algorithm>
#include <cmath>

#include "calot/image/distance_map.h"

namespace calot {
namespace {

// A voxel exactly at the radius counts, whatever rounding says.
bool within(float distance, double radius) {
  return static_cast<double>(distance) <= radius * (1 + 1e-5);
}

template <class Visit>
void for_corner_neighbours(std::size_t v, const VoxelSize& size, const Visit& visit) {
  const auto i = static_cast<std::ptrdiff_t>(v % size[0]), j = static_cast<std::ptrdiff_t>(v / size[0] % size[1]),
             k = static_cast<std::ptrdiff_t>(v / (size[0] * size[1]));
  const auto in = [](std::ptrdiff_t x, std::size_t n) { return x >= 0 && x < static_cast<std::ptrdiff_t>(n); };
  for (std::ptrdiff_t c = k - 1; c <= k + 1; ++c)
    for (std::ptrdiff_t b = j - 1; b <= j + 1; ++b)
      for (std::ptrdiff_t a = i - 1; a <= i + 1; ++a)
        if (in(a, size[0]) && in(b, size[1]) && in(c, size[2]))
          visit(static_cast<std::size_t>(a) +
                size[0] * (static_cast<std::size_t>(b) + size[1] * static_cast<std::size_t>(c)));
}

/// Turns the voxels of one part from `from` into `to`.
std::vector<std::size_t> take_part(Mask& mask, std::size_t first, std::uint8_t to, const VoxelSize& size,
                                   Joined joined) {
  const std::uint8_t from = mask[first];
  std::vector<std::size_t> part{first};
  mask[first] = to;
  const auto add = [&](std::size_t w) {
    if (mask[w] != from) return;
    mask[w] = to;
    part.push_back(w);
  };
  for (std::size_t p = 0; p < part.size(); ++p) {
    if (joined == Joined::by_faces)
      for_face_neighbours(part[p], size, add);
    else
      for_corner_neighbours(part[p], size, add);
  }
  return part;
}

bool on_border(std::size_t v, const VoxelSize& size) {
  const std::size_t i = v % size[0], j = v / size[0] % size[1], k = v / (size[0] * size[1]);
  return i == 0 || i + 1 == size[0] || j == 0 || j + 1 == size[1] || k == 0 || k + 1 == size[2];
}

/// The outside that reaches the volume's border becomes 2. Works along rows, so that large volumes stay cheap.
void mark_open_outside(Mask& mask, const VoxelSize& size) {
  std::vector<std::size_t> open;
  const auto start = [&](std::size_t v) {
    if (mask[v] != 0) return;
    mask[v] = 2;
    open.push_back(v);
  };
  for (std::size_t v = 0; v < mask.size(); ++v)
    if (mask[v] == 0 && on_border(v, size)) {
      start(v);
      while (!open.empty()) {
        const std::size_t w = open.back();
        open.pop_back();
        for_face_neighbours(w, size, start);
      }
    }
}

}  // namespace

Mask dilated(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius) {
  const std::vector<float> distance = distance_to_set(mask, size, spacing);
  Mask out(mask.size());
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = within(distance[v], radius) ? 1 : 0;
  return out;
}

Mask eroded(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius) {
  const std::vector<float> distance = distance_to_unset(mask, size, spacing);
  Mask out(mask.size());
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = within(distance[v], radius) ? 0 : 1;
  return out;
}

Mask closed(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius) {
  return eroded(dilated(mask, size, spacing, radius), size, spacing, radius);
}

Mask opened(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, double radius) {
  return dilated(eroded(mask, size, spacing, radius), size, spacing, radius);
}

double face_area(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing) {
  const VoxelSize stride{1, size[0], size[0] * size[1]};
  std::array<std::size_t, 3> faces{};
  std::size_t v = 0;
  for (std::size_t k = 0; k < size[2]; ++k)
    for (std::size_t j = 0; j < size[1]; ++j)
      for (std::size_t i = 0; i < size[0]; ++i, ++v) {
        if (i + 1 < size[0] && mask[v] != mask[v + stride[0]]) ++faces[0];
        if (j + 1 < size[1] && mask[v] != mask[v + stride[1]]) ++faces[1];
        if (k + 1 < size[2] && mask[v] != mask[v + stride[2]]) ++faces[2];
      }
  return static_cast<double>(faces[0]) * spacing[1] * spacing[2] +
         static_cast<double>(faces[1]) * spacing[0] * spacing[2] +
         static_cast<double>(faces[2]) * spacing[0] * spacing[1];
}

std::size_t keep_largest_part(Mask& mask, const VoxelSize& size, Joined joined) {
  std::vector<std::size_t> largest;
  std::size_t parts = 0;
  for (std::size_t v = 0; v < mask.size(); ++v) {
    if (mask[v] != 1) continue;
    std::vector<std::size_t> part = take_part(mask, v, 2, size, joined);
    ++parts;
    if (part.size() > largest.size()) largest.swap(part);
  }
  if (parts <= 1) {
    for (const std::size_t v : largest) mask[v] = 1;
    return 0;
  }
  std::fill(mask.begin(), mask.end(), std::uint8_t{0});
  for (const std::size_t v : largest) mask[v] = 1;
  return parts - 1;
}

std::vector<Hole> holes_in(const Mask& mask, const VoxelSize& size) {
  Mask work = mask;
  mark_open_outside(work, size);
  std::vector<Hole> holes;
  for (std::size_t v = 0; v < work.size(); ++v)
    if (work[v] == 0) holes.push_back({take_part(work, v, 2, size, Joined::by_faces)});
  return holes;
}

}  // namespace calot
