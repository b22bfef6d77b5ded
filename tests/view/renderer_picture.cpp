#include "tests/view/renderer_picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace calot::test {

OffscreenContext& shared_context() {
  static OffscreenContext context;
  return context;
}

Image picture_of(PictureQuality quality, const Snapshot& snapshot, const Camera& camera, const EffectsState& effects,
                 int width, int height) {
  OffscreenContext& context = shared_context();
  context.make_current();
  context.log().clear();
  Renderer renderer(quality);
  const PictureCanvas canvas(width, height);
  renderer.render(snapshot, effects, camera, canvas.canvas());
  Image image = canvas.read();
  EXPECT_TRUE(context.log().listens());
  for (const std::string& message : context.log().messages()) ADD_FAILURE() << "OpenGL says: " << message;
  return image;
}

Vec3 mean_color(const Image& image, int x, int y, int half) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (int v = std::max(0, y - half); v <= std::min(image.height - 1, y + half); ++v)
    for (int u = std::max(0, x - half); u <= std::min(image.width - 1, x + half); ++u, ++count)
      for (int c = 0; c < 3; ++c) sum[c] += image.rgb[static_cast<std::size_t>(3 * (v * image.width + u) + c)];
  return sum / std::max(1, count);
}

double psnr(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) return -1;
  double squares = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) squares += (a.rgb[i] - b.rgb[i]) * (a.rgb[i] - b.rgb[i]);
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.rgb.size()) / squares);
}

Image read_picture(const std::filesystem::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) return {};
  png.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  if (png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) == 0) return {};
  return image;
}

void expect_golden(const std::string& name, const Image& image) {
  const std::filesystem::path path = std::filesystem::path(CALOT_GOLDEN_FOLDER) / (name + ".png");
  if (std::getenv("CALOT_WRITE_GOLDEN") != nullptr) {
    std::filesystem::create_directories(path.parent_path());
    write_png(path, image);
    return;
  }
  const Image golden = read_picture(path);
  ASSERT_GT(golden.width, 0) << path << " can't be read";
  EXPECT_GE(psnr(image, golden), 40) << name;
}

}  // namespace calot::test
