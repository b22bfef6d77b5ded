// Inside this room only. NIfTI-1 files: the header with its extensions (which name the labels), and what is wrong with
// one.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "calot/image/label_map.h"
#include "calot/image/voxel_numbers.h"

namespace calot {

inline constexpr int nifti_header_size = 348;

/// What the header says, checked. Source: NIfTI-1.1 header, nifti1.h (2007).
struct NiftiHeader {
  VoxelGrid grid;
  StoredNumbers stored;
  std::size_t voxel_offset = 0;        ///< bytes before the first voxel
  std::map<Label, std::string> names;  ///< from the extensions
};

/// Whether a header has the other byte order. Throws InputError where it is no header of a single-file NIfTI-1.
bool nifti_is_swapped(std::string_view head, const std::string& where);

/// The header's 348 bytes, without the names. Any bytes are safe. Throws InputError, beginning with `where`, for
/// everything that `read_label_map` lists, but names and voxels.
NiftiHeader parse_nifti_header(std::string_view head, const std::string& where);

/// Reads the header of a file with its names, and leaves the file at the first voxel.
NiftiHeader read_nifti_header(ByteSource& source);

/// The names of labels in the extensions of a header: the bytes from 348 up to the voxels. Any bytes are safe.
/// @param swapped  the file has the other byte order
/// Throws InputError, beginning with `where`, for sizes that don't fit and XML or keys that can't be read.
std::map<Label, std::string> label_names_in_extensions(std::string_view bytes, bool swapped, const std::string& where);

/// A CaretExtension with these names, as a whole NIfTI extension (size and code included, a multiple of 16 bytes).
std::string label_names_extension(const std::map<Label, std::string>& names);

}  // namespace calot
