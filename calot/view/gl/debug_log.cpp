#include "calot/view/gl/debug_log.h"

#include <epoxy/gl.h>

namespace calot {
namespace {

constexpr std::size_t most_kept = 100;

void GLAPIENTRY on_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* text,
                           const void* log) {
  const bool counts =
      type == GL_DEBUG_TYPE_ERROR || severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM;
  if (!counts) return;
  static_cast<DebugLog*>(const_cast<void*>(log))->add(std::string(text, static_cast<std::size_t>(length)));
}

}  // namespace

DebugLog::DebugLog() {
  listens_ = epoxy_gl_version() >= 43 || epoxy_has_gl_extension("GL_KHR_debug");
  if (!listens_) return;
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(on_message, this);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
}

DebugLog::~DebugLog() {
  if (listens_) glDebugMessageCallback(nullptr, nullptr);
}

void DebugLog::add(std::string message) {
  if (messages_.size() < most_kept) messages_.push_back(std::move(message));
}

}  // namespace calot
