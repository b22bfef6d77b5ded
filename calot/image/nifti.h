// NIfTI-1 files: the header with its extensions (which name the labels), and what is wrong with one.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "calot/image/label_map.h"

namespace calot {

/// What the header says, checked. Source: NIfTI-1.1 header, nifti1.h (2007).
struct NiftiHeader {
  VoxelGrid grid;
  int datatype = 0;                    ///< NIFTI_TYPE_…, one of the real scalar types
  double slope = 1, intercept = 0;     ///< value = slope · stored + intercept
  std::map<Label, std::string> names;  ///< from the extensions
};

/// A file with its voxels still as they are stored.
struct NiftiFile {
  NiftiHeader header;
  bool swapped = false;  ///< the file has the other byte order
  std::string voxels;    ///< exactly as many bytes as the header's voxels take
};

/// Reads a file, checks its header and that it holds as many voxels as it says.
/// Throws InputError for everything that `read_label_map` lists, but the values of the voxels.
NiftiFile read_nifti(const std::filesystem::path& path);

/// The names of labels in the extensions of a header: the bytes from 348 up to the voxels. Any bytes are safe.
/// @param swapped  the file has the other byte order
/// Throws InputError, beginning with `where`, for sizes that don't fit and XML or keys that can't be read.
std::map<Label, std::string> label_names_in_extensions(std::string_view bytes, bool swapped, const std::string& where);

/// A CaretExtension with these names, as a whole NIfTI extension (size and code included, a multiple of 16 bytes).
std::string label_names_extension(const std::map<Label, std::string>& names);

}  // namespace calot
