// Inside this room only: the shaders' text, with its includes and definitions put in.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace calot::detail {

struct ShaderText {
  std::string_view name;  ///< of the file in calot/view/shaders
  std::string_view text;
};

/// All of them, as they are in the program.
std::span<const ShaderText> shader_texts();

/// The text of one shader for the compiler: version line, `definitions` ("NAME" or "NAME VALUE") as #define lines, then
/// the file with every `#include "FILE"` replaced by that file, once each. #line numbers count lines of string k, the
/// k-th file in the order of `files`, so that compilers' messages can be traced. Throws FailedError for a name that
/// doesn't exist.
struct AssembledShader {
  std::string text;
  std::vector<std::string> files;
};
AssembledShader assemble_shader(std::string_view name, std::span<const std::string> definitions);

}  // namespace calot::detail
