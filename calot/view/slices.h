// Slices of a volume in grey, with the outlines of labels: what a radiologist looks at.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "calot/view/picture.h"

namespace calot {

/// One slice, rows from the top of the picture.
struct SliceView {
  int columns = 0, rows = 0;
  std::span<const std::int16_t> grey;    ///< rows·columns, HU
  std::span<const std::uint16_t> labels;  ///< rows·columns; may be empty
  double column_size = 0, row_size = 0;  ///< [m] of one value
  std::string title;                     ///< "axial, z = −12 mm"
  std::string left, right, top, bottom;  ///< letters at the edges: R, L, A, P, S, I
};

struct SliceOptions {
  int width = 640, height = 640;                       ///< pixels, the slice fitted in
  double window_low = -160, window_high = 240;         ///< HU shown black and white
  std::map<std::uint16_t, Vec3> colors = {};           ///< sRGB of the outline of each label
};

/// Draws a slice, interpolated, with a 1-2 pixel outline around each label, a scale bar and the letters.
/// Throws InputError for spans of a wrong length.
Image render_slice(const SliceView& slice, const SliceOptions& options);

/// Pictures in rows on one canvas, each row as `beside`; with an optional title on top.
Image stacked(const std::vector<Image>& rows, Background background = Background::white);

}  // namespace calot
