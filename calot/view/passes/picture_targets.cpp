#include "calot/view/passes/picture_targets.h"

namespace calot::detail {

PictureTargets::PictureTargets(int width_, int height_, int shadow_size_, bool lite)
    : width(width_),
      height(height_),
      shadow_size(shadow_size_),
      half_width((width_ + 1) / 2),
      half_height((height_ + 1) / 2) {
  shadow = make_texture(depth24, shadow_size, shadow_size, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  plain_depth = GlSampler::make();
  for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glSamplerParameteri(plain_depth.number(), name, GL_NEAREST);
  for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glSamplerParameteri(plain_depth.number(), name, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(plain_depth.number(), GL_TEXTURE_COMPARE_MODE, GL_NONE);
  shadow_target = make_framebuffer(0, shadow.number());
  depth = make_texture(depth24, width, height, GL_NEAREST);
  depth_target = make_framebuffer(0, depth.number());
  color = make_texture(lite ? rgba8 : rgba16f, width, height, GL_LINEAR);
  color_target = make_framebuffer(color.number(), depth.number());
  light_target = make_framebuffer(color.number(), 0);
  if (lite) return;
  screen = make_texture(rgba8, width, height, GL_LINEAR);
  screen_target = make_framebuffer(screen.number(), 0);
  ambient = make_texture(rgba16f, half_width, half_height, GL_NEAREST);
  ambient_target = make_framebuffer(ambient.number(), 0);
  ambient_smooth = make_texture(rgba16f, half_width, half_height, GL_NEAREST);
  smooth_target = make_framebuffer(ambient_smooth.number(), 0);
}

}  // namespace calot::detail
