#include "calot/view/gl/targets.h"

#include <string>

#include "calot/base/error.h"

namespace calot::detail {

GlTexture make_texture(const PixelFormat& format, int width, int height, GLint filter) {
  GlTexture texture = GlTexture::make();
  glActiveTexture(GL_TEXTURE0 + 15);
  glBindTexture(GL_TEXTURE_2D, texture.number());
  glTexImage2D(GL_TEXTURE_2D, 0, format.internal, width, height, 0, format.format, format.type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  return texture;
}

GlFramebuffer make_framebuffer(GLuint color, GLuint depth) {
  GlFramebuffer framebuffer = GlFramebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.number());
  if (color != 0) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color, 0);
  if (depth != 0) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
  glDrawBuffer(color != 0 ? GL_COLOR_ATTACHMENT0 : GL_NONE);
  glReadBuffer(color != 0 ? GL_COLOR_ATTACHMENT0 : GL_NONE);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw FailedError("OpenGL", "can't draw into a texture (status " + std::to_string(status) + ")",
                      "update the graphics driver");
  return framebuffer;
}

void bind_texture(GLint unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture);
}

void* StreamBuffer::map(std::size_t bytes) {
  if (!buffer_) buffer_ = GlBuffer::make();
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.number());
  if (bytes > size_ || bytes < size_ / 4) size_ = bytes + bytes / 4;
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(size_), nullptr, GL_STREAM_DRAW);
  void* memory = glMapBufferRange(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes),
                                  GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT | GL_MAP_UNSYNCHRONIZED_BIT);
  if (memory == nullptr)
    throw FailedError("OpenGL", "gives no memory for the tissue's vertices", "close other programs");
  return memory;
}

bool StreamBuffer::unmap() {
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.number());
  return glUnmapBuffer(GL_ARRAY_BUFFER) == GL_TRUE;
}

GlBuffer make_buffer(GLenum target, const void* bytes, std::size_t size) {
  GlBuffer buffer = GlBuffer::make();
  glBindBuffer(target, buffer.number());
  glBufferData(target, static_cast<GLsizeiptr>(size), bytes, GL_STATIC_DRAW);
  return buffer;
}

void attribute(GLuint location, GLint count, GLenum type, bool normalised, std::size_t stride, std::size_t offset) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, count, type, normalised ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                        reinterpret_cast<const void*>(offset));
}

}  // namespace calot::detail
