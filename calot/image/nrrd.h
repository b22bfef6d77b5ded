// Inside this room only. NRRD files: headers and numbers, and the segments that 3D Slicer writes into them.
// Source: "Definition of NRRD File Format" of the Teem project.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calot/image/voxel_numbers.h"

namespace calot {

/// What a header says, checked.
struct NrrdHeader {
  VoxelGrid grid;              ///< of the three axes in space
  std::size_t components = 1;  ///< along the axis that is not in space: 3D Slicer's layers
  bool components_first = true;
  StoredNumbers stored;
  bool packed = false;                       ///< gzip
  std::string data_file;                     ///< beside the header; empty: behind it, in the same file
  std::uint64_t line_skip = 0;               ///< lines before the numbers
  std::int64_t byte_skip = 0;                ///< bytes before them; −1: the numbers are the last bytes
  std::map<std::string, std::string> pairs;  ///< key := value
};

/// A segment of a .seg.nrrd as its header describes it.
struct NrrdSegment {
  std::string name;
  Label value = 1;
  std::size_t layer = 0;
  std::optional<std::array<std::int64_t, 6>> extent;  ///< first and last voxel along i, j, k
};

/// A header's text, up to the empty line behind it. Any bytes are safe. Throws InputError naming `where`, line and
/// field for what is wrong, missing or not supported.
NrrdHeader parse_nrrd_header(std::string_view text, const std::string& where);

/// The segments of a header in their order; none where it has no Segment0_ID or Segment0_Name.
std::vector<NrrdSegment> nrrd_segments(const NrrdHeader& header, const std::string& where);

/// A file with its numbers not yet read.
struct NrrdFile {
  NrrdHeader header;
  std::filesystem::path data;          ///< the file that holds the numbers
  std::unique_ptr<ByteSource> source;  ///< stands before the first number
};
/// Opens an attached (.nrrd) or detached (.nhdr) file.
NrrdFile open_nrrd(const std::filesystem::path& path);

}  // namespace calot
