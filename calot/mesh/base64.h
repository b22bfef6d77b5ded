// Inside this room only: base64, as .vtu files use it.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace calot::detail {

std::string base64_encode(std::string_view bytes);

/// A stream of bytes out of memory: plain, or base64 text that is decoded on the way. Base64 blocks may follow one
/// another, each with its own padding; blanks are skipped.
class ByteStream {
 public:
  ByteStream(std::string_view data, bool base64) : data_(data), base64_(base64) {}
  /// At least as many bytes as can still come.
  [[nodiscard]] std::size_t at_most() const {
    return pending_.size() + (base64_ ? data_.size() / 4 * 3 + 3 : data_.size());
  }
  /// The next `size` bytes; fewer if the stream ends or isn't base64.
  std::string read(std::size_t size);

 private:
  bool decode_group();
  std::string_view data_;
  bool base64_;
  std::string pending_;  // decoded, not yet read: at most two bytes
};

}  // namespace calot::detail
