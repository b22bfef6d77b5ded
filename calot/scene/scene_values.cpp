#include "calot/scene/scene_values.h"

#include <cmath>

#include "calot/mesh/mesh_file.h"

namespace calot::detail {
namespace {

constexpr std::uint64_t size_limit = std::uint64_t{256} << 10;  // finding a line takes a pass over the file
constexpr double farthest = 10;                                 // m

}  // namespace

SceneValues::SceneValues(const std::filesystem::path& path) : toml_(path, size_limit) {
  if (const toml::value* unit = TomlFile::find(toml_.root(), "length_unit"))
    metres_ = metres_per(unit_ = toml_.text(*unit, "length_unit"), toml_.at(*unit));
}

void SceneValues::number(const toml::value& table, const char* key, double low, double high, const char* unit,
                         double& out) const {
  if (const toml::value* value = TomlFile::find(table, key)) out = toml_.number_in(*value, key, low, high, unit);
}

double SceneValues::length(const toml::value& value, const std::string& name, double low, double high) const {
  const double found = metres_ * toml_.number(value, name);
  if (found >= low && found <= high) return found;
  toml_.fail(value, name + " = " + short_number(found / metres_) + " is out of range",
             "give " + short_number(low / metres_) + " to " + short_number(high / metres_) + " " + unit_);
}

void SceneValues::length(const toml::value& table, const char* key, double low, double high, double& out) const {
  if (const toml::value* value = TomlFile::find(table, key)) out = length(*value, key, low, high);
}

void SceneValues::angle(const toml::value& table, const char* key, double low, double high, double& out) const {
  if (const toml::value* value = TomlFile::find(table, key))
    out = M_PI / 180 * toml_.number_in(*value, key, low, high, "degrees");
}

void SceneValues::whole(const toml::value& table, const char* key, std::int64_t low, std::int64_t high,
                        std::int64_t& out) const {
  const toml::value* value = TomlFile::find(table, key);
  if (value == nullptr) return;
  out = toml_.whole(*value, key);
  if (out < low || out > high)
    toml_.fail(*value, std::string(key) + " = " + std::to_string(out) + " is out of range",
               "give " + std::to_string(low) + " to " + std::to_string(high));
}

void SceneValues::yes_or_no(const toml::value& table, const char* key, bool& out) const {
  const toml::value* value = TomlFile::find(table, key);
  if (value == nullptr) return;
  if (!value->is_boolean())
    toml_.fail(*value, std::string(key) + " must be true or false", std::string("write ") + key + " = true");
  out = value->as_boolean();
}

void SceneValues::text(const toml::value& table, const char* key, std::string& out) const {
  const toml::value* value = TomlFile::find(table, key);
  if (value == nullptr) return;
  out = toml_.text(*value, key);
  if (out.empty()) toml_.fail(*value, std::string(key) + " is empty", "write some text, or leave it out");
}

Vec3 SceneValues::place(const toml::value& value, const std::string& name) const {
  const Vec3 point = metres_ * toml_.point(value, name);
  if (point.cwiseAbs().maxCoeff() <= farthest) return point;
  toml_.fail(value, name + " lies more than 10 m away", "give it in " + unit_ + ", or change length_unit");
}

void SceneValues::place(const toml::value& table, const char* key, Vec3& out) const {
  if (const toml::value* value = TomlFile::find(table, key)) out = place(*value, key);
}

void SceneValues::direction(const toml::value& table, const char* key, Vec3& out) const {
  const toml::value* value = TomlFile::find(table, key);
  if (value == nullptr) return;
  const Vec3 vector = toml_.point(*value, key);
  const double size = vector.stableNorm();
  if (!(size > 1e-6 && size < 1e6))
    toml_.fail(*value, std::string(key) + " has no direction", "give e.g. [0.0, 0.0, 1.0]");
  out = vector / size;
}

void SceneValues::file(const toml::value& table, const char* key, std::filesystem::path& out) const {
  std::string name;
  text(table, key, name);
  if (!name.empty()) out = toml_.path().parent_path() / name;
}

void SceneValues::word(const toml::value& table, const char* key, const std::vector<std::string>& words,
                       std::size_t& out) const {
  const toml::value* value = TomlFile::find(table, key);
  if (value == nullptr) return;
  const std::string& found = toml_.text(*value, key);
  for (std::size_t i = 0; i < words.size(); ++i)
    if (words[i] == found) {
      out = i;
      return;
    }
  toml_.fail(*value, std::string(key) + " can't be \"" + brief(found) + "\"", suggestion(found, words));
}

}  // namespace calot::detail
