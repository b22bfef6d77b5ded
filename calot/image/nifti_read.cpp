// Voxels of NIfTI files. Decoded here, not by ITK: ITK 5.2 refuses sforms whose axes are at right angles only to the
// seven digits that the file stores (docs/decisions/0003-meshing.md).
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "calot/base/error.h"
#include "calot/image/nifti.h"

namespace calot {
namespace {

[[noreturn]] void no_label(const std::string& where, std::size_t voxel, double value) {
  throw InputError(where,
                   "voxel " + std::to_string(voxel) + " has the value " + std::to_string(value) + ", which is no label",
                   "give a segmentation: whole numbers from 0 to 65535");
}

template <class T>
std::vector<Label> labels_of(const NiftiFile& file, const std::string& where) {
  std::vector<Label> labels(file.header.grid.count());
  for (std::size_t v = 0; v < labels.size(); ++v) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), file.voxels.data() + v * sizeof(T), sizeof(T));
    if (file.swapped) std::reverse(raw.begin(), raw.end());
    const double value = file.header.slope * static_cast<double>(std::bit_cast<T>(raw)) + file.header.intercept;
    if (!(value >= 0 && value <= 65535) || value != std::floor(value)) no_label(where, v, value);
    labels[v] = static_cast<Label>(value);
  }
  return labels;
}

/// By NIFTI_TYPE_…; the header was checked to have one of these.
std::vector<Label> decode(const NiftiFile& file, const std::string& where) {
  switch (file.header.datatype) {
    case 2:
      return labels_of<std::uint8_t>(file, where);
    case 4:
      return labels_of<std::int16_t>(file, where);
    case 8:
      return labels_of<std::int32_t>(file, where);
    case 16:
      return labels_of<float>(file, where);
    case 64:
      return labels_of<double>(file, where);
    case 256:
      return labels_of<std::int8_t>(file, where);
    case 512:
      return labels_of<std::uint16_t>(file, where);
    case 768:
      return labels_of<std::uint32_t>(file, where);
    case 1024:
      return labels_of<std::int64_t>(file, where);
    default:
      return labels_of<std::uint64_t>(file, where);
  }
}

}  // namespace

LabelMap read_label_map(const std::filesystem::path& path) {
  NiftiFile file = read_nifti(path);
  return {file.header.grid, decode(file, path.string()), std::move(file.header.names)};
}

}  // namespace calot
