#include "calot/view/passes/screen_passes.h"

namespace calot::detail {
namespace {

constexpr int sides = 96;  // as in screen_vertex.glsl

const ProgramKey blind_key{"blind_vertex.glsl", "depth_fragment.glsl", {}};
const ProgramKey ambient_key{"screen_vertex.glsl", "ambient_fragment.glsl", {}};
const ProgramKey blur_key{"screen_vertex.glsl", "blur_fragment.glsl", {}};
const ProgramKey tone_key{"screen_vertex.glsl", "tone_fragment.glsl", {}};
const ProgramKey lens_key{"screen_vertex.glsl", "lens_fragment.glsl", {}};

}  // namespace

std::vector<ProgramKey> all_screen_programs() {
  return {blind_key, ambient_key, blur_key, tone_key, lens_key};
}

ScreenPasses::ScreenPasses() : nothing_(GlVertexArray::make()) {}

void ScreenPasses::disc(const Program& program) {
  program.use();
  glBindVertexArray(nothing_.number());
  glDrawArrays(GL_TRIANGLE_FAN, 0, sides);
}

void ScreenPasses::blind() {
  programs_.get(blind_key).use();
  glBindVertexArray(nothing_.number());
  glDisable(GL_CULL_FACE);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 2 * sides + 2);
}

void ScreenPasses::ambient(const PictureTargets& targets) {
  glViewport(0, 0, targets.half_width, targets.half_height);
  bind_texture(unit_of_depth, GL_TEXTURE_2D, targets.depth.number());
  glBindFramebuffer(GL_FRAMEBUFFER, targets.ambient_target.number());
  disc(programs_.get(ambient_key));
  bind_texture(unit_of_color, GL_TEXTURE_2D, targets.ambient.number());
  glBindFramebuffer(GL_FRAMEBUFFER, targets.smooth_target.number());
  disc(programs_.get(blur_key));
  glViewport(0, 0, targets.width, targets.height);
}

void ScreenPasses::tone(const PictureTargets& targets) {
  bind_texture(unit_of_color, GL_TEXTURE_2D, targets.color.number());
  glBindFramebuffer(GL_FRAMEBUFFER, targets.screen_target.number());
  disc(programs_.get(tone_key));
}

void ScreenPasses::lens(const PictureTargets& targets, GLuint framebuffer) {
  bind_texture(unit_of_color, GL_TEXTURE_2D, targets.screen.number());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glClear(GL_COLOR_BUFFER_BIT);
  disc(programs_.get(lens_key));
}

}  // namespace calot::detail
