// What is seen: tissue, its inside where it was cut, instruments, the round field; the same bytes each time.
#include "calot/view/renderer.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "tests/view/renderer_picture.h"

namespace calot {
namespace {

using test::mean_color;

TEST(Renderer, TheSameMomentGivesTheSameBytes) {
  Scene scene = test::gallbladder_scene();
  test::add_instrument(scene, InstrumentKind::bowel_grasper, {0.012, 0, 0.008}, {0.3, 0.5, -1}, 0.5);
  const Snapshot snapshot = test::moment_of(scene);
  for (const PictureQuality quality : {PictureQuality::full, PictureQuality::lite}) {
    const Image first = test::picture_of(quality, snapshot, test::usual_camera());
    const Image second = test::picture_of(quality, snapshot, test::usual_camera());
    EXPECT_EQ(first.rgb, second.rgb) << name_of(quality);
  }
}

TEST(Renderer, OutsideTheRoundFieldItIsBlackAndInsideThereIsNoVoid) {
  const Snapshot snapshot = test::moment_of(test::gallbladder_scene());
  for (const PictureQuality quality : {PictureQuality::full, PictureQuality::lite}) {
    const Image image = test::picture_of(quality, snapshot, test::usual_camera());
    EXPECT_EQ(mean_color(image, 8, 8).norm(), 0);
    EXPECT_EQ(mean_color(image, 631, 180).norm(), 0);
    EXPECT_GT(mean_color(image, 320, 180).norm(), 60);  // the gallbladder
    for (const int y : {20, 90, 270, 340}) EXPECT_GT(mean_color(image, 320, y).maxCoeff(), 6) << y;
  }
}

TEST(Renderer, AFreeCameraFillsThePicture) {
  Camera camera = test::usual_camera();
  camera.scope = false;
  camera.field = 0.9F;
  const Image image = test::picture_of(PictureQuality::lite, test::moment_of(test::gallbladder_scene()), camera);
  EXPECT_GT(mean_color(image, 8, 180).maxCoeff(), 3);
  EXPECT_GT(mean_color(image, 631, 180).maxCoeff(), 3);
}

TEST(Renderer, ACutShowsTheTissuesInsideNotAHole) {
  const Scene scene = test::slab_scene("liver");
  const Snapshot before = test::moment_of(scene);
  const Snapshot after = test::moment_after_cut(scene, [](const Vec3& x) { return x.x() > 0 && x.z() > -4e-3; });
  const Camera camera = test::usual_camera(8, 55);
  for (const PictureQuality quality : {PictureQuality::full, PictureQuality::lite}) {
    const Vec3 skin = mean_color(test::picture_of(quality, before, camera), 330, 185, 6);
    const Image cut = test::picture_of(quality, after, camera);
    const Vec3 inside = mean_color(cut, 330, 185, 6);
    EXPECT_GT(inside.x(), 40) << inside.transpose();                 // lit
    EXPECT_GT(inside.x(), 1.15 * inside.z()) << inside.transpose();  // flesh
    EXPECT_GT((inside - skin).norm(), 6) << inside.transpose() << " / " << skin.transpose();
  }
}

TEST(Renderer, AnInstrumentCastsItsShadowOnTheSideAwayFromTheLamp) {
  Scene scene = test::slab_scene("peritoneum");
  test::add_instrument(scene, InstrumentKind::suction, {0, 0, 0.012}, {0, 0.3, -1}, 0);
  const Snapshot snapshot = test::moment_of(scene);
  for (const PictureQuality quality : {PictureQuality::full, PictureQuality::lite}) {
    Camera camera = test::usual_camera();
    camera.lamp = {0.025F, 0, 0};
    const Image right = test::picture_of(quality, snapshot, camera);
    camera.lamp = {-0.025F, 0, 0};
    const Image left = test::picture_of(quality, snapshot, camera);
    std::size_t lamp_right = 0, lamp_left = 0;  // pixels of the left half that are darker with that lamp
    for (int y = 0; y < 360; ++y)
      for (int x = 200; x < 320; ++x) {
        const auto i = static_cast<std::size_t>(3 * (y * 640 + x));
        lamp_right += right.rgb[i] + 40 < left.rgb[i] ? 1 : 0;
        lamp_left += left.rgb[i] + 40 < right.rgb[i] ? 1 : 0;
      }
    EXPECT_GT(lamp_right, lamp_left + 100) << name_of(quality);
  }
}

TEST(Renderer, NoneDrawsOnlyTheInterface) {
  test::shared_context().make_current();
  Renderer renderer(PictureQuality::none);
  const PictureCanvas canvas(64, 48);
  bool called = false;
  renderer.render(test::moment_of(test::slab_scene("liver")), {}, test::usual_camera(), canvas.canvas(), [&] {
    called = true;
    glClearColor(0, 1, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
  });
  EXPECT_TRUE(called);
  EXPECT_EQ(mean_color(canvas.read(), 30, 20), Vec3(0, 255, 0));
}

TEST(Renderer, ManySizesAndAnEmptyWorldAreDrawnInSilence) {
  const Snapshot nothing;
  for (const auto& [w, h] : {std::pair{16, 16}, {333, 77}, {640, 360}}) {
    (void)test::picture_of(PictureQuality::full, nothing, test::usual_camera(), {}, w, h);
    (void)test::picture_of(PictureQuality::lite, nothing, test::usual_camera(), {}, w, h);
  }
  EXPECT_THROW((void)test::picture_of(PictureQuality::lite, nothing, test::usual_camera(), {}, 8, 8), InputError);
}

}  // namespace
}  // namespace calot
