// Slices of a volume in grey, with the outlines of labels: what a radiologist looks at.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calot/picture/picture.h"

namespace calot {

/// One slice, rows from the top of the picture. By convention the viewer stands at the patient's feet, or before the
/// patient: on axial and coronal slices the patient's right is on the left.
struct SliceView {
  int columns = 0, rows = 0;
  std::span<const std::int16_t> grey;              ///< rows·columns, HU
  std::span<const std::uint16_t> labels;           ///< rows·columns; may be empty
  double column_size = 0, row_size = 0;            ///< [m] of one value
  std::string title = {};                          ///< "axial, z = −12 mm"
  std::string left, right, top = {}, bottom = {};  ///< letters at the edges: R, L, A, P, S, I
};

struct SliceOptions {
  int width = 640, height = 640;                ///< pixels, 16 … 4096; the slice is fitted in
  double window_low = -160, window_high = 240;  ///< HU shown black and white
  std::map<std::uint16_t, Vec3> colors = {};    ///< sRGB of the outline of each label; labels without one get none
};

/// Draws a slice, interpolated, with an outline of one to two pixels along the inner side of each label's smoothed
/// boundary, a scale bar and the letters. Throws InputError for spans of a wrong length, a slice without values, sizes
/// that aren't positive, pixels out of range, a window that is empty.
Image render_slice(const SliceView& slice, const SliceOptions& options);

/// A strip as wide as told (pixels) that says what the colours mean, in as many lines as it takes.
Image color_legend(const std::vector<std::pair<std::string, Vec3>>& entries, int width,
                   Background background = Background::white);

/// Pictures below each other on one canvas, as wide as the widest; with an optional title on top.
Image stacked(const std::vector<Image>& rows, Background background = Background::white, const std::string& title = {});

}  // namespace calot
