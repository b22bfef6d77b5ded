// Inside this room only: shader programs, compiled from the embedded text when they are first needed.
#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "calot/view/gl/objects.h"

namespace calot::detail {

/// Which program: two shader files and what they are compiled with.
struct ProgramKey {
  std::string vertex, fragment;          ///< files in calot/view/shaders
  std::vector<std::string> definitions;  ///< "NAME" or "NAME VALUE"
  friend auto operator<=>(const ProgramKey&, const ProgramKey&) = default;
  [[nodiscard]] std::string text() const;
};

/// A linked program. The uniform block `Frame` is bound to point 0; samplers to the units of `texture_units`.
class Program {
 public:
  /// Throws FailedError with the compiler's words.
  explicit Program(const ProgramKey& key);
  void use() const { glUseProgram(program_.number()); }
  [[nodiscard]] GLuint number() const { return program_.number(); }
  /// Sets a uniform of the program in use; one that the compiler dropped is no error.
  void set(const char* name, float value) const { glUniform1f(place(name), value); }
  void set(const char* name, int value) const { glUniform1i(place(name), value); }
  void set(const char* name, const Eigen::Vector2f& v) const { glUniform2fv(place(name), 1, v.data()); }
  void set(const char* name, const Eigen::Vector3f& v) const { glUniform3fv(place(name), 1, v.data()); }
  void set(const char* name, const Eigen::Vector4f& v) const { glUniform4fv(place(name), 1, v.data()); }
  void set(const char* name, const Eigen::Matrix4f& m) const { glUniformMatrix4fv(place(name), 1, GL_FALSE, m.data()); }

 private:
  [[nodiscard]] GLint place(const char* name) const { return glGetUniformLocation(program_.number(), name); }
  GlProgram program_;
};

/// What each sampler reads, in every shader.
struct TextureUnit {
  const char* name;
  GLint unit;
};
inline constexpr TextureUnit texture_units[] = {
    {"shadow_map", 0},   {"ambient_map", 1},   {"mask_volume", 2},  {"depth_map", 3}, {"color_map", 4},
    {"tissue_noise", 5}, {"tissue_detail", 6}, {"shadow_depth", 7},  // the last two: TissueTextures::first_unit
};
inline constexpr GLint unit_of_shadow = 0, unit_of_ambient = 1, unit_of_mask = 2, unit_of_depth = 3, unit_of_color = 4,
                       unit_of_lamp_depth = 7;

/// Programs by their keys.
class ProgramCache {
 public:
  const Program& get(const ProgramKey& key);
  [[nodiscard]] std::size_t size() const { return programs_.size(); }

 private:
  std::map<ProgramKey, Program> programs_;
};

}  // namespace calot::detail
