// Inside this room only: values of a scene file, in its length unit, with ranges.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calot/base/toml_file.h"
#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// What all parts of a scene's reader use. Everything throws InputError naming file and line.
class SceneValues {
 public:
  explicit SceneValues(const std::filesystem::path& path);
  [[nodiscard]] const TomlFile& toml() const { return toml_; }
  [[nodiscard]] double metres() const { return metres_; }  ///< per unit of length of the file
  [[nodiscard]] const std::string& unit() const { return unit_; }

  /// Sets `out` where the key is there; low and high in `unit`.
  void number(const toml::value& table, const char* key, double low, double high, const char* unit, double& out) const;
  /// A length; low and high in metres.
  void length(const toml::value& table, const char* key, double low, double high, double& out) const;
  void angle(const toml::value& table, const char* key, double low, double high, double& out) const;  ///< in degrees
  void whole(const toml::value& table, const char* key, std::int64_t low, std::int64_t high, std::int64_t& out) const;
  void yes_or_no(const toml::value& table, const char* key, bool& out) const;
  void text(const toml::value& table, const char* key, std::string& out) const;
  void place(const toml::value& table, const char* key, Vec3& out) const;
  void direction(const toml::value& table, const char* key, Vec3& out) const;  ///< made a unit vector
  void file(const toml::value& table, const char* key, std::filesystem::path& out) const;
  /// One of some words, as its number.
  void word(const toml::value& table, const char* key, const std::vector<std::string>& words, std::size_t& out) const;

  [[nodiscard]] Vec3 place(const toml::value& value, const std::string& name) const;
  [[nodiscard]] double length(const toml::value& value, const std::string& name, double low, double high) const;

 private:
  TomlFile toml_;
  std::string unit_ = "m";
  double metres_ = 1;
};

}  // namespace calot::detail
