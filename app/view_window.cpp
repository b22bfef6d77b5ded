#include "app/view_window.h"

#include <cstdlib>

#include "calot/base/error.h"
#include "calot/view/gl/context.h"

namespace calot {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw FailedError("window", what + ": " + SDL_GetError(),
                    "add --headless, and --png or --video, to see it without one");
}

bool has_display() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0') return true;
  return false;
}

}  // namespace

Window::Window(const std::string& title, int width, int height) {
  if (!has_display())
    throw FailedError("window", "there is no display", "add --headless, and --png or --video, to see it without one");
  SDL_SetMainReady();
  if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0) fail("can't be opened");
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
  SDL_GL_SetAttribute(SDL_GL_DOUBLEBUFFER, 1);
  SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 0);
  window_ = SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, width, height,
                             SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
  if (window_ == nullptr) fail("can't be opened");
  context_ = SDL_GL_CreateContext(window_);
  if (context_ == nullptr) {
    SDL_DestroyWindow(window_);
    fail("there is no OpenGL 3.3");
  }
  SDL_GL_SetSwapInterval(1);
}

Window::~Window() {
  SDL_GL_DeleteContext(context_);
  SDL_DestroyWindow(window_);
  SDL_QuitSubSystem(SDL_INIT_VIDEO);
}

Canvas Window::canvas() const {
  Canvas canvas;
  SDL_GL_GetDrawableSize(window_, &canvas.width, &canvas.height);
  return canvas;
}

int Window::height() const {
  int width = 0, height = 0;
  SDL_GetWindowSize(window_, &width, &height);
  return height;
}

double Window::pixel_ratio() const {
  return static_cast<double>(canvas().height) / std::max(1, height());
}

void Window::show() {
  SDL_GL_SwapWindow(window_);
}

void Window::grab(bool on) {
  if (on == grabbed_) return;
  grabbed_ = on;
  SDL_SetRelativeMouseMode(on ? SDL_TRUE : SDL_FALSE);
}

bool Window::draws_by_processor() const {
  const std::string name = driver_name();
  return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos ||
         name.find("SWR") != std::string::npos;
}

}  // namespace calot
