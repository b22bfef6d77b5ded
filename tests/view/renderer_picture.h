// Pictures in the renderer's tests: one context for a program, what is seen, and how far two pictures differ.
#pragma once
#include <filesystem>

#include "calot/view/gl/context.h"
#include "tests/view/renderer_scenes.h"

namespace calot::test {

/// One for the whole program; made when first asked for.
OffscreenContext& shared_context();

Image picture_of(PictureQuality quality, const Snapshot& snapshot, const Camera& camera,
                 const EffectsState& effects = {}, int width = 640, int height = 360);

/// Mean of a square of pixels around a place, each channel 0 … 255.
Vec3 mean_color(const Image& image, int x, int y, int half = 4);

/// Peak signal-to-noise ratio [dB]; infinite for the same pictures. −1 for other sizes.
double psnr(const Image& a, const Image& b);

Image read_picture(const std::filesystem::path& path);

/// Compares with tests/view/golden/NAME.png, at least 40 dB; with CALOT_WRITE_GOLDEN set writes that file instead.
void expect_golden(const std::string& name, const Image& image);

}  // namespace calot::test
