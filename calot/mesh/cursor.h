// Inside this room only: reads text and binary from memory, trusting nothing.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "calot/base/error.h"

namespace calot::detail {

/// Shows at most 40 printable characters of what a file holds, in quotes, for messages.
std::string in_quotes(std::string_view text);

/// A place in a file's bytes. Every read checks what is left first; every error names the file and the line, or in
/// binary files the byte, of the item being read, and the section.
class Cursor {
 public:
  /// @param first_line  line number of the first byte, when `bytes` is cut out of a longer file
  Cursor(std::string_view bytes, std::string name, std::size_t first_line = 1)
      : bytes_(bytes), name_(std::move(name)), first_line_(first_line) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }
  [[nodiscard]] bool at_end() const { return position_ == bytes_.size(); }
  [[nodiscard]] bool binary() const { return binary_; }
  void seek(std::size_t position) { position_ = item_ = std::min(position, bytes_.size()); }
  void set_binary(bool binary) { binary_ = binary; }
  void set_big_endian(bool big) { swap_ = big != (std::endian::native == std::endian::big); }
  void set_section(std::string section) { section_ = std::move(section); }

  /// "FILE:LINE" of the last item read, or "FILE: byte N" in a binary file; with the section, if any.
  [[nodiscard]] std::string where() const;
  [[noreturn]] void fail(const std::string& what, const std::string& what_to_do = {}) const;

  // Text.
  /// Skips blanks and line ends; false at the end of the file.
  bool skip_space();
  /// The next word. @param what  names it for the message when there is none
  std::string_view token(const char* what);
  /// The next word on this line; empty at the end of the line, which stays unread.
  std::string_view token_on_line();
  /// What is left of this line, without the line end, which is passed.
  std::string_view rest_of_line();
  /// Moves behind the next occurrence of `text`; false, without moving, if there is none.
  bool skip_past(std::string_view text);
  template <class T>
  T number(const char* what);
  template <class T>
  T number_in(std::string_view word, const char* what) const;
  /// A finite number.
  double coordinate(const char* what) { return finite(number<double>(what), what); }

  // Binary.
  std::string_view take(std::size_t size, const char* what);
  template <class T>
  T value(const char* what);

  /// Refuses a count of items that can't fit in what is left of the file, each at least `bytes_each` long. In text the
  /// last item may lack its separator.
  std::size_t checked_count(std::uint64_t count, std::size_t bytes_each, const char* what) const;
  /// A number of items, as text, checked like that.
  std::size_t count(const char* what, std::size_t bytes_each) {
    return checked_count(number<std::uint64_t>(what), bytes_each, what);
  }
  double finite(double value, const char* what) const {
    if (!std::isfinite(value))
      fail(std::string(what) + " is not a finite number", "repair it in the program that wrote it");
    return value;
  }

 private:
  std::string_view bytes_;
  std::string name_, section_;
  std::size_t first_line_ = 1, position_ = 0, item_ = 0;
  bool binary_ = false, swap_ = false;
};

template <class T>
T Cursor::number_in(std::string_view word, const char* what) const {
  std::string_view digits = word;
  if (digits.size() > 1 && digits.front() == '+' && digits[1] != '-') digits.remove_prefix(1);
  T result{};
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), result);
  if (code == std::errc::result_out_of_range) fail(std::string(what) + " " + in_quotes(word) + " is out of range");
  if (code != std::errc() || end != digits.data() + digits.size())
    fail(std::string(what) + " expected, not " + in_quotes(word));
  return result;
}

template <class T>
T Cursor::number(const char* what) {
  return number_in<T>(token(what), what);
}

/// The number that `bytes` (at least sizeof(T) of them) holds.
template <class T>
T load(const char* bytes, bool swap) {
  static_assert(std::is_arithmetic_v<T>);
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

template <class T>
T Cursor::value(const char* what) {
  return load<T>(take(sizeof(T), what).data(), swap_);
}

}  // namespace calot::detail
