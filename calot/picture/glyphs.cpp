#include "calot/picture/glyphs.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace calot::detail {
namespace {

struct Entry {
  char32_t character;
  const char* strokes;
};

// Strokes are separated by spaces; each point is two digits, x and y, base 16. "(" before a stroke makes it a smooth
// curve along its corners, "@" a smooth closed one.
constexpr Entry table[] = {
    {U'A', "033c63 1656"},
    {U'B', "030c (0c6c6808 (08787303"},
    {U'C', "(6a5c0c035365"},
    {U'D', "030c (0c7c7303"},
    {U'E', "6c0c0363 0858"},
    {U'F', "6c0c03 0858"},
    {U'G', "(6a5c0c036368 6838"},
    {U'H', "030c 636c 0868"},
    {U'I', "030c"},
    {U'J', "(4c430305"},
    {U'K', "030c 6c07 2963"},
    {U'L', "0c0363"},
    {U'M', "030c377c73"},
    {U'N', "030c636c"},
    {U'O', "@0c7c7303"},
    {U'P', "030c (0c7c7707"},
    {U'Q', "@0c7c7303 4673"},
    {U'R', "030c (0c7c7707 3763"},
    {U'S', "(6a6c0c0868630305"},
    {U'T', "0c6c 3c33"},
    {U'U', "(0c03636c"},
    {U'V', "0c336c"},
    {U'W', "0c234a638c"},
    {U'X', "036c 0c63"},
    {U'Y', "0c386c 3833"},
    {U'Z', "0c6c0363"},
    {U'a', "@09595303 5953"},
    {U'b', "030c @09595303"},
    {U'c', "(584909034354"},
    {U'd', "535c @09595303"},
    {U'e', "0656 (565909034354"},
    {U'f', "(4c1c13 0939"},
    {U'g', "@09595303 (59500001"},
    {U'h', "030c (06095953"},
    {U'i', "0309 0c"},
    {U'j', "(292000 2c"},
    {U'k', "030c 5905 2753"},
    {U'l', "030c"},
    {U'm', "0309 (06094943 (46498983"},
    {U'n', "0309 (06095953"},
    {U'o', "@09595303"},
    {U'p', "0009 @09595303"},
    {U'q', "5059 @09595303"},
    {U'r', "0309 (060949"},
    {U's', "(5849090656530304"},
    {U't', "(1c1343 0939"},
    {U'u', "(09035359 5953"},
    {U'v', "093369"},
    {U'w', "0923486389"},
    {U'x', "0359 0953"},
    {U'y', "0933 6910"},
    {U'z', "09590353"},
    {U'0', "@0c6c6303"},
    {U'1', "0a3c33"},
    {U'2', "(0a0c6c6803 0363"},
    {U'3', "(0a0c6c6828 (2868630305"},
    {U'4', "434c0666"},
    {U'5', "6c0c08 (086a630305"},
    {U'6', "@08686303 (060c5c6b"},
    {U'7', "0c6c23"},
    {U'8', "@1c5c5818 @08686303"},
    {U'9', "@0c6c6707 (69631304"},
    {U'.', "03"},
    {U',', "1401"},
    {U':', "03 08"},
    {U';', "1401 18"},
    {U'!', "0c06 03"},
    {U'?', "(0a0c5c5827 2726 23"},
    {U'-', "0747"},
    {U'+', "0767 3a34"},
    {U'=', "0666 0969"},
    {U'/', "015d"},
    {U'(', "(2d0a0521"},
    {U')', "(0d2a2501"},
    {U'[', "2d0d0121"},
    {U']', "0d2d2101"},
    {U'<', "590753"},
    {U'>', "095703"},
    {U'%', "037c @0c2c2909 @56767353"},
    {U'_', "0262"},
    {U'\'', "0c0a"},
    {U'"', "0c0a 2c2a"},
    {U'*', "3b35 1a56 5a16"},
    {U'|', "010d"},
    {U'#', "132c 435c 0666 0969"},
    {U'&', "(6309090c3c3906030343 (436367"},
    {U'~', "(07192759"},
    {U'\u00b7', "07"},
    {U'\u00b0', "@0c2c2a0a"},
    {U'\u00d7', "1559 1955"},
    {U'\u00b1', "0868 3b35 0363"},
    {U'\u00b5', "0009 (09035359 5953"},
    {U'\u03bc', "0009 (09035359 5953"},
    {U'\u00b2', "(0b0d3d3b07 0737"},
    {U'\u00b3', "(0b0d3d3a1a (1a3a370708"},
    {U'\u2212', "0767"},
    {U'\u2013', "0767"},
    {U'\u2014', "07a7"},
    {U'\u2019', "0c0a"},
    {U'\u2026', "03 33 63"},
    {U'\u2264', "5a0856 0353"},
    {U'\u2265', "0a5806 0353"},
    {U'\ufffd', "030c5c5303"},
};

int digit(char c) {
  return c <= '9' ? c - '0' : c - 'a' + 10;
}

/// One round of corner cutting [Chaikin1974]; an open curve keeps its ends.
GlyphStroke cut_corners(const GlyphStroke& in, bool closed) {
  GlyphStroke out;
  if (!closed) out.push_back(in.front());
  const std::size_t sides = closed ? in.size() : in.size() - 1;
  for (std::size_t i = 0; i < sides; ++i) {
    const GlyphPoint a = in[i], b = in[(i + 1) % in.size()];
    if (closed || i > 0) out.push_back({0.75 * a.x + 0.25 * b.x, 0.75 * a.y + 0.25 * b.y});
    if (closed || i + 1 < sides) out.push_back({0.25 * a.x + 0.75 * b.x, 0.25 * a.y + 0.75 * b.y});
  }
  if (!closed) out.push_back(in.back());
  return out;
}

GlyphStroke parse_stroke(std::string_view text) {
  const bool closed = text.front() == '@', smooth = closed || text.front() == '(';
  if (smooth) text.remove_prefix(1);
  GlyphStroke stroke;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    stroke.push_back({static_cast<double>(digit(text[i])), static_cast<double>(digit(text[i + 1]))});
  for (int round = 0; smooth && round < 4; ++round) stroke = cut_corners(stroke, closed);
  if (closed) stroke.push_back(stroke.front());
  return stroke;
}

Glyph parse(std::string_view text) {
  Glyph glyph;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    glyph.strokes.push_back(parse_stroke(text.substr(0, end)));
    for (const GlyphPoint& p : glyph.strokes.back()) glyph.width = std::max(glyph.width, p.x);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return glyph;
}

std::map<char32_t, Glyph> parse_table() {
  std::map<char32_t, Glyph> glyphs;
  for (const Entry& entry : table) glyphs[entry.character] = parse(entry.strokes);
  glyphs[U' '] = {2.4, {}};
  glyphs[U'\u202f'] = {1.0, {}};
  return glyphs;
}

}  // namespace

const Glyph& glyph(char32_t character) {
  static const std::map<char32_t, Glyph> glyphs = parse_table();
  const auto found = glyphs.find(character);
  return found == glyphs.end() ? glyphs.at(U'\ufffd') : found->second;
}

std::u32string characters_of(std::string_view utf8) {
  std::u32string result;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto first = static_cast<std::uint8_t>(utf8[i++]);
    const int more = first < 0x80 ? 0 : first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : first >= 0xc0 ? 1 : -1;
    char32_t code = more <= 0 ? first : first & (0x3fu >> more);
    bool sound = more >= 0;
    for (int k = 0; k < more && sound; ++k) {
      sound = i < utf8.size() && (static_cast<std::uint8_t>(utf8[i]) & 0xc0) == 0x80;
      if (sound) code = code << 6 | (static_cast<std::uint8_t>(utf8[i++]) & 0x3fu);
    }
    result += sound ? code : U'\ufffd';
  }
  return result;
}

}  // namespace calot::detail
