#include "calot/image/dicom_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/image/byte_source.h"
#include "calot/image/dicom_codecs.h"
#include "calot/image/dicom_elements.h"
#include "calot/image/voxel_numbers.h"

namespace calot {
namespace {

constexpr std::size_t usual_header = std::size_t{1} << 16;
constexpr std::uint64_t largest_file = std::uint64_t{4} << 30;

[[noreturn]] void damaged(const std::filesystem::path& path, const std::string& what) {
  throw InputError(path.string(), what, "copy or export the series again, or remove it if it isn't of this series");
}

int whole(const std::vector<double>& numbers, int otherwise) {
  return !numbers.empty() && std::abs(numbers[0]) < 1e9 ? static_cast<int>(numbers[0]) : otherwise;
}

DicomSlice slice_of(const DicomData& data, const std::filesystem::path& path) {
  DicomSlice slice;
  slice.path = path;
  slice.series_uid = data.text(0x0020000e);
  slice.instance_uid = data.text(0x00080018);
  slice.modality = data.text(0x00080060);
  slice.description = data.text(0x0008103e);
  slice.photometric = data.text(0x00280004);
  slice.series_number = whole(data.numbers(0x00200011), 0);
  slice.rows = data.short_number(0x00280010, 0);
  slice.columns = data.short_number(0x00280011, 0);
  slice.frames = whole(data.numbers(0x00280008), 1);
  slice.samples = data.short_number(0x00280002, 1);
  slice.bits_allocated = data.short_number(0x00280100, 0);
  slice.bits_stored = data.short_number(0x00280101, slice.bits_allocated);
  slice.high_bit = data.short_number(0x00280102, slice.bits_stored - 1);
  slice.is_signed = data.short_number(0x00280103, 0) == 1;
  slice.localizer = data.text(0x00080008).find("LOCALIZER") != std::string::npos;
  slice.position = data.numbers(0x00200032);
  slice.orientation = data.numbers(0x00200037);
  slice.spacing = data.numbers(0x00280030);
  slice.slope = data.numbers(0x00281053);
  slice.intercept = data.numbers(0x00281052);
  return slice;
}

template <class T>
T turned(T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// The stored bits as a number: what lies above them may be an old overlay.
template <class T>
void rescale(std::string_view pixels, bool swapped, const PixelLayout& layout, const DicomSlice& slice,
             std::int16_t* hounsfield) {
  const int unused = 64 - layout.bits_stored;
  const double slope = slice.slope.empty() ? 1 : slice.slope[0];
  const double intercept = slice.intercept.empty() ? 0 : slice.intercept[0];
  for (std::size_t p = 0; p < layout.count(); ++p) {
    T value = 0;
    std::memcpy(&value, pixels.data() + p * sizeof(T), sizeof(T));
    if (swapped) value = turned(value);
    const std::uint64_t shifted = static_cast<std::uint64_t>(value) << unused;
    const double stored = layout.is_signed ? static_cast<double>(static_cast<std::int64_t>(shifted) >> unused)
                                           : static_cast<double>(shifted >> unused);
    hounsfield[p] = whole_hounsfield(slope * stored + intercept);
  }
}

PixelLayout layout_of(const DicomSlice& slice, const DicomData& data) {
  const int bits = slice.bits_allocated;
  if ((bits != 8 && bits != 16 && bits != 32) || slice.bits_stored < 1 || slice.bits_stored > bits ||
      slice.high_bit != slice.bits_stored - 1 || (bits == 8 && data.big_endian))
    throw InputError(slice.path.string(),
                     "packs its pixels in an unusual way (BitsAllocated " + std::to_string(bits) + ", BitsStored " +
                         std::to_string(slice.bits_stored) + ", HighBit " + std::to_string(slice.high_bit) + ")",
                     "export the series again");
  return {static_cast<std::size_t>(slice.rows), static_cast<std::size_t>(slice.columns),
          static_cast<std::size_t>(bits / 8), slice.bits_stored, slice.is_signed};
}

}  // namespace

std::optional<DicomSlice> read_dicom_header(const std::filesystem::path& path) {
  std::string bytes(usual_header, '\0');
  bytes.resize(ByteSource(path).read(bytes.data(), bytes.size()));
  const bool marked = has_dicom_mark(bytes);
  auto data = parse_dicom(bytes, true);
  const bool could_be = marked || (bytes.size() > 8 && bytes[0] == 8 && bytes[1] == 0);
  if (could_be && bytes.size() == usual_header && (!data || !data->has_pixels)) {
    bytes = read_file(path, largest_file);  // a long header
    data = parse_dicom(bytes, true);
  }
  if (!data && marked) damaged(path, "is damaged DICOM: it ends within its header");
  if (!data) return {};
  if (data->transfer_syntax == "1.2.840.10008.1.2.1.99")
    throw InputError(path.string(), "is deflated DICOM", "convert it to another transfer syntax");
  DicomSlice slice = slice_of(*data, path);
  if (slice.series_uid.empty() || slice.rows == 0 || slice.columns == 0) return {};
  return slice;
}

void read_dicom_pixels(const DicomSlice& slice, std::int16_t* hounsfield) {
  const std::string bytes = read_file(slice.path, largest_file);
  const auto data = parse_dicom(bytes, false);
  if (!data || !data->has_pixels) damaged(slice.path, "is truncated: its pixels (PixelData) aren't all there");
  PixelLayout layout = layout_of(slice, *data);
  std::vector<char> unpacked;
  std::string_view pixels = data->pixels;
  if (!data->fragments.empty()) {
    const std::string wrong = decode_pixels(data->transfer_syntax, data->fragments, layout, unpacked);
    if (!wrong.empty()) damaged(slice.path, wrong + " (transfer syntax " + data->transfer_syntax + ")");
    pixels = {unpacked.data(), unpacked.size()};
  }
  if (pixels.size() < layout.count() * layout.bytes)
    damaged(slice.path, "is truncated: its PixelData holds fewer pixels than Rows and Columns say");
  const bool swapped = data->big_endian && data->fragments.empty();
  if (layout.bytes == 1) return rescale<std::uint8_t>(pixels, swapped, layout, slice, hounsfield);
  if (layout.bytes == 2) return rescale<std::uint16_t>(pixels, swapped, layout, slice, hounsfield);
  rescale<std::uint32_t>(pixels, swapped, layout, slice, hounsfield);
}

}  // namespace calot
