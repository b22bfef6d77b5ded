// Inside this room only: textures and framebuffers to draw into, and buffers that are filled anew in each picture.
#pragma once
#include <cstddef>
#include <span>

#include "calot/view/gl/objects.h"

namespace calot::detail {

struct PixelFormat {
  GLint internal;
  GLenum format, type;
};
inline constexpr PixelFormat rgba8{GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE};
inline constexpr PixelFormat rgba16f{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT};
inline constexpr PixelFormat depth24{GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT};

/// An empty texture, clamped at its edges.
GlTexture make_texture(const PixelFormat& format, int width, int height, GLint filter);
/// A framebuffer of these; 0: without. Throws FailedError where the driver can't draw into it.
GlFramebuffer make_framebuffer(GLuint color, GLuint depth);
void bind_texture(GLint unit, GLenum target, GLuint texture);

/// A vertex buffer that is filled anew each time; the driver gives fresh memory while the old is still read.
class StreamBuffer {
 public:
  /// Memory for `bytes`, to be written wholly and then given back by `unmap`.
  void* map(std::size_t bytes);
  /// @return false where the contents were lost meanwhile (a lost display): draw nothing, fill it again
  bool unmap();
  [[nodiscard]] GLuint number() const { return buffer_.number(); }

 private:
  GlBuffer buffer_;
  std::size_t size_ = 0;
};

/// A buffer with contents that stay.
GlBuffer make_buffer(GLenum target, const void* bytes, std::size_t size);

/// One attribute of the vertex array and array buffer bound now.
void attribute(GLuint location, GLint count, GLenum type, bool normalised, std::size_t stride, std::size_t offset);

}  // namespace calot::detail
