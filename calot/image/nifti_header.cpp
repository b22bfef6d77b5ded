#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <pugixml.hpp>

#include "calot/base/error.h"
#include "calot/image/nifti.h"

namespace calot {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::size_t largest_offset = std::size_t{16} << 20;  // of the voxels: header and extensions
constexpr std::size_t largest_count = std::size_t{1} << 31;    // of voxels

/// Numbers at byte offsets, in either byte order.
class Fields {
 public:
  Fields(std::string_view bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + offset, sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

 private:
  std::string_view bytes_;
  bool swapped_;
};

ScalarType scalar_type(int datatype, const std::string& where) {
  switch (datatype) {
    case 2:
      return ScalarType::uint8;
    case 4:
      return ScalarType::int16;
    case 8:
      return ScalarType::int32;
    case 16:
      return ScalarType::float32;
    case 64:
      return ScalarType::float64;
    case 256:
      return ScalarType::int8;
    case 512:
      return ScalarType::uint16;
    case 768:
      return ScalarType::uint32;
    case 1024:
      return ScalarType::int64;
    case 1280:
      return ScalarType::uint64;
    default:
      throw InputError(where,
                       "has voxels of NIfTI type " + std::to_string(datatype) + ", which aren't single real numbers",
                       "export it with one whole number a voxel");
  }
}

std::array<std::size_t, 3> read_size(const Fields& fields, const std::string& where) {
  const auto dim = [&](std::size_t d) { return fields.at<std::int16_t>(40 + 2 * d); };
  if (dim(0) < 1 || dim(0) > 7)
    throw InputError(where, "says that it has " + std::to_string(dim(0)) + " dimensions", "export the file again");
  for (int d = 4; d <= dim(0); ++d)
    if (dim(d) > 1)
      throw InputError(
          where, "has " + std::to_string(dim(0)) + " dimensions (" + std::to_string(dim(d)) + " volumes), not three",
          "export one volume, with one number a voxel");
  std::array<std::size_t, 3> size{};
  for (std::size_t d = 0; d < 3; ++d) {
    const int n = static_cast<int>(d) < dim(0) ? dim(d + 1) : 1;
    if (n < 1)
      throw InputError(where, "says that it has " + std::to_string(n) + " voxels along an axis",
                       "export the file again");
    size[d] = static_cast<std::size_t>(n);
  }
  if (size[0] * size[1] * size[2] > largest_count)
    throw InputError(where, "says that it has more than 2^31 voxels", "crop or resample it");
  return size;
}

Eigen::Affine3d qform(const Fields& fields) {
  const double b = fields.at<float>(256), c = fields.at<float>(260), d = fields.at<float>(264);
  // A half turn has a = 0; what single precision leaves of 1 − b² − c² − d² must not become an angle.
  const double rest = 1 - b * b - c * c - d * d;
  const double a = rest < 3 * std::numeric_limits<float>::epsilon() ? 0.0 : std::sqrt(rest);
  const double handed = fields.at<float>(76) < 0 ? -1 : 1;
  const Eigen::Vector3d spacing(fields.at<float>(80), fields.at<float>(84), handed * fields.at<float>(88));
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() = Eigen::Quaterniond(a, b, c, d).normalized().toRotationMatrix() * spacing.asDiagonal();
  affine.translation() = Eigen::Vector3d(fields.at<float>(268), fields.at<float>(272), fields.at<float>(276));
  return affine;
}

Eigen::Affine3d sform(const Fields& fields) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      affine(row, column) = fields.at<float>(static_cast<std::size_t>(280 + 16 * row + 4 * column));
  return affine;
}

double metres_per_unit(const Fields& fields) {
  switch (fields.at<std::uint8_t>(123) & 7) {
    case 1:
      return 1;
    case 3:
      return 1e-6;
    default:
      return 1e-3;  // millimetres, also where the file doesn't say: every tool we know means them
  }
}

Eigen::Affine3d read_affine(const Fields& fields, const std::string& where) {
  const bool has_sform = fields.at<std::int16_t>(254) > 0, has_qform = fields.at<std::int16_t>(252) > 0;
  if (!has_sform && !has_qform)
    throw InputError(where,
                     "doesn't say how it is oriented (sform_code and qform_code are 0), so left and right are unknown",
                     "export it again with its orientation");
  Eigen::Affine3d affine = has_sform ? sform(fields) : qform(fields);
  affine = Eigen::Scaling(metres_per_unit(fields)) * affine;
  check_axes(affine, where);
  return affine;
}

std::size_t voxel_offset(const Fields& fields, const std::string& where) {
  const float offset = fields.at<float>(108);
  if (!(offset >= 0 && offset <= static_cast<float>(largest_offset)))
    throw InputError(where, "says that its voxels begin at byte " + std::to_string(offset), "export the file again");
  return std::max<std::size_t>(nifti_header_size + 4, static_cast<std::size_t>(offset));
}

void add_name(const pugi::xml_node& node, std::map<Label, std::string>& names, const std::string& where) {
  const std::string key = node.attribute("Key").value();
  Label label = 0;
  const auto [end, code] = std::from_chars(key.data(), key.data() + key.size(), label);
  if (key.empty() || code != std::errc() || end != key.data() + key.size())
    throw InputError(
        where, "the label names in its header have the key \"" + key.substr(0, 40) + "\", not a number in 0 … 65535",
        "export the segmentation again");
  const std::string name = node.text().get();
  if (label != 0 && !name.empty()) names[label] = name;
}

void read_names(std::string_view text, std::map<Label, std::string>& names, const std::string& where) {
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
  pugi::xml_document document;
  const auto result = document.load_buffer(text.data(), text.size());
  if (!result)
    throw InputError(where,
                     std::string("the label names in its header aren't well-formed XML: ") + result.description(),
                     "export the segmentation again");
  for (const auto& volume : document.child("CaretExtension").children("VolumeInformation"))
    for (const auto& table : volume.children("LabelTable"))
      for (const auto& label : table.children("Label")) add_name(label, names, where);
}

}  // namespace

std::map<Label, std::string> label_names_in_extensions(std::string_view bytes, bool swapped, const std::string& where) {
  std::map<Label, std::string> names;
  if (bytes.size() < 4 || bytes[0] == 0) return names;
  const Fields fields(bytes, swapped);
  for (std::size_t begin = 4; begin + 8 <= bytes.size();) {
    const auto size = fields.at<std::int32_t>(begin);
    if (size < 8 || static_cast<std::size_t>(size) > bytes.size() - begin)
      throw InputError(where,
                       "a header extension says that it has " + std::to_string(size) + " bytes, which doesn't fit",
                       "export the file again");
    const std::string_view content = bytes.substr(begin + 8, static_cast<std::size_t>(size) - 8);
    if (content.find("<CaretExtension") != std::string_view::npos) read_names(content, names, where);
    begin += static_cast<std::size_t>(size);
  }
  return names;
}

bool nifti_is_swapped(std::string_view head, const std::string& where) {
  const std::string advice = "give a NIfTI-1 file (.nii or .nii.gz)";
  if (head.size() < nifti_header_size) throw InputError(where, "is too short to be NIfTI", advice);
  const auto size = Fields(head, false).at<std::int32_t>(0), turned = Fields(head, true).at<std::int32_t>(0);
  if (size == 540 || turned == 540) throw InputError(where, "is NIfTI-2", "convert it to NIfTI-1");
  if (size != nifti_header_size && turned != nifti_header_size) throw InputError(where, "is not NIfTI", advice);
  const std::string_view mark = head.substr(344, 4);
  if (mark == std::string_view("ni1\0", 4))
    throw InputError(where, "is one half of a .hdr/.img pair", "convert the pair to .nii.gz");
  if (mark != std::string_view("n+1\0", 4)) throw InputError(where, "is not NIfTI (no \"n+1\" mark)", advice);
  return size != nifti_header_size;
}

NiftiHeader parse_nifti_header(std::string_view head, const std::string& where) {
  NiftiHeader header;
  header.stored.swapped = nifti_is_swapped(head, where);
  const Fields fields(head, header.stored.swapped);
  header.grid.size = read_size(fields, where);
  header.stored.type = scalar_type(fields.at<std::int16_t>(70), where);
  const float slope = fields.at<float>(112), intercept = fields.at<float>(116);
  if (std::isfinite(slope) && slope != 0 && std::isfinite(intercept)) {
    header.stored.slope = slope;
    header.stored.intercept = intercept;
  }
  header.grid.to_world = read_affine(fields, where);
  header.voxel_offset = voxel_offset(fields, where);
  return header;
}

}  // namespace calot
