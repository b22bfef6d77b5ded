// Inside this room only. Segments on their way into layers.
#pragma once
#include "calot/image/nrrd.h"
#include "calot/image/placement.h"
#include "calot/image/segmentation.h"

namespace calot {

/// What read_segmentation does for each kind of input. The result's layers are on the file's own grid, and its
/// segments, declared by the file, not yet counted; `finish` does the rest.
Segmentation read_nifti_segments(const std::filesystem::path& path, const SegmentationOptions& options,
                                 Progress& progress);
Segmentation read_nrrd_segments(const std::filesystem::path& path, const SegmentationOptions& options,
                                Progress& progress);
/// One file a class, on the reference if there is one.
Segmentation read_masks(const std::vector<std::filesystem::path>& files, const SegmentationOptions& options,
                        Progress& progress);
Segmentation read_surfaces(const std::vector<std::filesystem::path>& files, const SegmentationOptions& options,
                           Progress& progress);

/// How values of one grid get onto the reference: as they are, moved voxel by voxel, or resampled.
class ToReference {
 public:
  /// Throws InputError, beginning with `where`, where the grids don't fit and resampling isn't allowed.
  ToReference(const VoxelGrid& from, const SegmentationOptions& options, const std::string& where,
              std::vector<std::string>& notes);
  [[nodiscard]] const VoxelGrid& grid() const { return to_; }
  template <class T>
  [[nodiscard]] std::vector<T> apply(std::vector<T> values) const {
    if (as_it_is_) return values;
    return placement_ ? placed(values, from_, to_, *placement_) : resampled(values, from_, to_);
  }

 private:
  VoxelGrid from_, to_;
  bool as_it_is_ = false;
  std::optional<Placement> placement_;
};

/// Packs masks into layers: each into the first layer where it overlaps nothing.
class LayerPacker {
 public:
  explicit LayerPacker(Segmentation& into) : into_(into) {}
  /// @param mask  grid.count() values, of which those ≠ 0 belong to the segment
  void add(const std::vector<std::uint8_t>& mask, const std::string& name, const std::string& source);

 private:
  Segmentation& into_;
};

/// A file's name without its folders and endings: "liver" for liver.nii.gz.
std::string stem_of(const std::filesystem::path& path);

}  // namespace calot
