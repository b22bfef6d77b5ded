// Inside this room only: passes over the whole field: what lies outside it, ambient light, tone and lens.
#pragma once
#include "calot/view/gl/program.h"
#include "calot/view/passes/picture_targets.h"

namespace calot::detail {

std::vector<ProgramKey> all_screen_programs();

class ScreenPasses {
 public:
  ScreenPasses();
  /// Shuts everything outside the round field off, in depth.
  void blind();
  /// Half as wide and high: how open each place is.
  void ambient(const PictureTargets& targets);
  /// Light to screen values, then through the lens into `framebuffer`.
  void tone(const PictureTargets& targets);
  void lens(const PictureTargets& targets, GLuint framebuffer);

 private:
  void disc(const Program& program);
  GlVertexArray nothing_;
  ProgramCache programs_;
};

}  // namespace calot::detail
