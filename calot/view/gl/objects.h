// Inside this room only: OpenGL's objects as values that free themselves.
#pragma once
#include <epoxy/gl.h>

#include <utility>

namespace calot::detail {

/// A number that OpenGL gave out; given back when it dies. 0: none.
template <class Kind>
class GlObject {
 public:
  GlObject() = default;
  static GlObject make() {
    GlObject object;
    object.number_ = Kind::make();
    return object;
  }
  ~GlObject() { reset(); }
  GlObject(GlObject&& other) noexcept : number_(std::exchange(other.number_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    if (this != &other) {
      reset();
      number_ = std::exchange(other.number_, 0);
    }
    return *this;
  }
  [[nodiscard]] GLuint number() const { return number_; }
  explicit operator bool() const { return number_ != 0; }

 private:
  void reset() {
    if (number_ != 0) Kind::free(std::exchange(number_, 0));
  }
  GLuint number_ = 0;
};

struct BufferKind {
  static GLuint make() {
    GLuint number = 0;
    glGenBuffers(1, &number);
    return number;
  }
  static void free(GLuint number) { glDeleteBuffers(1, &number); }
};
struct VertexArrayKind {
  static GLuint make() {
    GLuint number = 0;
    glGenVertexArrays(1, &number);
    return number;
  }
  static void free(GLuint number) { glDeleteVertexArrays(1, &number); }
};
struct TextureKind {
  static GLuint make() {
    GLuint number = 0;
    glGenTextures(1, &number);
    return number;
  }
  static void free(GLuint number) { glDeleteTextures(1, &number); }
};
struct SamplerKind {
  static GLuint make() {
    GLuint number = 0;
    glGenSamplers(1, &number);
    return number;
  }
  static void free(GLuint number) { glDeleteSamplers(1, &number); }
};
struct FramebufferKind {
  static GLuint make() {
    GLuint number = 0;
    glGenFramebuffers(1, &number);
    return number;
  }
  static void free(GLuint number) { glDeleteFramebuffers(1, &number); }
};
struct ProgramKind {
  static GLuint make() { return glCreateProgram(); }
  static void free(GLuint number) { glDeleteProgram(number); }
};

using GlBuffer = GlObject<BufferKind>;
using GlVertexArray = GlObject<VertexArrayKind>;
using GlTexture = GlObject<TextureKind>;
using GlSampler = GlObject<SamplerKind>;
using GlFramebuffer = GlObject<FramebufferKind>;
using GlProgram = GlObject<ProgramKind>;

}  // namespace calot::detail
