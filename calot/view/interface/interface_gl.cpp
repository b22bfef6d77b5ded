#include "calot/view/interface/interface_gl.h"

#include <array>
#include <cstddef>

namespace calot::detail {
namespace {

constexpr std::array switches{GL_BLEND, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_CULL_FACE};

/// Puts back what drawing the interface changes.
class KeptState {
 public:
  KeptState() {
    for (std::size_t k = 0; k < switches.size(); ++k) was_[k] = glIsEnabled(switches[k]);
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
  }
  ~KeptState() {
    for (std::size_t k = 0; k < switches.size(); ++k)
      was_[k] == GL_TRUE ? glEnable(switches[k]) : glDisable(switches[k]);
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glBindVertexArray(0);
  }
  KeptState(const KeptState&) = delete;
  KeptState& operator=(const KeptState&) = delete;

 private:
  std::array<GLboolean, switches.size()> was_{};
  std::array<GLint, 4> viewport_{};
};

const void* offset(std::size_t bytes) {
  return reinterpret_cast<const void*>(bytes);
}

}  // namespace

InterfaceGl::InterfaceGl() : program_({"interface_vertex.glsl", "interface_fragment.glsl", {}}) {
  glBindVertexArray(layout_.number());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.number());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.number());
  for (GLuint k = 0; k < 3; ++k) glEnableVertexAttribArray(k);
  glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(ImDrawVert), offset(offsetof(ImDrawVert, pos)));
  glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, sizeof(ImDrawVert), offset(offsetof(ImDrawVert, uv)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(ImDrawVert), offset(offsetof(ImDrawVert, col)));
  glBindVertexArray(0);
}

void InterfaceGl::set_font(ImFontAtlas& atlas) {
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  atlas.GetTexDataAsAlpha8(&pixels, &width, &height);
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit_of_color));
  glBindTexture(GL_TEXTURE_2D, font_.number());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, width, height, 0, GL_RED, GL_UNSIGNED_BYTE, pixels);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

void InterfaceGl::draw(const ImDrawData& data) {
  const KeptState kept;
  const auto width = static_cast<GLsizei>(data.DisplaySize.x), height = static_cast<GLsizei>(data.DisplaySize.y);
  glViewport(0, 0, width, height);
  glEnable(GL_BLEND);
  glEnable(GL_SCISSOR_TEST);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  program_.use();
  program_.set("picture_size", Eigen::Vector2f(data.DisplaySize.x, data.DisplaySize.y));
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit_of_color));
  glBindTexture(GL_TEXTURE_2D, font_.number());
  glBindVertexArray(layout_.number());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.number());
  for (int k = 0; k < data.CmdListsCount; ++k) draw_list(*data.CmdLists[k], data.DisplaySize.y);
}

void InterfaceGl::draw_list(const ImDrawList& list, float height) {
  glBufferData(GL_ARRAY_BUFFER, list.VtxBuffer.size_in_bytes(), list.VtxBuffer.Data, GL_STREAM_DRAW);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, list.IdxBuffer.size_in_bytes(), list.IdxBuffer.Data, GL_STREAM_DRAW);
  for (const ImDrawCmd& command : list.CmdBuffer) {
    const ImVec4& clip = command.ClipRect;
    if (clip.z <= clip.x || clip.w <= clip.y || command.ElemCount == 0) continue;
    glScissor(static_cast<GLint>(clip.x), static_cast<GLint>(height - clip.w), static_cast<GLsizei>(clip.z - clip.x),
              static_cast<GLsizei>(clip.w - clip.y));
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(command.ElemCount), GL_UNSIGNED_SHORT,
                   offset(command.IdxOffset * sizeof(ImDrawIdx)));
  }
}

}  // namespace calot::detail
