// Smooth regions from a label map: what the mesher asks which organ a point belongs to.
#pragma once
#include <string>
#include <vector>

#include "calot/image/label_map.h"
#include "calot/image/voxel_parts.h"
#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Chosen labels of a map, cropped and padded, each reduced to its largest part, as smooth fields: the one-hot field of
/// every label is smoothed with a Gaussian and interpolated trilinearly, and a point belongs to the label with the
/// largest value. Points are local [m]: the cropped grid's axes, voxel (0, 0, 0) at the origin. Regions count from 1 in
/// the order of `labels`; 0 is outside.
class LabelField {
 public:
  /// @param sigma  of the Gaussian, in voxels, 0 … 2 (0: none)
  /// Throws InputError if a label has no voxels.
  LabelField(const LabelMap& map, const std::vector<Label>& labels, double sigma);

  [[nodiscard]] int at(const Vec3& point) const;
  /// Moves the boundaries of the regions outwards (b > 0) or inwards: added to the region's field before comparing,
  /// where there is a trace of the region at all. Differences between neighbours within −0.5 … 0.5.
  void set_bias(std::size_t region, double bias) { bias_[region] = static_cast<float>(bias); }
  [[nodiscard]] double bias(std::size_t region) const { return bias_[region]; }

  [[nodiscard]] const std::vector<Label>& labels() const { return labels_; }
  [[nodiscard]] const std::vector<RegionCleaning>& cleaning() const { return cleaning_; }  ///< one a label
  [[nodiscard]] const std::array<std::size_t, 3>& size() const { return size_; }
  [[nodiscard]] const Vec3& spacing() const { return spacing_; }                       ///< [m]
  [[nodiscard]] const std::vector<std::uint8_t>& regions() const { return regions_; }  ///< of the voxels, cleaned
  [[nodiscard]] const Eigen::Affine3d& to_world() const { return to_world_; }          ///< local → RAS [m]
  [[nodiscard]] std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
    return i + size_[0] * (j + size_[1] * k);
  }

 private:
  void crop(const LabelMap& map);
  void clean();
  void mark_mixed(std::ptrdiff_t reach);
  void smooth(double sigma);

  std::vector<Label> labels_;
  std::vector<RegionCleaning> cleaning_;
  std::array<std::size_t, 3> size_{};
  Vec3 spacing_;
  Eigen::Affine3d to_world_;
  std::vector<std::uint8_t> regions_;  // of every voxel
  std::vector<std::uint32_t> slot_;    // of every voxel: row in values_, or none where the surroundings are one region
  std::vector<float> values_;          // rows of labels + 1 smoothed one-hot values
  std::vector<float> bias_;            // labels + 1
};

}  // namespace calot
