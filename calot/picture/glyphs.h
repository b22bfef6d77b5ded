// Inside this room only: letters as pen strokes, drawn for Calot.
#pragma once
#include <string_view>
#include <vector>

namespace calot::detail {

/// A point on the letter grid: baseline at y = 3, small letters up to 9, capitals up to 12, descenders down to 0.
struct GlyphPoint {
  double x, y;
};
using GlyphStroke = std::vector<GlyphPoint>;  ///< one point: a dot

struct Glyph {
  double width = 0;  ///< grid units, without the space after it
  std::vector<GlyphStroke> strokes;
};

constexpr double glyph_baseline = 3, glyph_cap_height = 9, glyph_spacing = 2.6;

/// The glyph of a Unicode character; a small box for one that isn't known.
const Glyph& glyph(char32_t character);

/// UTF-8 to characters; bytes that are not UTF-8 become U+FFFD.
std::u32string characters_of(std::string_view utf8);

}  // namespace calot::detail
