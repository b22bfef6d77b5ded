#include "calot/view/gl/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>

#include "calot/base/error.h"

namespace calot {
namespace {

FailedError no_driver(const std::string& what) {
  return {"OpenGL", what, "install Mesa's software renderer: apt-get install libgl1-mesa-dri libegl1"};
}

EGLDisplay open_display() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base") ||
      !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    throw no_driver("EGL can't draw without a display here");
  EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE)
    throw no_driver("EGL can't be started");
  return display;
}

EGLContext open_context(EGLDisplay display) {
  constexpr std::array<EGLint, 9> wanted{EGL_CONTEXT_MAJOR_VERSION,
                                         3,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         3,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_CONTEXT_OPENGL_DEBUG,
                                         EGL_TRUE,
                                         EGL_NONE};
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) throw no_driver("EGL has no OpenGL");
  EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
  if (context == EGL_NO_CONTEXT) throw no_driver("the driver has no OpenGL 3.3 core");
  return context;
}

}  // namespace

OffscreenContext::OffscreenContext() : display_(open_display()) {
  context_ = open_context(display_);
  make_current();
  log_ = std::make_unique<DebugLog>();
}

OffscreenContext::~OffscreenContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

void OffscreenContext::make_current() {
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE)
    throw no_driver("the context can't be used on this thread");
}

void OffscreenContext::release() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

std::string driver_name() {
  const auto text = [](GLenum name) {
    const auto* value = reinterpret_cast<const char*>(glGetString(name));
    return std::string(value != nullptr ? value : "?");
  };
  return text(GL_RENDERER) + ", " + text(GL_VERSION);
}

}  // namespace calot
