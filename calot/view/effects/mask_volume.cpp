#include "calot/view/effects/mask_volume.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/view/effects/noise.h"

namespace calot {
namespace {

constexpr int brick_edge = 8;
constexpr std::size_t most_boxes = 16;

int bricks_for(int voxels) {
  return (voxels + brick_edge - 1) / brick_edge;
}

VoxelBlock joined(const VoxelBlock& a, const VoxelBlock& b) {
  VoxelBlock both;
  for (std::size_t i = 0; i < 3; ++i) {
    both.first[i] = std::min(a.first[i], b.first[i]);
    both.size[i] = std::max(a.first[i] + a.size[i], b.first[i] + b.size[i]) - both.first[i];
  }
  return both;
}

long long voxels_of(const VoxelBlock& block) {
  return 1LL * block.size[0] * block.size[1] * block.size[2];
}

/// Joins the pair that wastes least until few enough are left.
void join_cheapest(std::vector<VoxelBlock>& boxes) {
  while (boxes.size() > most_boxes) {
    std::size_t best_a = 0, best_b = 1;
    long long least = -1;
    for (std::size_t a = 0; a < boxes.size(); ++a)
      for (std::size_t b = a + 1; b < boxes.size(); ++b) {
        const long long waste = voxels_of(joined(boxes[a], boxes[b])) - voxels_of(boxes[a]) - voxels_of(boxes[b]);
        if (least >= 0 && waste + (1LL << 40U) >= least) continue;
        least = waste + (1LL << 40U);
        best_a = a;
        best_b = b;
      }
    boxes[best_a] = joined(boxes[best_a], boxes[best_b]);
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(best_b));
  }
}

}  // namespace

MaskVolume::MaskVolume(const Eigen::AlignedBox3f& box, float voxel, std::size_t most_bytes) : voxel_(voxel) {
  if (box.isEmpty() || !box.min().allFinite() || !box.max().allFinite())
    throw InputError("mask", "its box is empty", "give the tissue's box at rest");
  if (!(voxel > 0) || !std::isfinite(voxel) || most_bytes < 4 * 4096)
    throw InputError("mask", "a voxel or the memory is not above 0", "give metres, and at least 16 KiB");
  const auto fit = [&] {
    double bytes = 4;
    for (int i = 0; i < 3; ++i) bytes *= std::max(1.0, std::ceil(static_cast<double>(box.sizes()[i] / voxel_)));
    return bytes <= static_cast<double>(most_bytes);
  };
  while (!fit()) voxel_ *= 1.02F;
  for (int i = 0; i < 3; ++i)
    size_[static_cast<std::size_t>(i)] = std::max(1, static_cast<int>(std::ceil(box.sizes()[i] / voxel_)));
  for (std::size_t i = 0; i < 3; ++i) bricks_[i] = bricks_for(size_[i]);
  const Vec3f whole =
      voxel_ * Vec3f(static_cast<float>(size_[0]), static_cast<float>(size_[1]), static_cast<float>(size_[2]));
  origin_ = box.center() - 0.5F * whole;
  bytes_.assign(
      4 * static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]),
      0);
  changed_.assign(static_cast<std::size_t>(bricks_[0]) * static_cast<std::size_t>(bricks_[1]) *
                      static_cast<std::size_t>(bricks_[2]),
                  0);
}

MaskVolume::Vec3f MaskVolume::texture_scale() const {
  if (bytes_.empty()) return Vec3f::Zero();
  return Vec3f(1 / (voxel_ * static_cast<float>(size_[0])), 1 / (voxel_ * static_cast<float>(size_[1])),
               1 / (voxel_ * static_cast<float>(size_[2])));
}

std::size_t MaskVolume::offset(int x, int y, int z) const {
  return 4 * (static_cast<std::size_t>(x) +
              static_cast<std::size_t>(size_[0]) *
                  (static_cast<std::size_t>(y) + static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(z)));
}

std::uint8_t* MaskVolume::at(int x, int y, int z) {
  if (x < 0 || y < 0 || z < 0 || x >= size_[0] || y >= size_[1] || z >= size_[2]) return nullptr;
  return &bytes_[offset(x, y, z)];
}

const std::uint8_t* MaskVolume::at(int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0 || x >= size_[0] || y >= size_[1] || z >= size_[2]) return nullptr;
  return &bytes_[offset(x, y, z)];
}

std::uint32_t MaskVolume::brick_of(int x, int y, int z) const {
  return static_cast<std::uint32_t>(x / brick_edge + bricks_[0] * (y / brick_edge + bricks_[1] * (z / brick_edge)));
}

void MaskVolume::touch(int x, int y, int z) {
  touch_brick(brick_of(x, y, z));
}

void MaskVolume::touch_brick(std::uint32_t index) {
  if (changed_[index] == 0) used_.push_back(index);
  changed_[index] = ++version_;
}

VoxelBlock MaskVolume::brick(std::uint32_t index) const {
  const auto i = static_cast<int>(index);
  VoxelBlock block;
  block.first = {i % bricks_[0] * brick_edge, i / bricks_[0] % bricks_[1] * brick_edge,
                 i / (bricks_[0] * bricks_[1]) * brick_edge};
  for (std::size_t k = 0; k < 3; ++k) block.size[k] = std::min(brick_edge, size_[k] - block.first[k]);
  return block;
}

std::vector<VoxelBlock> MaskVolume::dirty_boxes(std::uint64_t since) const {
  std::vector<VoxelBlock> boxes;
  if (bytes_.empty()) return boxes;
  if (since == 0 || since > version_) return {{{0, 0, 0}, size_}};
  // Runs of bricks along x first: what is painted lies together.
  for (int z = 0; z < bricks_[2]; ++z)
    for (int y = 0; y < bricks_[1]; ++y) {
      VoxelBlock run;
      for (int x = 0; x < bricks_[0]; ++x) {
        const auto index = static_cast<std::uint32_t>(x + bricks_[0] * (y + bricks_[1] * z));
        if (changed_[index] <= since) continue;
        run = run.size[0] == 0 ? brick(index) : joined(run, brick(index));
      }
      if (run.size[0] == 0) continue;
      boxes.push_back(run);
      if (boxes.size() > 2 * most_boxes) join_cheapest(boxes);
    }
  join_cheapest(boxes);
  return boxes;
}

MaskVolume::Vec3f MaskVolume::middle(int x, int y, int z) const {
  return origin_ +
         voxel_ * Vec3f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, static_cast<float>(z) + 0.5F);
}

VoxelBlock MaskVolume::around(const Vec3f& rest, const Vec3f& extent) const {
  VoxelBlock block;
  if (bytes_.empty() || !rest.allFinite() || !extent.allFinite()) return block;
  const Vec3f low = (rest - origin_ - extent) / voxel_, high = (rest - origin_ + extent) / voxel_;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<int>(i);
    const auto most = static_cast<float>(size_[i]);
    const int first = static_cast<int>(std::ceil(std::clamp(low[k] - 0.5F, 0.0F, most)));
    const int last = static_cast<int>(std::floor(std::clamp(high[k] - 0.5F, -1.0F, most - 1)));
    if (last < first) return {};
    block.first[i] = first;
    block.size[i] = last - first + 1;
  }
  return block;
}

Eigen::Vector4f MaskVolume::sample(const Vec3f& rest) const {
  Eigen::Vector4f sum = Eigen::Vector4f::Zero();
  if (bytes_.empty() || !rest.allFinite()) return sum;
  const Vec3f p = (rest - origin_) / voxel_;
  for (int i = 0; i < 3; ++i)
    if (p[i] < 0 || p[i] > static_cast<float>(size_[static_cast<std::size_t>(i)])) return sum;
  const Vec3f q = p - Vec3f::Constant(0.5F);
  const std::array<int, 3> low{static_cast<int>(std::floor(q[0])), static_cast<int>(std::floor(q[1])),
                               static_cast<int>(std::floor(q[2]))};
  for (int k = 0; k < 8; ++k) {
    float weight = 1;
    std::array<int, 3> v{};
    for (int i = 0; i < 3; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const int upper = (k >> i) & 1;
      const float share = q[i] - static_cast<float>(low[s]);
      weight *= upper != 0 ? share : 1 - share;
      v[s] = std::clamp(low[s] + upper, 0, size_[s] - 1);
    }
    const std::uint8_t* bytes = at(v[0], v[1], v[2]);
    for (int c = 0; c < 4; ++c) sum[c] += weight * static_cast<float>(bytes[c]);
  }
  return sum;
}

void MaskVolume::paint(MaskChannel channel, const Vec3f& rest, float radius, float value, float grain) {
  const VoxelBlock block = around(rest, radius + voxel_);
  const auto c = static_cast<std::size_t>(channel);
  for (int z = block.first[2]; z < block.first[2] + block.size[2]; ++z)
    for (int y = block.first[1]; y < block.first[1] + block.size[1]; ++y)
      for (int x = block.first[0]; x < block.first[0] + block.size[0]; ++x) {
        const Vec3f p = middle(x, y, z);
        float inside = (radius - (p - rest).norm()) / voxel_ + 0.5F;
        if (grain > 0) inside += grain * detail::value_noise(p / (2 * voxel_), 7) * radius / voxel_;
        const float wanted = value * std::clamp(inside, 0.0F, 1.0F);
        std::uint8_t& now = at(x, y, z)[c];
        if (!(wanted > static_cast<float>(now) + 0.5F)) continue;
        now = static_cast<std::uint8_t>(std::min(255.0F, wanted));
        touch(x, y, z);
      }
}

}  // namespace calot
