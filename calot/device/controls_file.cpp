#include <map>

#include "calot/base/error.h"
#include "calot/base/toml_file.h"
#include "calot/device/controls.h"

namespace calot {
namespace {

using detail::brief;
using detail::TomlFile;

constexpr std::uint64_t size_limit = 1 << 20;
constexpr std::size_t keys_an_action = 8;

std::vector<std::string> key_names() {
  std::vector<std::string> names;
  for (int k = 1; k < key_count; ++k) names.emplace_back(name_of(static_cast<Key>(k)));
  return names;
}

Key read_key(const TomlFile& file, const toml::value& value, const std::string& action) {
  std::string name = file.text(value, action);
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (const std::optional<Key> key = key_of(name)) return *key;
  file.fail(value, "there is no key \"" + brief(name) + "\"", detail::suggestion(name, key_names()));
}

std::vector<Key> read_keys(const TomlFile& file, const toml::value& value, const std::string& action) {
  if (value.is_string()) return {read_key(file, value, action)};
  const std::vector<toml::value>& list = file.array(value, action);
  if (list.size() > keys_an_action)
    file.fail(value, action + " has " + std::to_string(list.size()) + " keys", "give 8 at most");
  std::vector<Key> keys;
  for (const toml::value& entry : list) keys.push_back(read_key(file, entry, action));
  return keys;
}

/// What the file binds counts first: a key that it gives to one action is taken from the one that usually has it. Two
/// actions of the file with the same key contradict each other.
void read_bindings(const TomlFile& file, Bindings& bindings) {
  const toml::value* section = file.section("keys");
  if (section == nullptr) return;
  std::vector<std::string> known;
  for (const ActionInfo& info : all_actions()) known.emplace_back(info.name);
  file.allow_only(*section, known);
  std::map<Key, Action> taken;
  std::map<Action, std::vector<Key>> given;
  for (const ActionInfo& info : all_actions()) {
    const std::string name(info.name);
    const toml::value* value = TomlFile::find(*section, name);
    if (value == nullptr) continue;
    given[info.action] = read_keys(file, *value, name);
    for (const Key key : given[info.action]) {
      const auto [first, is_new] = taken.emplace(key, info.action);
      if (is_new) continue;
      std::string twice = "\"";
      twice += name_of(key);
      twice += "\" is bound twice, to ";
      twice += info_of(first->second).name;
      file.fail(*value, twice + " and " + name, "leave it to one of them");
    }
  }
  for (const ActionInfo& info : all_actions()) {
    if (const auto found = given.find(info.action); found != given.end()) {
      bindings.set(info.action, found->second);
      continue;
    }
    std::vector<Key> left;
    for (const Key key : bindings.keys_of(info.action))
      if (!taken.contains(key)) left.push_back(key);
    bindings.set(info.action, left);
  }
}

struct Figure {
  const char* section;
  const char* name;
  double low, high;
  const char* unit;
  double in_si;
  double ControlSettings::*value;
};

constexpr double mm = 1e-3, degree = M_PI / 180;
const Figure figures[] = {
    {"mouse", "speed", 0.1, 10, "", 1, &ControlSettings::pointer_speed},
    {"mouse", "wheel", 0.1, 50, "mm", mm, &ControlSettings::wheel_step},
    {"keyboard", "speed", 1, 500, "mm/s", mm, &ControlSettings::key_speed},
    {"keyboard", "roll", 10, 720, "degrees/s", degree, &ControlSettings::roll_speed},
    {"gamepad", "speed", 1, 500, "mm/s", mm, &ControlSettings::pad_speed},
    {"gamepad", "dead_zone", 0, 0.9, "", 1, &ControlSettings::pad_dead_zone},
};

void read_fulcrum(const TomlFile& file, ControlSettings& settings) {
  const toml::value* section = file.section("gamepad");
  const toml::value* value = section == nullptr ? nullptr : TomlFile::find(*section, "fulcrum");
  if (value == nullptr) return;
  if (!value->is_boolean()) file.fail(*value, "fulcrum must be true or false", "write fulcrum = true");
  settings.pad_fulcrum = value->as_boolean();
}

}  // namespace

ControlSettings read_controls(const std::filesystem::path& path) {
  const TomlFile file(path, size_limit);
  file.allow_only(file.root(), {"keys", "mouse", "keyboard", "gamepad"});
  ControlSettings settings;
  read_bindings(file, settings.bindings);
  std::map<std::string, std::vector<std::string>> known;
  for (const Figure& figure : figures) known[figure.section].emplace_back(figure.name);
  known["gamepad"].emplace_back("fulcrum");
  for (const auto& [name, keys] : known)
    if (const toml::value* section = file.section(name)) file.allow_only(*section, keys);
  for (const Figure& figure : figures) {
    const toml::value* section = file.section(figure.section);
    const toml::value* value = section == nullptr ? nullptr : TomlFile::find(*section, figure.name);
    if (value != nullptr)
      settings.*figure.value = figure.in_si * file.number_in(*value, figure.name, figure.low, figure.high, figure.unit);
  }
  read_fulcrum(file, settings);
  return settings;
}

}  // namespace calot
