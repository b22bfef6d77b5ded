// What a picture must show, checked on its pixels.
#include "calot/picture/picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/parallel.h"
#include "calot/mesh/topology_edit.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

const Vec3 red{0.9, 0.1, 0.1}, blue{0.1, 0.1, 0.9};

/// A square facing −y, `depth` behind y = 0, of this half side.
Surface square(double depth, double half) {
  Surface s;
  s.positions = {{-half, depth, -half}, {half, depth, -half}, {half, depth, half}, {-half, depth, half}};
  s.triangles = {{0, 1, 2}, {0, 2, 3}};
  s.regions = {1, 2};
  return s;
}

/// Looks along +y; x is to the right, z up.
PictureOptions bare() {
  PictureOptions options;
  options.width = 120;
  options.height = 100;
  options.direction = {0, 1, 0};
  options.scale_bar = false;
  return options;
}

std::array<int, 3> pixel(const Image& image, int x, int y) {
  const std::size_t at = 3 * static_cast<std::size_t>(y * image.width + x);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}
std::array<int, 3> middle(const Image& image) {
  return pixel(image, image.width / 2, image.height / 2);
}
const std::array<int, 3> white{255, 255, 255};

int different_pixels(const Image& a, const Image& b) {
  int count = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) count += pixel(a, x, y) != pixel(b, x, y);
  return count;
}

TEST(Picture, ShowsASquareAndThePaperAroundIt) {
  const Surface s = square(0, 0.01);
  const Image image = render_picture({{.surface = &s, .color = red}}, bare());
  ASSERT_EQ(image.rgb.size(), 3u * 120 * 100);
  const auto [r, g, b] = middle(image);
  EXPECT_GT(r, 150);
  EXPECT_LT(g, 110);
  EXPECT_LT(b, 110);
  EXPECT_EQ(pixel(image, 1, 1), white);
  EXPECT_EQ(pixel(image, 118, 98), white);
}

TEST(Picture, FramesEverythingAndFillsTheView) {
  const TetMesh mesh = test::biliary_mesh(1);
  const Surface s = boundary_surface(mesh);
  for (const Vec3& direction : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0.3, -1, 0.8), Vec3(-1, -1, -1)}) {
    PictureOptions options = bare();
    options.direction = direction;
    const Image image = render_picture({{.surface = &s}}, options);
    int left = 200, right = -1, top = 200, bottom = -1;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (pixel(image, x, y) != white) {
          left = std::min(left, x), right = std::max(right, x);
          top = std::min(top, y), bottom = std::max(bottom, y);
        }
    EXPECT_GT(left, 3);
    EXPECT_LT(right, 116);
    EXPECT_GT(top, 3);
    EXPECT_LT(bottom, 96);
    EXPECT_TRUE(right - left > 80 || bottom - top > 65) << right - left << " × " << bottom - top;
  }
}

TEST(Picture, TheNearerSurfaceHidesTheFartherInAnyOrder) {
  const Surface near = square(-0.01, 0.005), far = square(0.01, 0.01);
  const PictureItem n{.surface = &near, .color = red}, f{.surface = &far, .color = blue};
  const Image one = render_picture({n, f}, bare()), other = render_picture({f, n}, bare());
  EXPECT_EQ(one.rgb, other.rgb);
  const auto [r, g, b] = middle(one);
  EXPECT_GT(r, b + 60);
  bool blue_seen = false;
  for (int x = 0; x < one.width; ++x) blue_seen |= pixel(one, x, 50)[2] > pixel(one, x, 50)[0] + 60;
  EXPECT_TRUE(blue_seen);
}

TEST(Picture, PenetratingSurfacesMeetInALine) {
  Surface tilted = square(0, 0.01);
  for (Vec3& p : tilted.positions) p.y() = p.x();  // nearer on the left
  const Surface flat = square(0, 0.01);
  const Image image = render_picture({{.surface = &flat, .color = blue}, {.surface = &tilted, .color = red}}, bare());
  EXPECT_GT(pixel(image, 45, 50)[0], pixel(image, 45, 50)[2]);
  EXPECT_LT(pixel(image, 75, 50)[0], pixel(image, 75, 50)[2]);
}

TEST(Picture, ATransparentSurfaceShowsWhatLiesBehind) {
  const Surface near = square(-0.01, 0.01), far = square(0.01, 0.01);
  const PictureItem behind{.surface = &far, .color = blue};
  const auto shown = [&](double opacity) {
    return middle(render_picture({{.surface = &near, .color = red, .opacity = opacity}, behind}, bare()));
  };
  EXPECT_GT(shown(0.5)[0], shown(0.1)[0]);
  EXPECT_GT(shown(0.5)[2], shown(0.9)[2]);
  EXPECT_EQ(shown(0.0), middle(render_picture({behind, {.surface = &near, .opacity = 0}}, bare())));
}

TEST(Picture, AnOverlayOfNearlyTheSameSurfaceIsEven) {
  const TetMesh mesh = test::biliary_mesh(1);
  const Surface s = boundary_surface(mesh);
  std::vector<Vec3> almost = s.positions;
  for (std::size_t v = 0; v < almost.size(); ++v) almost[v].y() += (v % 2 == 0 ? 1 : -1) * 1e-12;
  const auto picture = [&](const std::vector<Vec3>& positions) {
    return render_picture(
        {{.surface = &s, .color = red}, {.surface = &s, .positions = positions, .color = blue, .opacity = 0.5}},
        bare());
  };
  const Image same = picture(s.positions), jittered = picture(almost);
  for (std::size_t i = 0; i < same.rgb.size(); ++i) ASSERT_NEAR(same.rgb[i], jittered.rgb[i], 2);
}

TEST(Picture, RegionsAndCutFacesHaveTheirColours) {
  const Surface s = square(0, 0.01);
  const PictureItem regions{.surface = &s, .color = red, .region_colors = {{2, blue}}};
  const Image two = render_picture({regions}, bare());
  EXPECT_GT(pixel(two, 70, 60)[0], pixel(two, 70, 60)[2]);  // region 1: lower right
  EXPECT_LT(pixel(two, 50, 40)[0], pixel(two, 50, 40)[2]);
  const std::vector<std::uint8_t> flags{0, 1};
  const Image cut = render_picture({{.surface = &s, .color = red, .cut_faces = flags, .cut_color = blue}}, bare());
  EXPECT_EQ(cut.rgb, two.rgb);
}

TEST(Picture, PositionsMayBeTheMeshes) {
  const TetMesh mesh = test::biliary_mesh(1);
  const Surface s = boundary_surface(mesh);
  std::vector<Vec3> moved = mesh.positions, surface_moved;
  for (Vec3& p : moved) p.z() *= 1.5;
  for (const VertexId v : s.vertex_of_mesh) surface_moved.push_back(moved[v.index()]);
  const Image a = render_picture({{.surface = &s, .positions = moved}}, bare());
  const Image b = render_picture({{.surface = &s, .positions = surface_moved}}, bare());
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_GT(different_pixels(a, render_picture({{.surface = &s}}, bare())), 100);
}

TEST(Picture, AScalarIsReadAgainstTheColourBar) {
  const Surface s = square(0, 0.01);
  const std::vector<double> values{0, 1, 1, 0};  // from left to right
  PictureOptions options = bare();
  options.width = 300;
  options.scalar_label = "displacement [mm]";
  const Image image = render_picture({{.surface = &s, .scalar = values}}, options);
  const auto left = pixel(image, 95, 50), right = pixel(image, 150, 50);
  EXPECT_GT(left[2], left[0]);    // blue
  EXPECT_GT(right[1], right[2]);  // towards yellow
  EXPECT_GT(right[0] + right[1], left[0] + left[1]);
}

TEST(Picture, SameBytesTwiceAndOnAnyNumberOfThreads) {
  const TetMesh mesh = test::biliary_mesh(1);
  const Surface s = boundary_surface(mesh);
  PictureOptions options = bare();
  options.title = "title";
  options.scale_bar = true;
  const std::vector<PictureItem> items{{.surface = &s, .edges = true},
                                       {.surface = &s, .color = blue, .opacity = 0.3, .label = "at rest"}};
  const int threads = thread_count();
  set_thread_count(1);
  const Image one = render_picture(items, options);
  for (const int count : {1, 2, 4}) {
    set_thread_count(count);
    EXPECT_EQ(render_picture(items, options).rgb, one.rgb) << count << " threads";
  }
  set_thread_count(threads);
}

TEST(Picture, WordsTheScaleBarAndTheLegendLeaveInk) {
  const Surface s = square(0, 0.01);
  const auto ink = [&](const std::function<void(PictureItem&, PictureOptions&)>& change) {
    PictureOptions options = bare();
    options.frame = PictureFrame{{{-0.02, 0, -0.02}, {0.02, 0, 0.02}}};
    PictureItem item{.surface = &s};
    const Image before = render_picture({item}, options);
    change(item, options);
    return different_pixels(before, render_picture({item}, options));
  };
  EXPECT_GT(ink([](PictureItem&, PictureOptions& o) { o.caption = "words"; }), 20);
  EXPECT_GT(ink([](PictureItem&, PictureOptions& o) { o.title = "words"; }), 20);
  EXPECT_GT(ink([](PictureItem&, PictureOptions& o) { o.scale_bar = true; }), 20);
  EXPECT_GT(ink([](PictureItem& i, PictureOptions&) { i.label = "liver"; }), 20);
}

TEST(Picture, TheScaleBarMeasuresTheThingShown) {
  // A square of 20 mm and a bar in whole millimetres: their lengths in pixels must agree.
  const Surface s = square(0, 0.01);
  PictureOptions options = bare();
  options.width = options.height = 600;
  options.scale_bar = true;
  const Image image = render_picture({{.surface = &s, .color = red}}, options);
  int side = 0, bar = 0;
  for (int x = 0; x < image.width; ++x) side += pixel(image, x, image.height / 2) != white;
  for (int y = image.height - 60; y < image.height; ++y) {
    int dark = 0;
    for (int x = 0; x < image.width; ++x) dark += pixel(image, x, y)[0] < 120;
    bar = std::max(bar, dark);
  }
  const double millimetres = 20.0 * bar / side;
  EXPECT_NEAR(millimetres, 2, 0.15) << "bar " << bar << " px, square " << side << " px";
}

TEST(Picture, TheSameFrameGivesTheSameCamera) {
  const Surface s = square(-1e-6, 0.01), more = square(0, 0.03);
  PictureOptions options = bare();
  options.frame = frame_of({{.surface = &more}});
  const Image small = render_picture({{.surface = &s, .color = red}}, options);
  const Image both = render_picture({{.surface = &more, .color = blue}, {.surface = &s, .color = red}}, options);
  for (int x = 0; x < small.width; ++x) {
    const bool solid = pixel(small, x, 50)[1] < 100;
    EXPECT_TRUE(!solid || pixel(both, x, 50)[0] > pixel(both, x, 50)[2]) << x;
  }
  EXPECT_EQ(options.frame->points.size(), 4u);
}

TEST(Picture, FacesThatACutLaysOpenAreFound) {
  const TetMesh mesh = test::bar_mesh(8);
  TetMesh after = mesh;
  TopologyEdit edit;
  edit.removed = test::tets_where(mesh, [](const Vec3& p) { return p.x() > 0.05 && p.x() < 0.0625; });
  const Remap remap = apply(after, edit);
  const Surface before_surface = boundary_surface(mesh), after_surface = boundary_surface(after);
  const std::vector<std::uint8_t> flags = exposed_faces(before_surface, after_surface, remap.vertex_to_old);
  ASSERT_EQ(flags.size(), after_surface.triangles.size());
  for (std::size_t t = 0; t < flags.size(); ++t) {
    const auto& [a, b, c] = after_surface.triangles[t];
    const double x0 = after_surface.positions[a].x(), x1 = after_surface.positions[b].x(),
                 x2 = after_surface.positions[c].x();
    const bool in_gap = x0 == x1 && x1 == x2 && x0 > 0.04 && x0 < 0.07;
    EXPECT_EQ(flags[t] != 0, in_gap);
  }
}

TEST(Picture, ArrowsAndBallsAreClosedAndWhereTheyShouldBe) {
  const Surface arrow = arrow_surface({0, 0, 0}, {0, 0, 0.05}, 0.001);
  double low = 1, high = -1;
  for (const Vec3& p : arrow.positions) low = std::min(low, p.z()), high = std::max(high, p.z());
  EXPECT_NEAR(low, 0, 1e-12);
  EXPECT_NEAR(high, 0.05, 1e-12);
  EXPECT_TRUE(arrow_surface({1, 1, 1}, {1, 1, 1}, 0.1).triangles.empty());
  const std::vector<Vec3> centres{{0, 0, 0}, {1, 0, 0}};
  const Surface balls = ball_surface(centres, 0.1);
  double volume = 0;
  for (const auto& [a, b, c] : balls.triangles)
    volume += signed_volume(Vec3::Zero(), balls.positions[a], balls.positions[b], balls.positions[c]);
  EXPECT_NEAR(volume, 2 * 4.0 / 3 * M_PI * 1e-3, 3e-4);
}

TEST(Picture, BesidePutsPicturesInARow) {
  const Surface s = square(0, 0.01);
  const Image a = render_picture({{.surface = &s, .color = red}}, bare());
  PictureOptions lower = bare();
  lower.height = 60;
  const Image b = render_picture({{.surface = &s, .color = blue}}, lower);
  const Image row = beside({a, b});
  ASSERT_EQ(row.width, 240);
  ASSERT_EQ(row.height, 100);
  EXPECT_EQ(pixel(row, 60, 50), pixel(a, 60, 50));
  EXPECT_EQ(pixel(row, 180, 30), pixel(b, 60, 30));
  EXPECT_EQ(pixel(row, 180, 90), white);
}

TEST(Picture, APngReadsBackAndHoldsNoTime) {
  const auto path = std::filesystem::temp_directory_path() / "calot_picture_test.png";
  const Surface s = square(0, 0.01);
  write_picture(path, {{.surface = &s, .color = red}}, bare());
  const std::string bytes = read_file(path);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
  EXPECT_EQ(bytes.find("tEXt"), std::string::npos);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()));
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(header));
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, rgb.data(), 0, nullptr));
  EXPECT_EQ(rgb, render_picture({{.surface = &s, .color = red}}, bare()).rgb);
  std::filesystem::remove(path);
}

TEST(Picture, AnEmptyPictureIsPaper) {
  const Image image = render_picture({}, bare());
  EXPECT_EQ(middle(image), white);
  const Surface nothing;
  EXPECT_EQ(render_picture({{.surface = &nothing}}, bare()).rgb, image.rgb);
}

TEST(Picture, RefusesWhatItCantDraw) {
  const Surface s = square(0, 0.01);
  const std::vector<Vec3> few(3, Vec3::Zero());
  const std::vector<double> not_finite{0, 1, std::numeric_limits<double>::quiet_NaN(), 0};
  const std::vector<std::uint8_t> one_flag{1};
  Surface bad = s;
  bad.triangles.push_back({0, 1, 9});
  Surface nan = s;
  nan.positions[2].x() = std::numeric_limits<double>::infinity();
  for (const PictureItem& item :
       {PictureItem{}, PictureItem{.surface = &s, .positions = few}, PictureItem{.surface = &s, .scalar = not_finite},
        PictureItem{.surface = &s, .cut_faces = one_flag}, PictureItem{.surface = &s, .opacity = 1.5},
        PictureItem{.surface = &bad}, PictureItem{.surface = &nan}})
    EXPECT_THROW(render_picture({item}, bare()), InputError);
  PictureOptions along_up = bare(), huge = bare(), rays = bare();
  along_up.direction = {0, 0, -1};
  huge.width = 100000;
  rays.samples = 0;
  for (const PictureOptions& options : {along_up, huge, rays})
    EXPECT_THROW(render_picture({{.surface = &s}}, options), InputError);
}

}  // namespace
}  // namespace calot
