// Inside this room only: triangles of the interface to OpenGL.
#pragma once
#include <imgui.h>

#include <memory>

#include "calot/view/gl/program.h"

namespace calot::detail {

/// Buffers, the font's texture and a program in one context.
class InterfaceGl {
 public:
  InterfaceGl();
  void set_font(ImFontAtlas& atlas);
  /// Into the framebuffer that is bound; leaves OpenGL's switches as they were.
  void draw(const ImDrawData& data);

 private:
  void draw_list(const ImDrawList& list, float height);
  Program program_;
  GlVertexArray layout_ = GlVertexArray::make();
  GlBuffer vertices_ = GlBuffer::make(), indices_ = GlBuffer::make();
  GlTexture font_ = GlTexture::make();
};

}  // namespace calot::detail
