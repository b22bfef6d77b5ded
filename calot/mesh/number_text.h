// Inside this room only: numbers into text and bytes, the same on every machine and in every locale.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <string>

namespace calot::detail {

/// Appends the shortest text that reads back as the same bits.
template <class T>
void append_text(std::string& out, T value) {
  std::array<char, 32> text;
  const auto [end, code] = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), end);
}

/// Appends values with blanks between and a line end behind.
template <class... T>
void append_line(std::string& out, T... values) {
  ((append_text(out, values), out += ' '), ...);
  out.back() = '\n';
}

/// Appends the bytes of a number, little endian unless told otherwise.
template <class T>
void append_bytes(std::string& out, T value, bool big_endian = false) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
  out.append(raw.data(), raw.size());
}

}  // namespace calot::detail
