// The pieces that a picture is made of.
#include <gtest/gtest.h>

#include <cmath>

#include "calot/picture/camera.h"
#include "calot/picture/canvas.h"
#include "calot/picture/color.h"
#include "calot/picture/glyphs.h"

namespace calot::detail {
namespace {

TEST(Color, SrgbAndBack) {
  for (double c = 0; c <= 1; c += 0.01) EXPECT_NEAR(srgb_of(linear_of(Vec3::Constant(c))).x(), c, 1e-12);
}

TEST(Color, TheMapGrowsLighterEvenlyAndStaysWithinTheScreensColours) {
  const auto lightness = [](double t) {  // CIE L*
    const Vec3 c = colormap(t);
    return 116 * std::cbrt(0.2126 * c.x() + 0.7152 * c.y() + 0.0722 * c.z()) - 16;
  };
  double least = 1e9, most = 0;
  for (double t = 0; t < 0.995; t += 0.05) {
    const double step = lightness(t + 0.05) - lightness(t);
    least = std::min(least, step), most = std::max(most, step);
  }
  EXPECT_GT(least, 0.5 * most);
  EXPECT_EQ(colormap(-1), colormap(0));
  EXPECT_EQ(colormap(2), colormap(1));
  EXPECT_GT(colormap(0).z(), colormap(0).x());  // blue
  EXPECT_GT(colormap(1).y(), colormap(1).z());  // yellow
}

TEST(Camera, LooksAlongTheDirectionWithUpUp) {
  const std::vector<Vec3> points{{-1, 0, -1}, {1, 0, 1}, {0, 1, 0}};
  const Camera camera = frame_camera(points, {0, 2, 0}, {0, 0, 5}, {0, 0, 200, 100});
  EXPECT_NEAR((camera.right - Vec3(1, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((camera.up - Vec3(0, 0, 1)).norm(), 0, 1e-12);
  const Vec3 high = camera.project({0, 0, 1}), low = camera.project({0, 0, -1});
  EXPECT_LT(high.y(), low.y());
  EXPECT_NEAR(high.x(), 100, 1e-9);
  EXPECT_LT(camera.project({0, 1, 0}).z(), camera.project({0, 0, 0}).z());
  for (const Vec3& p : points) {
    EXPECT_GE(camera.project(p).y(), -1e-9);
    EXPECT_LE(camera.project(p).y(), 100 + 1e-9);
  }
}

TEST(Camera, ASinglePointIsInTheMiddle) {
  const std::vector<Vec3> points{{3, 4, 5}};
  const Vec3 at = frame_camera(points, {1, 1, 1}, {0, 0, 1}, {10, 20, 100, 60}).project(points[0]);
  EXPECT_NEAR(at.x(), 60, 1e-6);
  EXPECT_NEAR(at.y(), 50, 1e-6);
}

TEST(Glyphs, EveryPrintableCharacterOfOurTextsHasOne) {
  const std::size_t box = glyph(U'\ufffd').strokes[0].size();
  for (char32_t c = U'!'; c <= U'z'; ++c) {
    if (c == U'$' || c == U'@' || c == U'\\' || c == U'^' || c == U'`') continue;
    EXPECT_FALSE(&glyph(c) == &glyph(U'\ufffd')) << static_cast<char>(c);
    for (const GlyphStroke& stroke : glyph(c).strokes)
      for (const GlyphPoint& p : stroke)
        EXPECT_TRUE(p.x >= 0 && p.x <= 10 && p.y >= 0 && p.y <= 13) << static_cast<char>(c);
  }
  EXPECT_GT(box, 0u);
}

TEST(Glyphs, Utf8IsReadAndBadBytesAreMarked) {
  EXPECT_EQ(characters_of("aµ…"), U"aµ…");
  EXPECT_EQ(characters_of("\xc2"), U"\ufffd");
  EXPECT_EQ(characters_of("\x80z"), U"\ufffdz");
  EXPECT_EQ(characters_of("\xe2\x82"), U"\ufffd");
}

TEST(Canvas, ALineIsAsThickAsAskedAndBlendsAtItsEdges) {
  Image image{20, 20, std::vector<std::uint8_t>(3 * 400, 255)};
  Canvas canvas(image);
  canvas.line(5, 10, 15, 10, 4, {0, 0, 0});
  const auto grey = [&](int x, int y) { return image.rgb[3 * static_cast<std::size_t>(20 * y + x)]; };
  EXPECT_EQ(grey(10, 9), 0);
  EXPECT_EQ(grey(10, 10), 0);
  EXPECT_EQ(grey(10, 14), 255);
  EXPECT_EQ(grey(1, 10), 255);
  canvas.line(-50, -50, 50, 50, 3, {0, 0, 0});  // beyond the edges: clipped
  canvas.box(18.5, 0, 100, 3, {0, 0, 0});
  EXPECT_NEAR(grey(18, 1), 128, 1);
  EXPECT_EQ(grey(19, 1), 0);
}

TEST(Canvas, TextEndsWhereItsWidthSays) {
  Image image{200, 40, std::vector<std::uint8_t>(3 * 8000, 255)};
  const double unit = 9.0 / glyph_cap_height;
  EXPECT_NEAR(Canvas(image).text(10, 30, 9, "Calot 12.5", {0, 0, 0}),
              10 + text_width(9, "Calot 12.5") + glyph_spacing * unit, 1e-9);
  EXPECT_EQ(text_width(9, ""), 0);
}

}  // namespace
}  // namespace calot::detail
