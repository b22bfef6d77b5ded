// Inside this room only: drawing flat things on a finished picture.
#pragma once
#include <string_view>

#include "calot/picture/picture.h"

namespace calot::detail {

/// The colours of the ground and of what is written on it, sRGB.
Vec3 paper(Background background);
Vec3 ink(Background background);

/// Lines, boxes and words, with smooth edges, in sRGB. Coordinates are pixels, y down.
class Canvas {
 public:
  explicit Canvas(Image& image) : image_(image) {}
  /// A line with round ends; a dot where the ends meet.
  void line(double x0, double y0, double x1, double y1, double thickness, const Vec3& color);
  void box(double left, double top, double width, double height, const Vec3& color);
  /// Words whose baseline starts at (x, y); `size` is the height of a capital in pixels. @return where they end
  double text(double x, double y, double size, std::string_view words, const Vec3& color);

 private:
  void blend(int x, int y, double amount, const Vec3& color);
  Image& image_;
};

/// The length in pixels that words would take.
double text_width(double size, std::string_view words);

}  // namespace calot::detail
