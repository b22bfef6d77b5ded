#include "calot/picture/slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/picture/canvas.h"

namespace calot {
namespace {

using detail::Canvas;

constexpr int samples = 3;               // a pixel's side
constexpr double outline_width = 1.6;    // pixels
constexpr std::size_t ring_points = 16;  // where the outline looks for another label

void check(const SliceView& slice, const SliceOptions& options) {
  const auto wrong = [](const std::string& what) { throw InputError("slice", what, "see calot/picture/slices.h"); };
  if (slice.columns < 1 || slice.rows < 1) wrong("there are no values");
  const std::size_t count = static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows);
  if (slice.grey.size() != count)
    wrong("has " + std::to_string(slice.grey.size()) + " grey values, not rows times columns");
  if (!slice.labels.empty() && slice.labels.size() != count)
    wrong("has " + std::to_string(slice.labels.size()) + " labels, not rows times columns");
  for (const double size : {slice.column_size, slice.row_size})
    if (!(size > 0 && std::isfinite(size))) wrong("a row or column has no size");
  for (const int pixels : {options.width, options.height})
    if (pixels < 16 || pixels > 4096) wrong("a size of " + std::to_string(pixels) + " pixels is out of range");
  if (!(options.window_high > options.window_low && std::isfinite(options.window_high - options.window_low)))
    wrong("the window of grey values is empty");
}

/// Where the slice lies on the picture.
struct Placement {
  double left, top, width, height;  // pixels
  double columns_per_pixel, rows_per_pixel;
  double pixels_per_metre;
  double letter;

  [[nodiscard]] double column(double x) const { return (x - left) * columns_per_pixel - 0.5; }
  [[nodiscard]] double row(double y) const { return (y - top) * rows_per_pixel - 0.5; }
};

Placement place(const SliceView& slice, const SliceOptions& options) {
  Placement p{};
  p.letter = std::max(6.0, std::min(options.width, options.height) / 52.0);
  const double head = slice.title.empty() ? 0 : 2.6 * p.letter;
  const double wide = slice.columns * slice.column_size, high = slice.rows * slice.row_size;
  p.pixels_per_metre = std::min(options.width / wide, std::max(8.0, options.height - head) / high);
  p.width = wide * p.pixels_per_metre;
  p.height = high * p.pixels_per_metre;
  p.left = (options.width - p.width) / 2;
  p.top = head + (options.height - head - p.height) / 2;
  p.columns_per_pixel = slice.columns / p.width;
  p.rows_per_pixel = slice.rows / p.height;
  return p;
}

template <class T>
T value_at(const SliceView& slice, std::span<const T> values, int column, int row) {
  column = std::clamp(column, 0, slice.columns - 1);
  row = std::clamp(row, 0, slice.rows - 1);
  return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(slice.columns) +
                static_cast<std::size_t>(column)];
}

double grey_at(const SliceView& slice, double column, double row) {
  const double c = std::floor(column), r = std::floor(row), u = column - c, v = row - r;
  const int i = static_cast<int>(c), j = static_cast<int>(r);
  const auto at = [&](int a, int b) { return static_cast<double>(value_at(slice, slice.grey, i + a, j + b)); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

/// The label whose indicator, smoothed with a quadratic B-spline, is the largest: a curve instead of a staircase, and a
/// single voxel still has a middle.
std::uint16_t label_at(const SliceView& slice, double column, double row) {
  const double c = std::round(column), r = std::round(row), u = column - c, v = row - r;
  const auto spline = [](double x) {
    return std::array<double, 3>{(0.5 - x) * (0.5 - x) / 2, 0.75 - x * x, (0.5 + x) * (0.5 + x) / 2};
  };
  const std::array<double, 3> across = spline(u), down = spline(v);
  std::array<std::pair<std::uint16_t, double>, 9> found;
  std::size_t count = 0;
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::uint16_t label = value_at(slice, slice.labels, static_cast<int>(c) + static_cast<int>(a) - 1,
                                           static_cast<int>(r) + static_cast<int>(b) - 1);
      std::size_t k = 0;
      while (k < count && found[k].first != label) ++k;
      if (k == count) found[count++] = {label, 0.0};
      found[k].second += across[a] * down[b];
    }
  return std::max_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Labels at every sample of the picture; 0 outside the slice.
struct LabelRaster {
  int width, height;
  std::vector<std::uint16_t> labels;

  [[nodiscard]] std::uint16_t at(int x, int y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return 0;
    return labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

LabelRaster raster_of(const SliceView& slice, const SliceOptions& options, const Placement& p) {
  LabelRaster raster{samples * options.width, samples * options.height, {}};
  raster.labels.resize(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height));
  parallel_for(static_cast<std::size_t>(raster.height), [&](std::size_t y) {
    const double row = p.row((static_cast<double>(y) + 0.5) / samples);
    if (row < -0.5 || row > slice.rows - 0.5) return;
    for (int x = 0; x < raster.width; ++x) {
      const double column = p.column((x + 0.5) / samples);
      if (column < -0.5 || column > slice.columns - 0.5) continue;
      raster.labels[y * static_cast<std::size_t>(raster.width) + static_cast<std::size_t>(x)] =
          label_at(slice, column, row);
    }
  });
  return raster;
}

std::array<std::array<int, 2>, ring_points> ring() {
  std::array<std::array<int, 2>, ring_points> offsets{};
  for (std::size_t k = 0; k < ring_points; ++k) {
    const double angle = 2 * M_PI * static_cast<double>(k) / ring_points;
    offsets[k] = {static_cast<int>(std::lround(outline_width * samples * std::cos(angle))),
                  static_cast<int>(std::lround(outline_width * samples * std::sin(angle)))};
  }
  return offsets;
}

/// Blends the outlines over the grey picture.
void draw_outlines(Image& image, const LabelRaster& raster, const std::map<std::uint16_t, Vec3>& colors) {
  const auto offsets = ring();
  parallel_for(static_cast<std::size_t>(image.height), [&](std::size_t row) {
    for (int x = 0; x < image.width; ++x) {
      Vec3 color = Vec3::Zero();
      int covered = 0;
      for (int s = 0; s < samples * samples; ++s) {
        const int sx = x * samples + s % samples, sy = static_cast<int>(row) * samples + s / samples;
        const std::uint16_t label = raster.at(sx, sy);
        const auto found = label == 0 ? colors.end() : colors.find(label);
        if (found == colors.end()) continue;
        if (std::all_of(offsets.begin(), offsets.end(),
                        [&](const auto& o) { return raster.at(sx + o[0], sy + o[1]) == label; }))
          continue;
        color += found->second;
        ++covered;
      }
      std::uint8_t* pixel = &image.rgb[3 * (row * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x))];
      const double rest = 1 - static_cast<double>(covered) / (samples * samples);
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(
            std::lround(rest * pixel[c] + 255 * std::clamp(color[c], 0.0, 9.0) / (samples * samples)));
    }
  });
}

Image grey_picture(const SliceView& slice, const SliceOptions& options, const Placement& p) {
  Image image{options.width, options.height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height));
  parallel_for(static_cast<std::size_t>(options.height), [&](std::size_t y) {
    for (int x = 0; x < options.width; ++x) {
      double sum = 0;
      for (int s = 0; s < samples * samples; ++s) {
        const double column = p.column(x + (s % samples + 0.5) / samples);
        const double row = p.row(static_cast<double>(y) + (s / samples + 0.5) / samples);
        if (column < -0.5 || row < -0.5 || column > slice.columns - 0.5 || row > slice.rows - 0.5) continue;
        const double hu = grey_at(slice, column, row);
        sum += std::clamp((hu - options.window_low) / (options.window_high - options.window_low), 0.0, 1.0);
      }
      const auto grey = static_cast<std::uint8_t>(std::lround(255 * sum / (samples * samples)));
      std::fill_n(&image.rgb[3 * (y * static_cast<std::size_t>(options.width) + static_cast<std::size_t>(x))], 3, grey);
    }
  });
  return image;
}

/// 1, 2 or 5 times a power of ten, at most `limit`.
double round_step(double limit) {
  const double decade = std::pow(10.0, std::floor(std::log10(limit)));
  return limit >= 5 * decade ? 5 * decade : limit >= 2 * decade ? 2 * decade : decade;
}

/// Words with a dark rim, which stay readable on bright tissue.
void rimmed_text(Canvas& canvas, double x, double y, double size, const std::string& words) {
  const double rim = std::max(1.0, size * 0.09);
  for (const double dx : {-rim, 0.0, rim})
    for (const double dy : {-rim, 0.0, rim})
      if (dx != 0 || dy != 0) canvas.text(x + dx, y + dy, size, words, Vec3::Zero());
  canvas.text(x, y, size, words, Vec3::Constant(0.95));
}

void draw_letters(Canvas& canvas, const SliceView& slice, const Placement& p) {
  const double size = 1.25 * p.letter, gap = 0.9 * p.letter;
  const double middle_x = p.left + p.width / 2, middle_y = p.top + p.height / 2 + size / 2;
  const auto width = [&](const std::string& words) { return detail::text_width(size, words); };
  rimmed_text(canvas, p.left + gap, middle_y, size, slice.left);
  rimmed_text(canvas, p.left + p.width - gap - width(slice.right), middle_y, size, slice.right);
  rimmed_text(canvas, middle_x - width(slice.top) / 2, p.top + gap + size, size, slice.top);
  rimmed_text(canvas, middle_x - width(slice.bottom) / 2, p.top + p.height - gap, size, slice.bottom);
}

void draw_scale_bar(Canvas& canvas, const Placement& p) {
  const double pixels_per_mm = p.pixels_per_metre * 1e-3;
  const double millimetres = round_step(0.25 * p.width / pixels_per_mm), length = millimetres * pixels_per_mm;
  const double right = p.left + p.width - p.letter, y = p.top + p.height - p.letter;
  const double pen = std::max(1.5, 0.14 * p.letter);
  for (const bool front : {false, true}) {
    const Vec3 color = Vec3::Constant(front ? 0.95 : 0.0);
    const double wide = front ? pen : pen + 2;
    canvas.line(right - length, y, right, y, wide, color);
    for (const double end : {right - length, right})
      canvas.line(end, y - 0.4 * p.letter, end, y + 0.4 * p.letter, wide, color);
  }
  char words[40];
  std::snprintf(words, sizeof words, "%g mm", millimetres);
  rimmed_text(canvas, right - length / 2 - detail::text_width(p.letter, words) / 2, y - 0.8 * p.letter, p.letter,
              words);
}

Image blank(int width, int height, Background background) {
  Image image{width, height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Canvas(image).box(0, 0, width, height, detail::paper(background));
  return image;
}

}  // namespace

Image render_slice(const SliceView& slice, const SliceOptions& options) {
  check(slice, options);
  const Placement p = place(slice, options);
  Image image = grey_picture(slice, options, p);
  if (!slice.labels.empty()) draw_outlines(image, raster_of(slice, options, p), options.colors);
  Canvas canvas(image);
  canvas.text(0.8 * p.letter, 1.75 * p.letter, 1.1 * p.letter, slice.title, Vec3::Constant(0.95));
  draw_letters(canvas, slice, p);
  draw_scale_bar(canvas, p);
  return image;
}

Image color_legend(const std::vector<std::pair<std::string, Vec3>>& entries, int width, Background background) {
  constexpr double letter = 12, margin = 18, line = 2.2 * letter;
  struct Spot {
    double x;
    int line;
  };
  std::vector<Spot> spots;
  double x = margin;
  int lines = entries.empty() ? 0 : 1;
  for (const auto& [words, color] : entries) {
    const double wide = 2 * letter + detail::text_width(letter, words);
    if (x > margin && x + wide > width - margin) x = margin, ++lines;
    spots.push_back({x, lines - 1});
    x += wide + 1.8 * letter;
  }
  Image image = blank(width, static_cast<int>(std::lround(lines * line + letter)), background);
  Canvas canvas(image);
  for (std::size_t e = 0; e < entries.size(); ++e) {
    const double y = letter / 2 + (spots[e].line + 0.75) * line;
    canvas.line(spots[e].x + 0.6 * letter, y - 0.5 * letter, spots[e].x + 0.6 * letter, y - 0.5 * letter, 1.3 * letter,
                entries[e].second);
    canvas.text(spots[e].x + 1.9 * letter, y, letter, entries[e].first, detail::ink(background));
  }
  return image;
}

Image stacked(const std::vector<Image>& rows, Background background, const std::string& title) {
  constexpr double letter = 17;
  int width = 0, height = title.empty() ? 0 : static_cast<int>(3 * letter);
  const int head = height;
  for (const Image& row : rows) {
    width = std::max(width, row.width);
    height += row.height;
  }
  Image all = blank(width, height, background);
  auto top = static_cast<std::size_t>(head);
  for (const Image& row : rows) {
    const std::size_t bytes = 3 * static_cast<std::size_t>(row.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(row.height); ++y)
      std::copy_n(row.rgb.begin() + static_cast<std::ptrdiff_t>(y * bytes), bytes,
                  all.rgb.begin() + static_cast<std::ptrdiff_t>(3 * (top + y) * static_cast<std::size_t>(width)));
    top += static_cast<std::size_t>(row.height);
  }
  if (!title.empty()) Canvas(all).text(18, 2 * letter, letter, title, detail::ink(background));
  return all;
}

}  // namespace calot
