// Blood, char, bile and wetness painted on tissue: a small volume of voxels in the rest shape, so that motion and cuts
// leave it alone.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace calot {

enum class MaskChannel : std::uint8_t { blood, charred, bile, wet };

/// A block of voxels: [first, first + size).
struct VoxelBlock {
  std::array<int, 3> first{}, size{};
};

/// RGBA8 voxels, x fastest: red blood, green char, blue bile, alpha wet. The value of a voxel belongs to its middle.
class MaskVolume {
 public:
  using Vec3f = Eigen::Vector3f;

  MaskVolume() = default;
  /// Voxels of `voxel` [m] over a box at rest, larger ones if it took more than `most_bytes`.
  /// Throws InputError for an empty box or a voxel that isn't above 0.
  MaskVolume(const Eigen::AlignedBox3f& box, float voxel, std::size_t most_bytes);

  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }  ///< voxels; zeros where there is no volume
  [[nodiscard]] const std::uint8_t* data() const { return bytes_.data(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_.size(); }
  [[nodiscard]] float voxel() const { return voxel_; }           ///< edge [m]
  [[nodiscard]] const Vec3f& origin() const { return origin_; }  ///< lowest corner of voxel 0, 0, 0 [m]
  /// Texture coordinates 0 … 1 of a place at rest = (p − origin) ∘ texture_scale.
  [[nodiscard]] Vec3f texture_scale() const;
  [[nodiscard]] Vec3f texture_place(const Vec3f& rest) const { return (rest - origin_).cwiseProduct(texture_scale()); }

  /// Grows with every change.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  /// What changed after `since` (0, or a version that it never had: all of it), at most 16 boxes that may hold
  /// unchanged voxels too.
  [[nodiscard]] std::vector<VoxelBlock> dirty_boxes(std::uint64_t since) const;

  /// A voxel, or null outside.
  [[nodiscard]] std::uint8_t* at(int x, int y, int z);
  [[nodiscard]] const std::uint8_t* at(int x, int y, int z) const;
  /// To be called for every voxel that was written to.
  void touch(int x, int y, int z);
  /// Trilinear, as the renderer sees it, each channel 0 … 255; zeros outside.
  [[nodiscard]] Eigen::Vector4f sample(const Vec3f& rest) const;
  /// Voxels whose middles lie within a box around a place, `extent` ≥ 0 to each side; of size 0 outside.
  [[nodiscard]] VoxelBlock around(const Vec3f& rest, const Vec3f& extent) const;
  [[nodiscard]] VoxelBlock around(const Vec3f& rest, float radius) const {
    return around(rest, Vec3f(Vec3f::Constant(radius)));
  }
  [[nodiscard]] Vec3f middle(int x, int y, int z) const;

  /// Raises channels towards `value` (0 … 255) within a soft ball; `grain` 0 … 1 roughens its edge with noise.
  void paint(MaskChannel channel, const Vec3f& rest, float radius, float value, float grain = 0);
  /// Bricks of 8³ voxels that hold anything, in order of first touch.
  [[nodiscard]] const std::vector<std::uint32_t>& used_bricks() const { return used_; }
  [[nodiscard]] VoxelBlock brick(std::uint32_t index) const;
  /// A change to one brick's voxels is known.
  void touch_brick(std::uint32_t index);

 private:
  [[nodiscard]] std::size_t offset(int x, int y, int z) const;
  [[nodiscard]] std::uint32_t brick_of(int x, int y, int z) const;

  std::array<int, 3> size_{}, bricks_{};
  float voxel_ = 0;
  Vec3f origin_ = Vec3f::Zero();
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint64_t> changed_;  // version of the last change of each brick; 0: never
  std::vector<std::uint32_t> used_;
  std::uint64_t version_ = 1;
};

}  // namespace calot
