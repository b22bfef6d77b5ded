#include "calot/mesh/base64.h"

#include <algorithm>
#include <array>

namespace calot::detail {
namespace {

constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

constexpr std::array<std::int8_t, 256> digit_table() {
  std::array<std::int8_t, 256> table{};
  for (std::int8_t& digit : table) digit = -1;
  for (std::size_t i = 0; i < alphabet.size(); ++i)
    table[static_cast<unsigned char>(alphabet[i])] = static_cast<std::int8_t>(i);
  return table;
}
constexpr std::array<std::int8_t, 256> digits = digit_table();

}  // namespace

std::string base64_encode(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t have = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < have ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= have ? alphabet[group >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

/// Decodes four characters into pending_; false at the end, or where there is no base64.
bool ByteStream::decode_group() {
  std::uint32_t group = 0;
  int count = 0, padding = 0;
  while (count < 4 && !data_.empty()) {
    const char c = data_.front();
    data_.remove_prefix(1);
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
    const std::int8_t digit = digits[static_cast<unsigned char>(c)];
    if (c == '=' && count >= 2)
      ++padding;
    else if (digit < 0 || padding > 0)
      return false;
    group = group << 6 | (digit < 0 ? 0u : static_cast<std::uint32_t>(digit));
    ++count;
  }
  if (count < 4) return false;
  for (int k = 0; k < 3 - padding; ++k) pending_ += static_cast<char>(group >> (16 - 8 * k) & 255u);
  return true;
}

std::string ByteStream::read(std::size_t size) {
  if (!base64_) {
    const std::string bytes(data_.substr(0, size));
    data_.remove_prefix(bytes.size());
    return bytes;
  }
  while (pending_.size() < size && decode_group()) continue;
  std::string bytes = pending_.substr(0, size);
  pending_.erase(0, bytes.size());
  return bytes;
}

}  // namespace calot::detail
