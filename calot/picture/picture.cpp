#include "calot/picture/picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "calot/base/error.h"
#include "calot/picture/canvas.h"
#include "calot/picture/color.h"
#include "calot/picture/raster.h"
#include "calot/picture/scene.h"

namespace calot {
namespace {

using detail::Camera;
using detail::Canvas;
using detail::Film;
using detail::ink;
using detail::paper;
using detail::Scene;
using detail::Viewport;

/// Everything measured in the height of a capital letter, so that small pictures have small words.
struct Layout {
  double letter, margin;
  Viewport view;
};

const char* const legend_gap = "  ";

bool has_legend(const std::vector<PictureItem>& items) {
  return std::any_of(items.begin(), items.end(), [](const PictureItem& item) { return !item.label.empty(); });
}

Layout lay_out(const std::vector<PictureItem>& items, const PictureOptions& options, bool has_scalars) {
  Layout layout{};
  layout.letter = std::max(6.0, std::min(options.width, options.height) / 60.0);
  layout.margin = 1.6 * layout.letter;
  const double line = 2.2 * layout.letter;
  const double top = layout.margin + (options.title.empty() ? 0 : 1.3 * line);
  const bool has_foot = options.scale_bar || has_legend(items);
  const double bottom = layout.margin + (options.caption.empty() ? 0 : line) + (has_foot ? 1.4 * line : 0);
  const double right = layout.margin + (has_scalars ? 8.5 * layout.letter : 0);
  layout.view = {layout.margin, top, std::max(8.0, options.width - layout.margin - right),
                 std::max(8.0, options.height - top - bottom)};
  return layout;
}

Camera camera_for(const std::vector<PictureItem>& items, const PictureOptions& options, const Viewport& view) {
  std::vector<Vec3> points = options.frame ? options.frame->points : frame_of(items).points;
  if (points.empty()) points.assign(1, Vec3::Zero());
  return detail::frame_camera(points, options.direction, options.up, view);
}

/// A box blur along one axis, three times: nearly a Gaussian.
void blur(std::vector<float>& values, int width, int height, int radius, bool down) {
  const int length = down ? height : width, lines = down ? width : height;
  const auto at = [&](int line, int i) -> float& {
    return values[static_cast<std::size_t>(down ? i : line) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(down ? line : i)];
  };
  std::vector<float> copy(static_cast<std::size_t>(length));
  for (int line = 0; line < lines; ++line) {
    for (int i = 0; i < length; ++i) copy[static_cast<std::size_t>(i)] = at(line, i);
    const auto old = [&](int i) {
      return static_cast<double>(copy[static_cast<std::size_t>(std::clamp(i, 0, length - 1))]);
    };
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) sum += old(i);
    for (int i = 0; i < length; ++i) {
      at(line, i) = static_cast<float>(sum / (2 * radius + 1));
      sum += old(i + radius + 1) - old(i - radius);
    }
  }
}

/// Darkens what lies deeper than its surroundings, by the difference between depth and blurred depth [Luft2006].
void darken_hollows(Film& film, double extent) {
  float back = 0;
  for (const float d : film.depth) back = std::max(back, d);
  std::vector<float> smooth(film.depth);
  for (float& d : smooth)
    if (d == 0) d = back;
  const int radius = std::max(1, std::min(film.width, film.height) / 70);
  for (int round = 0; round < 3; ++round)
    for (const bool down : {false, true}) blur(smooth, film.width, film.height, radius, down);
  for (std::size_t i = 0; i < film.light.size(); ++i) {
    if (film.depth[i] == 0) continue;
    const double deeper = std::clamp((film.depth[i] - smooth[i]) / (0.05 * extent), 0.0, 1.0);
    film.light[i] *= 1 - 0.5 * deeper;
  }
}

Image develop(const Film& film, Background background) {
  Image image{film.width, film.height, std::vector<std::uint8_t>(3 * film.light.size())};
  const Vec3 behind = detail::linear_of(paper(background));
  for (std::size_t i = 0; i < film.light.size(); ++i) {
    const Vec3 light = film.light[i] + (1.0 - film.coverage[i]) * behind;
    const Vec3 srgb = detail::srgb_of(light.cwiseMax(0.0).cwiseMin(1.0));
    for (int c = 0; c < 3; ++c)
      image.rgb[3 * i + static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255 * srgb[c]));
  }
  return image;
}

/// 1, 2 or 5 times a power of ten, at most `limit`.
double round_step(double limit) {
  const double decade = std::pow(10.0, std::floor(std::log10(limit)));
  return limit >= 5 * decade ? 5 * decade : limit >= 2 * decade ? 2 * decade : decade;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void draw_scale_bar(Canvas& canvas, const Layout& layout, const Camera& camera, const PictureOptions& options,
                    double baseline) {
  const double pixels_per_mm = camera.focal / camera.middle_depth * 1e-3;
  const double millimetres = round_step(0.22 * layout.view.width / pixels_per_mm);
  if (!std::isfinite(millimetres) || millimetres <= 0) return;
  const double length = millimetres * pixels_per_mm, right = options.width - layout.margin;
  const Vec3 color = ink(options.background);
  const double pen = std::max(1.5, 0.14 * layout.letter);
  canvas.line(right - length, baseline, right, baseline, pen, color);
  for (const double end : {right - length, right})
    canvas.line(end, baseline - 0.4 * layout.letter, end, baseline + 0.4 * layout.letter, pen, color);
  const std::string words = number(millimetres) + " mm";
  canvas.text(right - length / 2 - detail::text_width(layout.letter, words) / 2, baseline - 0.8 * layout.letter,
              layout.letter, words, color);
}

void draw_legend(Canvas& canvas, const Layout& layout, const std::vector<PictureItem>& items, Background background,
                 double baseline) {
  double x = layout.margin;
  const double letter = layout.letter;
  for (const PictureItem& item : items) {
    if (item.label.empty()) continue;
    if (item.scalar.empty()) {
      const Vec3 shown = item.opacity * item.color + (1 - item.opacity) * paper(background);
      canvas.line(x + 0.55 * letter, baseline - 0.5 * letter, x + 0.55 * letter, baseline - 0.5 * letter, 1.3 * letter,
                  shown);
      x += 1.8 * letter;
    }
    x = canvas.text(x, baseline, letter, item.label + legend_gap, ink(background)) + 0.8 * letter;
  }
}

void draw_color_bar(Canvas& canvas, const Layout& layout, const Scene& scene, const PictureOptions& options) {
  const double letter = layout.letter, width = 1.4 * letter, height = 0.62 * layout.view.height;
  const double left = options.width - layout.margin - 7 * letter, top = layout.view.top + 0.2 * layout.view.height;
  const auto [low, high] = scene.scalar_range;
  const Vec3 color = ink(options.background);
  for (int row = 0; row < height; ++row)
    canvas.box(left, top + row, width, std::min(1.0, height - row),
               detail::srgb_of(detail::colormap(1 - (row + 0.5) / height)));
  const double step = round_step((high - low) / 4);
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    const double y = top + height * (high - k * step) / (high - low);
    canvas.line(left + width, y, left + width + 0.4 * letter, y, std::max(1.2, 0.1 * letter), color);
    canvas.text(left + width + 0.8 * letter, y + 0.45 * letter, 0.9 * letter, number(k == 0 ? 0 : k * step), color);
  }
  const double words = detail::text_width(0.9 * letter, options.scalar_label), end = options.width - layout.margin;
  canvas.text(std::min(left, end - words), top - 1.2 * letter, 0.9 * letter, options.scalar_label, color);
}

void annotate(Image& image, const std::vector<PictureItem>& items, const PictureOptions& options, const Layout& layout,
              const Scene& scene, const Camera& camera) {
  Canvas canvas(image);
  const Vec3 color = ink(options.background);
  const double letter = layout.letter, line = 2.2 * letter;
  canvas.text(layout.margin, layout.margin + 1.3 * letter, 1.3 * letter, options.title, color);
  const double last = options.height - layout.margin;
  canvas.text(layout.margin, last, 0.9 * letter, options.caption, 0.75 * color + 0.25 * paper(options.background));
  const double foot = last - (options.caption.empty() ? 0 : line);
  if (options.scale_bar && !scene.triangles.empty())
    draw_scale_bar(canvas, layout, camera, options, foot - 0.3 * letter);
  draw_legend(canvas, layout, items, options.background, foot);
  if (scene.has_scalars) draw_color_bar(canvas, layout, scene, options);
}

void check_options(const PictureOptions& options) {
  const auto within = [](int value, int low, int high) { return low <= value && value <= high; };
  if (!within(options.width, 16, 16384) || !within(options.height, 16, 16384))
    throw InputError(
        "picture",
        "a size of " + std::to_string(options.width) + "×" + std::to_string(options.height) + " pixels is out of range",
        "use 16 to 16384");
  if (!within(options.samples, 1, 8)) throw InputError("picture", "samples must be 1 to 8");
}

}  // namespace

Image render_picture(const std::vector<PictureItem>& items, const PictureOptions& options) {
  check_options(options);
  detail::check_items(items);
  Scene scene = detail::make_scene(items, options);
  const Layout layout = lay_out(items, options, scene.has_scalars);
  const Camera camera = camera_for(items, options, layout.view);
  detail::project(scene, camera);
  Film film = detail::draw(scene, camera, options.width, options.height, options.samples);
  darken_hollows(film, 2 * 0.22 * camera.middle_depth);
  Image image = develop(film, options.background);
  annotate(image, items, options, layout, scene, camera);
  return image;
}

Image beside(const std::vector<Image>& images, Background background) {
  Image all;
  for (const Image& image : images) {
    all.width += image.width;
    all.height = std::max(all.height, image.height);
  }
  const auto row_bytes = [](const Image& image) { return 3 * static_cast<std::size_t>(image.width); };
  all.rgb.resize(row_bytes(all) * static_cast<std::size_t>(all.height));
  Canvas(all).box(0, 0, all.width, all.height, paper(background));
  std::size_t left = 0;
  for (const Image& image : images) {
    for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row)
      std::copy_n(&image.rgb[row * row_bytes(image)], row_bytes(image), &all.rgb[row * row_bytes(all) + left]);
    left += row_bytes(image);
  }
  return all;
}

void write_picture(const std::filesystem::path& path, const std::vector<PictureItem>& items,
                   const PictureOptions& options) {
  write_png(path, render_picture(items, options));
}

PictureFrame frame_of(const std::vector<PictureItem>& items) {
  detail::check_items(items);
  PictureFrame frame;
  for (const PictureItem& item : items) {
    const std::vector<Vec3> positions = detail::item_positions(item);
    frame.points.insert(frame.points.end(), positions.begin(), positions.end());
  }
  return frame;
}

std::vector<std::uint8_t> exposed_faces(const Surface& before, const Surface& after,
                                        std::span<const VertexId> vertex_to_old) {
  const auto key = [](std::array<VertexId, 3> face) {
    std::sort(face.begin(), face.end());
    return face;
  };
  std::set<std::array<VertexId, 3>> known;
  for (const auto& [a, b, c] : before.triangles)
    known.insert(key({before.vertex_of_mesh[a], before.vertex_of_mesh[b], before.vertex_of_mesh[c]}));
  const auto old = [&](std::uint32_t v) { return vertex_to_old[after.vertex_of_mesh[v].index()]; };
  std::vector<std::uint8_t> flags;
  flags.reserve(after.triangles.size());
  for (const auto& [a, b, c] : after.triangles) flags.push_back(known.contains(key({old(a), old(b), old(c)})) ? 0 : 1);
  return flags;
}

}  // namespace calot
