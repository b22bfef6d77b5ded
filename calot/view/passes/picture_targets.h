// Inside this room only: what a picture is drawn into on its way.
#pragma once
#include "calot/view/gl/targets.h"

namespace calot::detail {

/// Made anew when the size changes.
struct PictureTargets {
  PictureTargets(int width, int height, int shadow_size, bool lite);
  int width, height, shadow_size;
  int half_width, half_height;
  GlTexture shadow, depth, color, screen, ambient, ambient_smooth;
  GlSampler plain_depth;  ///< reads the lamp's map as numbers, not as comparisons
  GlFramebuffer shadow_target, depth_target, color_target, light_target, screen_target, ambient_target, smooth_target;
};

}  // namespace calot::detail
