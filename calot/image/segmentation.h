// Segmentations from files, as they come: segments with names or numbers, which may overlap.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/label_map.h"

namespace calot {

/// One segment: the voxels of layers[layer] that equal `value`.
struct Segment {
  std::string name;  ///< as the file gives it; empty where it has a number only
  Label value = 0;   ///< in its layer
  std::size_t layer = 0;
  std::size_t voxels = 0;
  std::string source;  ///< file that it came from
};

/// Segments on one grid. Where segments overlap they are in different layers.
struct Segmentation {
  VoxelGrid grid;
  std::vector<std::vector<Label>> layers;  ///< each grid.count()
  std::vector<Segment> segments;           ///< with at least one voxel, in the file's order; numbers ascending
  std::vector<std::string> empty;          ///< names (or numbers) that the files list but that have no voxel
  std::vector<std::string> unread;         ///< names that `wanted` turned down: not read, or made background
  std::string format;                      ///< "NIfTI", "NRRD", "3D Slicer .seg.nrrd", "folder of masks", "surfaces"
  std::vector<std::string> inputs;         ///< files that were read, sorted; for provenance
  std::vector<std::string> notes;          ///< for the log
};

struct SegmentationOptions {
  /// Whether a segment of this name is worth reading; spares memory where a folder holds a hundred masks.
  std::function<bool(const std::string& name)> wanted = [](const std::string&) { return true; };
  /// The CT's grid, which the result is then on: surfaces are made into voxels on it; a map whose voxels are the CT's
  /// (to a tenth of a voxel) in another order of axes, or a part of them, is put in place. Empty: surfaces are refused.
  std::optional<VoxelGrid> reference;
  bool resample = false;       ///< put labels of another grid onto `reference` (nearest voxel) instead of refusing them
  double surface_unit = 1e-3;  ///< metres per unit of surface files
};

/// Reads a segmentation:
/// - .nii, .nii.gz: whole numbers; names from the header extension where there are any;
/// - .nrrd, .nhdr: whole numbers; .seg.nrrd with 3D Slicer's Segment0_Name …, layers included (Segment0_Layer,
///   Segment0_LabelValue, Segment0_Extent);
/// - a folder of masks: every .nii, .nii.gz or .nrrd in it is one class, named by its file name, its voxels those ≠ 0;
/// - a surface (.stl, .obj, .ply), or a folder of them: closed surfaces, named by their file names, in RAS millimetres
///   (LPS where the file says SPACE=LPS, as 3D Slicer's do);
///   the voxels whose centres lie inside (parity of crossings; a surface that isn't closed is refused).
/// Throws InputError naming file and field: what `read_label_map` lists, masks of one folder on different grids,
/// duplicate segment names, labels on another grid than `reference` (says how they differ; see `resample`), a folder
/// with neither masks nor surfaces or with both, open surfaces, surfaces outside the reference.
Segmentation read_segmentation(const std::filesystem::path& path, const SegmentationOptions& options,
                               Progress& progress);

}  // namespace calot
