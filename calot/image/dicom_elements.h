// Inside this room only. The structure of DICOM files. Read here, not by GDCM, which ends the whole program (an
// assertion) where a file is cut off.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace calot {

/// A data element's number: group · 65536 + element.
using DicomTag = std::uint32_t;
inline constexpr DicomTag dicom_pixel_data = 0x7fe00010;

/// The outermost elements of a file before its pixels; they point into the file's bytes.
struct DicomData {
  std::string transfer_syntax;  ///< UID
  bool big_endian = false;
  std::map<DicomTag, std::string_view> elements;
  bool has_pixels = false;                  ///< the pixels' element was found
  std::string_view pixels;                  ///< as they are …
  std::vector<std::string_view> fragments;  ///< … or compressed, in pieces

  [[nodiscard]] std::string text(DicomTag tag) const;
  /// Decimal numbers parted by backslashes; stops at the first that is none.
  [[nodiscard]] std::vector<double> numbers(DicomTag tag) const;
  /// A 16-bit number, or `otherwise` where there is none.
  [[nodiscard]] int short_number(DicomTag tag, int otherwise) const;
};

/// Whether a file says that it is DICOM ("DICM" behind 128 bytes).
bool has_dicom_mark(std::string_view bytes);

/// Parses a file, with or without the mark. Any bytes are safe. Empty where the bytes end within an element, or aren't
/// DICOM.
/// @param only_header  stops where the pixels begin; bytes may end there
std::optional<DicomData> parse_dicom(std::string_view bytes, bool only_header);

}  // namespace calot
