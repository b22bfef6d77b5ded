// Inside this room only: files that the program carries within itself.
#pragma once
#include <span>
#include <string_view>

namespace calot::detail {

std::string_view embedded_english();             ///< data/text/english.toml
std::span<const unsigned char> embedded_font();  ///< DejaVu Sans, TrueType

}  // namespace calot::detail
