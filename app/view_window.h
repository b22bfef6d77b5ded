// A window with OpenGL, and what came from its mouse and keys.
#pragma once
#include <SDL2/SDL.h>

#include <memory>
#include <string>

#include "calot/view/renderer.h"

namespace calot {

/// Opens a window of about this size; its OpenGL 3.3 context is current on this thread until it closes. Throws
/// FailedError without a display or such a driver.
class Window {
 public:
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  [[nodiscard]] Canvas canvas() const;       ///< in pixels
  [[nodiscard]] int height() const;          ///< in the units of mouse events
  [[nodiscard]] double pixel_ratio() const;  ///< pixels per such unit
  void show();                               ///< what was drawn
  /// The mouse drives an instrument: it is hidden, and gives motions only.
  void grab(bool on);
  [[nodiscard]] bool grabbed() const { return grabbed_; }
  [[nodiscard]] bool draws_by_processor() const;

 private:
  SDL_Window* window_ = nullptr;
  SDL_GLContext context_ = nullptr;
  bool grabbed_ = false;
};

}  // namespace calot
