// Inside this room only. Pieces of messages.
#pragma once
#include <array>
#include <cstdio>
#include <string>
#include <string_view>

namespace calot {

/// "1 slice", "2 slices".
inline std::string count_of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// Up to five digits: "3", "0.7031".
inline std::string short_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.5g", value);
  return text.data();
}

/// A stranger's text for one line of a message: short, and without characters that would upset a terminal.
inline std::string plain_text(std::string_view text) {
  std::string plain(text.substr(0, 60));
  for (char& c : plain)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return plain;
}

/// The same in quotes.
inline std::string in_quotes(std::string_view text) {
  std::string quoted(1, '"');
  return quoted.append(plain_text(text)).append(1, '"');
}

}  // namespace calot
