// Inside this room only. Compressed pixels of DICOM files.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace calot {

/// An image of one number a pixel.
struct PixelLayout {
  std::size_t rows = 0, columns = 0;
  std::size_t bytes = 2;  ///< a pixel takes: 1, 2 or 4
  int bits_stored = 16;
  bool is_signed = false;
  [[nodiscard]] std::size_t count() const { return rows * columns; }
};

/// Decodes JPEG 2000, JPEG (lossless, and the lossy kinds), JPEG-LS and run lengths into rows · columns · bytes, little
/// endian. `layout` learns from the stream what the header may have wrong (bits, sign).
/// @return what is wrong with the bytes; empty when they were decoded
std::string decode_pixels(const std::string& transfer_syntax, const std::vector<std::string_view>& fragments,
                          PixelLayout& layout, std::vector<char>& pixels);

}  // namespace calot
