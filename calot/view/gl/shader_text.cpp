#include "calot/view/gl/shader_text.h"

#include <algorithm>

#include "calot/base/error.h"

namespace calot::detail {
namespace {

std::string_view text_of(std::string_view name, std::string_view where) {
  for (const ShaderText& shader : shader_texts())
    if (shader.name == name) return shader.text;
  throw FailedError(std::string(where), "there is no shader " + std::string(name), "build Calot again");
}

/// The FILE of a line `#include "FILE"`; empty for other lines.
std::string_view included(std::string_view line) {
  constexpr std::string_view start = "#include \"";
  if (line.substr(0, start.size()) != start) return {};
  line.remove_prefix(start.size());
  return line.substr(0, line.find('"'));
}

void append(AssembledShader& out, std::string_view name, std::string_view where) {
  if (std::find(out.files.begin(), out.files.end(), name) != out.files.end()) return;
  std::string_view rest = text_of(name, where);
  const std::string number = " " + std::to_string(out.files.size()) + "\n";
  out.files.emplace_back(name);
  out.text += "#line 1" + number;
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view text = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (const std::string_view file = included(text); !file.empty()) {
      append(out, file, name);
      out.text += "#line " + std::to_string(line + 1) + number;
    } else {
      out.text.append(text).append("\n");
    }
  }
}

}  // namespace

AssembledShader assemble_shader(std::string_view name, std::span<const std::string> definitions) {
  AssembledShader out;
  out.text = "#version 330 core\n";
  for (const std::string& definition : definitions) out.text += "#define " + definition + "\n";
  append(out, name, "shaders");
  return out;
}

}  // namespace calot::detail
