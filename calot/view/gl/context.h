// An OpenGL 3.3 context without a window or a display.
#pragma once
#include <memory>
#include <string>

#include "calot/view/gl/debug_log.h"

namespace calot {

/// OpenGL 3.3 core by EGL, surfaceless: draws into framebuffer objects only. Current on the thread that made it from
/// then on; one thread at a time. Throws FailedError where there is no such driver.
class OffscreenContext {
 public:
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  void make_current();
  void release();  ///< so that another thread can make it current
  [[nodiscard]] DebugLog& log() { return *log_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  std::unique_ptr<DebugLog> log_;
};

/// The current context's "renderer, version", for reports.
std::string driver_name();

}  // namespace calot
