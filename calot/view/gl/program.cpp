#include "calot/view/gl/program.h"

#include "calot/base/error.h"
#include "calot/view/gl/shader_text.h"

namespace calot::detail {
namespace {

std::string log_of_shader(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) glGetShaderInfoLog(shader, length, nullptr, log.data());
  return log.c_str();
}

void attach(GLuint program, GLenum stage, const std::string& name, const ProgramKey& key) {
  const AssembledShader source = assemble_shader(name, key.definitions);
  const GLuint shader = glCreateShader(stage);
  const char* text = source.text.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  const std::string log = good == 0 ? log_of_shader(shader) : std::string();
  glAttachShader(program, shader);
  glDeleteShader(shader);  // it goes with the program
  if (good != 0) return;
  std::string files;
  for (std::size_t k = 0; k < source.files.size(); ++k)
    files += (k > 0 ? ", " : "") + std::to_string(k) + " " + source.files[k];
  throw FailedError("shader " + key.text(), "doesn't compile (" + files + "): " + log, "update the graphics driver");
}

}  // namespace

std::string ProgramKey::text() const {
  std::string all = vertex + " + " + fragment;
  for (const std::string& definition : definitions) all += ", " + definition;
  return all;
}

Program::Program(const ProgramKey& key) : program_(GlProgram::make()) {
  attach(program_.number(), GL_VERTEX_SHADER, key.vertex, key);
  attach(program_.number(), GL_FRAGMENT_SHADER, key.fragment, key);
  glLinkProgram(program_.number());
  GLint good = 0, length = 0;
  glGetProgramiv(program_.number(), GL_LINK_STATUS, &good);
  if (good == 0) {
    glGetProgramiv(program_.number(), GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length) + 1, '\0');
    glGetProgramInfoLog(program_.number(), length, nullptr, log.data());
    throw FailedError("shader " + key.text(), std::string("doesn't link: ") + log.c_str(),
                      "update the graphics driver");
  }
  const GLuint frame = glGetUniformBlockIndex(program_.number(), "Frame");
  if (frame != GL_INVALID_INDEX) glUniformBlockBinding(program_.number(), frame, 0);
  use();
  for (const TextureUnit& unit : texture_units) {
    const GLint at = glGetUniformLocation(program_.number(), unit.name);
    if (at >= 0) glUniform1i(at, unit.unit);
  }
}

const Program& ProgramCache::get(const ProgramKey& key) {
  const auto found = programs_.find(key);
  if (found != programs_.end()) return found->second;
  return programs_.emplace(key, Program(key)).first->second;
}

}  // namespace calot::detail
