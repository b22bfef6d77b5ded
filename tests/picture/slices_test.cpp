// CT slices with outlines.
#include "calot/picture/slices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calot/base/parallel.h"
#include "tests/support/files.h"

using namespace calot;
using calot::test::message_of;

namespace {

struct Pixel {
  int r, g, b;
};
Pixel pixel(const Image& image, int x, int y) {
  const std::size_t at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}
bool reddish(const Pixel& p) {
  return p.r > p.g + 40;
}

/// A slice without words, so that its pixels are all picture. Holds the values that the view points to.
struct TestSlice {
  std::vector<std::int16_t> grey;
  std::vector<std::uint16_t> labels;
  SliceView view;

  TestSlice(int columns, int rows, double column_size = 1e-3, double row_size = 1e-3)
      : grey(static_cast<std::size_t>(columns * rows), 0), labels(grey.size(), 0) {
    view.columns = columns;
    view.rows = rows;
    view.column_size = column_size;
    view.row_size = row_size;
  }
  const SliceView& get() {
    view.grey = grey;
    view.labels = labels;
    return view;
  }
};

TEST(Slices, GreyFollowsTheWindowAndIsInterpolated) {
  TestSlice slice(100, 100);
  for (std::size_t v = 0; v < slice.grey.size(); ++v) slice.grey[v] = static_cast<std::int16_t>(-500 + 10 * (v % 100));
  SliceOptions options;
  options.width = options.height = 400;
  options.window_low = -200;
  options.window_high = 200;
  const Image image = render_slice(slice.get(), options);
  ASSERT_EQ(image.width, 400);
  ASSERT_EQ(image.height, 400);
  for (int x = 20; x < 380; ++x) {
    const double hu = -500 + 10 * ((x + 0.5) / 4 - 0.5);
    EXPECT_NEAR(pixel(image, x, 40).r, 255 * std::clamp((hu + 200) / 400, 0.0, 1.0), 1.6) << x;
    EXPECT_EQ(pixel(image, x, 40).r, pixel(image, x, 40).b);
  }
}

TEST(Slices, TheFirstRowIsOnTopAndTheFirstColumnOnTheLeft) {
  TestSlice slice(40, 20);
  for (std::size_t v = 0; v < slice.grey.size(); ++v) slice.grey[v] = -1000;
  for (std::size_t row = 0; row < 5; ++row)
    for (std::size_t column = 0; column < 10; ++column) slice.grey[row * 40 + column] = 1000;
  SliceOptions options;
  options.width = 400;
  options.height = 200;
  const Image image = render_slice(slice.get(), options);
  EXPECT_EQ(pixel(image, 40, 20).g, 255);
  EXPECT_EQ(pixel(image, 340, 20).g, 0);
  EXPECT_EQ(pixel(image, 40, 100).g, 0);
}

TEST(Slices, VoxelsOfAnyShapeAreShownInTrueProportion) {
  TestSlice slice(50, 20, 1e-3, 4e-3);  // 50 mm x 80 mm
  for (std::int16_t& hu : slice.grey) hu = 1000;
  SliceOptions options;
  options.width = options.height = 320;
  const Image image = render_slice(slice.get(), options);
  int across = 0, down = 0;
  for (int i = 0; i < 320; ++i) {
    across += pixel(image, i, 40).r > 127;
    down += pixel(image, 160, i).r > 127;
  }
  EXPECT_NEAR(across, 200, 2);
  EXPECT_NEAR(down, 320, 2);
}

TEST(Slices, OutlinesLieInsideTheLabelAlongItsRim) {
  constexpr int n = 80;
  constexpr double radius = 25;  // voxels
  TestSlice slice(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      if (std::hypot(i - 39.5, j - 39.5) < radius) slice.labels[static_cast<std::size_t>(j * n + i)] = 7;
  for (std::int16_t& hu : slice.grey) hu = 40;
  SliceOptions options;
  options.width = options.height = 4 * n;
  options.colors = {{7, {1, 0.1, 0}}};
  const Image image = render_slice(slice.get(), options);
  double covered = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Pixel p = pixel(image, x, y);
      const double from_rim = std::hypot(x + 0.5 - 160, y + 0.5 - 160) - 4 * radius;  // pixels
      if (p.r != p.g) {
        EXPECT_GT(from_rim, -5) << x << " " << y;
        EXPECT_LT(from_rim, 3) << x << " " << y;
      }
      covered += (p.r - p.g) / (255 * 0.9);
    }
  const double thickness = covered / (2 * M_PI * 4 * radius);
  EXPECT_GT(thickness, 1.0);
  EXPECT_LT(thickness, 2.0);
}

TEST(Slices, ALabelWithoutColourGetsNoOutlineAndASingleVoxelIsSeen) {
  TestSlice slice(30, 30);
  slice.labels[10 * 30 + 10] = 3;
  slice.labels[20 * 30 + 20] = 4;
  SliceOptions options;
  options.width = options.height = 300;
  options.colors = {{3, {1, 0, 0}}};
  const Image image = render_slice(slice.get(), options);
  int near_three = 0, near_four = 0;
  for (int y = -10; y < 10; ++y)
    for (int x = -10; x < 10; ++x) {
      near_three += reddish(pixel(image, 105 + x, 105 + y));
      near_four += reddish(pixel(image, 205 + x, 205 + y));
    }
  EXPECT_GT(near_three, 10);
  EXPECT_EQ(near_four, 0);
}

TEST(Slices, LettersStandAtTheirEdges) {
  TestSlice slice(100, 100);
  for (std::int16_t& hu : slice.grey) hu = -1000;
  SliceOptions options;
  options.width = options.height = 400;
  const auto bright = [](const Image& image, int left, int top, int right, int bottom) {
    int count = 0;
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) count += pixel(image, x, y).r > 150;
    return count;
  };
  slice.view.left = std::string("R");
  Image image = render_slice(slice.get(), options);
  EXPECT_GT(bright(image, 0, 180, 30, 220), 5);
  EXPECT_EQ(bright(image, 370, 180, 400, 220), 0);
  EXPECT_EQ(bright(image, 180, 0, 220, 30), 0);
  slice.view.left = std::string("");
  slice.view.top = std::string("A");
  slice.view.right = std::string("L");
  image = render_slice(slice.get(), options);
  EXPECT_EQ(bright(image, 0, 180, 30, 220), 0);
  EXPECT_GT(bright(image, 370, 180, 400, 220), 5);
  EXPECT_GT(bright(image, 180, 0, 220, 30), 5);
}

TEST(Slices, TheSameBytesOnAnyNumberOfThreads) {
  TestSlice slice(60, 50);
  for (std::size_t v = 0; v < slice.grey.size(); ++v) {
    slice.grey[v] = static_cast<std::int16_t>((v * 7919) % 400);
    slice.labels[v] = static_cast<std::uint16_t>((v / 300) % 3);
  }
  slice.view.title = std::string("axial");
  SliceOptions options;
  options.colors = {{1, {1, 0, 0}}, {2, {0, 1, 0}}};
  const int threads = thread_count();
  set_thread_count(1);
  const Image one = render_slice(slice.get(), options);
  set_thread_count(3);
  const Image three = render_slice(slice.get(), options);
  set_thread_count(threads);
  EXPECT_EQ(one.rgb, three.rgb);
}

TEST(Slices, BadCallsAreRefused) {
  TestSlice slice(10, 10);
  SliceOptions options;
  const auto refused = [&](const SliceView& view, const SliceOptions& o, const std::string& why) {
    EXPECT_NE(message_of([&] { render_slice(view, o); }).find(why), std::string::npos) << why;
  };
  SliceView view = slice.get();
  view.grey = view.grey.first(99);
  refused(view, options, "99 grey values");
  view = slice.get();
  view.labels = view.labels.first(7);
  refused(view, options, "7 labels");
  view = slice.get();
  view.rows = 0;
  refused(view, options, "no values");
  view = slice.get();
  view.row_size = NAN;
  refused(view, options, "no size");
  options.window_high = options.window_low;
  refused(slice.get(), options, "window");
  options = {};
  options.width = 5;
  refused(slice.get(), options, "5 pixels");
}

TEST(Slices, StackedPicturesKeepTheirPixels) {
  const auto plain = [](int width, int height, std::uint8_t value) {
    return Image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height), value)};
  };
  const Image all = stacked({plain(30, 10, 7), plain(20, 5, 9)});
  EXPECT_EQ(all.width, 30);
  EXPECT_EQ(all.height, 15);
  EXPECT_EQ(pixel(all, 29, 9).g, 7);
  EXPECT_EQ(pixel(all, 19, 14).g, 9);
  EXPECT_EQ(pixel(all, 20, 14).g, 255);
  const Image titled = stacked({plain(300, 10, 7)}, Background::white, "a title");
  EXPECT_GT(titled.height, 30);
  EXPECT_EQ(pixel(titled, 299, titled.height - 1).g, 7);
}

TEST(Slices, TheLegendTakesAsManyLinesAsItNeeds) {
  const std::vector<std::pair<std::string, Vec3>> entries(6, {"common bile duct", Vec3(1, 0, 0)});
  const Image wide = color_legend(entries, 2000), narrow = color_legend(entries, 300);
  EXPECT_EQ(wide.width, 2000);
  EXPECT_EQ(narrow.width, 300);
  EXPECT_GT(narrow.height, 3 * wide.height);
  int red = 0;
  for (int y = 0; y < narrow.height; ++y) red += reddish(pixel(narrow, 25, y));
  EXPECT_GT(red, 40);
}

}  // namespace
