// Label maps: which organ each voxel belongs to.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calot/image/volume.h"

namespace calot {

using Label = std::uint16_t;

/// A segmentation. Label 0 is background.
struct LabelMap {
  VoxelGrid grid;
  std::vector<Label> voxels;           ///< grid.count() labels
  std::map<Label, std::string> names;  ///< names of labels, where the file gives them
};

/// Reads a NIfTI-1 label map (.nii, .nii.gz) in any orientation. The affine is the file's sform, or its qform where
/// there is no sform. Names come from the header extension (CaretExtension XML, as TotalSegmentator and Connectome
/// Workbench write it). Throws InputError: missing, not NIfTI, truncated, damaged names, more than three dimensions, no
/// orientation, a sheared or singular affine, values that aren't whole numbers in 0 … 65535.
LabelMap read_label_map(const std::filesystem::path& path);

/// Writes a label map as NIfTI-1 (.nii, .nii.gz) with its names in the header extension; the same map gives the same
/// bytes.
void write_label_map(const std::filesystem::path& path, const LabelMap& map);
/// Writes a CT image as NIfTI-1 (int16, HU).
void write_ct(const std::filesystem::path& path, const CtImage& ct);

/// How many voxels each label but 0 has.
std::map<Label, std::size_t> voxel_counts(const LabelMap& map);

/// "4 (gallbladder)", or "4" where the label has no name.
std::string label_text(const LabelMap& map, Label label);

/// The label that a name or a number stands for. Throws InputError, listing what the map has, when it has no such
/// voxels or the name is ambiguous.
/// @param where  what the message starts with, e.g. the file and option
Label label_matching(const LabelMap& map, const std::string& name, const std::string& where);

}  // namespace calot
