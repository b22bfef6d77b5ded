#include "calot/picture/canvas.h"

#include <algorithm>
#include <cmath>

#include "calot/picture/glyphs.h"

namespace calot::detail {

Vec3 paper(Background background) {
  return background == Background::white ? Vec3{1, 1, 1} : Vec3{0.075, 0.085, 0.105};
}
Vec3 ink(Background background) {
  return background == Background::white ? Vec3{0.13, 0.15, 0.18} : Vec3{0.90, 0.91, 0.93};
}

void Canvas::blend(int x, int y, double amount, const Vec3& color) {
  if (x < 0 || y < 0 || x >= image_.width || y >= image_.height || amount <= 0) return;
  std::uint8_t* pixel = &image_.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                                         static_cast<std::size_t>(x))];
  for (int c = 0; c < 3; ++c)
    pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + std::min(1.0, amount) * (255 * color[c] - pixel[c])));
}

void Canvas::line(double x0, double y0, double x1, double y1, double thickness, const Vec3& color) {
  const double radius = thickness / 2, dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy;
  const auto from = [&](double a, double b) { return static_cast<int>(std::floor(std::min(a, b) - radius - 1)); };
  const auto to = [&](double a, double b) { return static_cast<int>(std::ceil(std::max(a, b) + radius + 1)); };
  for (int y = from(y0, y1); y <= to(y0, y1); ++y)
    for (int x = from(x0, x1); x <= to(x0, x1); ++x) {
      const double px = x + 0.5 - x0, py = y + 0.5 - y0;
      const double along = length2 == 0 ? 0 : std::clamp((px * dx + py * dy) / length2, 0.0, 1.0);
      blend(x, y, radius + 0.5 - std::hypot(px - along * dx, py - along * dy), color);
    }
}

void Canvas::box(double left, double top, double width, double height, const Vec3& color) {
  const auto overlap = [](double low, double size, int pixel) {
    return std::clamp(std::min(low + size, pixel + 1.0) - std::max(low, static_cast<double>(pixel)), 0.0, 1.0);
  };
  for (int y = static_cast<int>(std::floor(top)); y < top + height; ++y)
    for (int x = static_cast<int>(std::floor(left)); x < left + width; ++x)
      blend(x, y, overlap(left, width, x) * overlap(top, height, y), color);
}

double Canvas::text(double x, double y, double size, std::string_view words, const Vec3& color) {
  const double unit = size / glyph_cap_height, pen = std::max(1.1, size * 0.115);
  for (const char32_t character : characters_of(words)) {
    const Glyph& shape = glyph(character);
    for (const GlyphStroke& stroke : shape.strokes)
      for (std::size_t i = 0; i < stroke.size(); ++i) {
        if (i + 1 == stroke.size() && stroke.size() > 1) break;
        const GlyphPoint a = stroke[i], b = stroke[std::min(i + 1, stroke.size() - 1)];
        line(x + a.x * unit, y - (a.y - glyph_baseline) * unit, x + b.x * unit, y - (b.y - glyph_baseline) * unit,
             stroke.size() == 1 ? 1.35 * pen : pen, color);
      }
    x += (shape.width + glyph_spacing) * unit;
  }
  return x;
}

double text_width(double size, std::string_view words) {
  double width = 0;
  for (const char32_t character : characters_of(words)) width += glyph(character).width + glyph_spacing;
  return std::max(0.0, width - glyph_spacing) * size / glyph_cap_height;
}

}  // namespace calot::detail
