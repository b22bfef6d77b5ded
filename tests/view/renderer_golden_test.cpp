// A dozen small scenes against the pictures that were judged good.
#include <gtest/gtest.h>

#include "tests/view/renderer_picture.h"

namespace calot {
namespace {

using test::expect_golden;
using test::picture_of;
using test::usual_camera;

Vec3f float_place(double x, double y, double z) {
  return Vec3f(Vec3(x, y, z).cast<float>());
}

/// Blood around a place, as the effects would leave it.
EffectsState bled_on(const Snapshot& snapshot) {
  Eigen::AlignedBox3f box;
  for (const SkinVertex& v : snapshot.skin.vertices) box.extend(v.rest);
  EffectsState effects;
  effects.mask = MaskVolume(box, 0.75e-3F, 8U << 20U);
  effects.mask.paint(MaskChannel::blood, float_place(-0.004, 0.002, 0), 0.006F, 255, 0.5F);
  effects.mask.paint(MaskChannel::wet, float_place(-0.004, 0.002, 0), 0.007F, 255);
  effects.mask.paint(MaskChannel::charred, float_place(0.008, -0.004, 0), 0.003F, 255, 0.5F);
  effects.mask.paint(MaskChannel::bile, float_place(0.006, 0.008, 0), 0.004F, 255, 0.5F);
  return effects;
}

TEST(RendererGolden, EachTissue) {
  for (const char* region : {"liver", "fat", "peritoneum"})
    expect_golden(std::string("slab_") + region,
                  picture_of(PictureQuality::full, test::moment_of(test::slab_scene(region)), usual_camera(0, 48)));
}

TEST(RendererGolden, GallbladderAtBothTiers) {
  const Snapshot snapshot = test::moment_of(test::gallbladder_scene());
  expect_golden("gallbladder_full", picture_of(PictureQuality::full, snapshot, usual_camera()));
  expect_golden("gallbladder_lite", picture_of(PictureQuality::lite, snapshot, usual_camera()));
}

TEST(RendererGolden, CutFaceCloseUp) {
  const Snapshot snapshot =
      test::moment_after_cut(test::gallbladder_scene(), [](const Vec3& x) { return std::abs(x.x() + 0.014) < 2e-3; });
  Camera camera = camera_looking({0.002F, -0.012F, 0.018F}, {-0.016F, 0, 0}, {0, 0, 1});
  expect_golden("cut_duct", picture_of(PictureQuality::full, snapshot, camera));
  const Snapshot slab =
      test::moment_after_cut(test::slab_scene("liver"), [](const Vec3& x) { return x.x() > 0 && x.z() > -4e-3; });
  expect_golden("cut_liver", picture_of(PictureQuality::lite, slab, usual_camera(4, 48)));
}

TEST(RendererGolden, BurntBlanchedAndBruised) {
  Snapshot snapshot = test::moment_of(test::slab_scene("liver"));
  for (std::size_t i = 0; i < snapshot.positions.size(); ++i) {
    const Vec3f& p = snapshot.positions[i];
    const auto near = [&](float x, float y) { return std::exp(-((p - Vec3f(x, y, 0)).squaredNorm() / 3.2e-5F)); };
    snapshot.conditions[i] = {near(-0.010F, 0), near(-0.011F, 0), near(0.004F, 0.006F), near(0.010F, -0.008F)};
  }
  expect_golden("conditions", picture_of(PictureQuality::full, snapshot, usual_camera(0, 48)));
}

TEST(RendererGolden, BloodBileAndCharOnTheMask) {
  const Snapshot snapshot = test::moment_of(test::slab_scene("peritoneum"));
  expect_golden("mask", picture_of(PictureQuality::lite, snapshot, usual_camera(0, 48), bled_on(snapshot)));
}

TEST(RendererGolden, DropsSparksSmokeAndHaze) {
  const Snapshot snapshot = test::moment_of(test::slab_scene("liver"));
  EffectsState effects;
  for (int k = 0; k < 6; ++k) {
    const float t = static_cast<float>(k);
    effects.drops.push_back({Vec3f(-0.012F + 0.003F * t, -0.004F, 0.004F), Vec3f(0, 0, -0.2F * t), 0.0008F,
                             k % 2 == 0 ? Fluid::blood : Fluid::bile});
    effects.sparks.push_back({Vec3f(0.008F, 0.002F * t, 0.003F), Vec3f(0.4F, 0.1F * t, 0.6F), 1 - 0.15F * t});
    effects.puffs.push_back({Vec3f(0.006F, 0.004F, 0.006F + 0.004F * t), 0.004F + 0.002F * t, 0.9F, t, 0.17F * t,
                             k < 4 ? PuffKind::smoke : PuffKind::steam});
  }
  effects.haze = 2;
  expect_golden("effects", picture_of(PictureQuality::full, snapshot, usual_camera(0, 60), effects));
  expect_golden("effects_lite", picture_of(PictureQuality::lite, snapshot, usual_camera(0, 60), effects));
}

TEST(RendererGolden, Instruments) {
  Scene scene = test::gallbladder_scene();
  test::add_instrument(scene, InstrumentKind::bowel_grasper, {0.014, -0.001, 0.009}, {0.35, 0.45, -1}, 0.5);
  test::add_instrument(scene, InstrumentKind::scissors, {-0.014, 0.002, 0.004}, {-0.5, 0.4, -1}, 0.5);
  test::add_instrument(scene, InstrumentKind::hook, {-0.002, 0.006, 0.006}, {0.1, -0.6, -1}, 0);
  const Snapshot snapshot = test::moment_of(scene);
  expect_golden("instruments", picture_of(PictureQuality::full, snapshot, usual_camera()));
  Camera free = usual_camera(0, 110);
  free.scope = false;
  free.field = 0.8F;
  expect_golden("spectator", picture_of(PictureQuality::lite, snapshot, free));
}

TEST(RendererGolden, PsnrIsWhatItSays) {
  const Image a{2, 1, {0, 0, 0, 255, 255, 255}}, b{2, 1, {0, 0, 0, 255, 255, 245}};
  EXPECT_NEAR(test::psnr(a, b), 10 * std::log10(255.0 * 255.0 * 6 / 100), 1e-9);
  EXPECT_GT(test::psnr(a, a), 1e9);
  EXPECT_EQ(test::psnr(a, Image{1, 1, {0, 0, 0}}), -1);
}

}  // namespace
}  // namespace calot
