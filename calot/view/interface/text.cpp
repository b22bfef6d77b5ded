#include "calot/view/interface/text.h"

#include <algorithm>
#include <array>
#include <set>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/toml_file.h"
#include "calot/view/interface/embedded.h"

namespace calot {
namespace {

constexpr std::uint64_t size_limit = 1 << 20;
constexpr std::string_view controls_name = "controls";

constexpr std::array<std::string_view, text_count> keys{"step.count",
                                                        "hand.left",
                                                        "hand.right",
                                                        "hand.empty",
                                                        "hand.open",
                                                        "hand.closed",
                                                        "hand.half_open",
                                                        "hand.holds_tissue",
                                                        "hand.holds_clip",
                                                        "hand.energy",
                                                        "hand.force",
                                                        "hand.too_much",
                                                        "instrument.bowel_grasper",
                                                        "instrument.curved_forceps",
                                                        "instrument.clip_applier",
                                                        "instrument.scissors",
                                                        "instrument.hook",
                                                        "instrument.suction",
                                                        "instrument.fan_retractor",
                                                        "count.blood",
                                                        "count.bile",
                                                        "count.clips",
                                                        "count.volume",
                                                        "command.pause",
                                                        "command.go_on",
                                                        "command.restart",
                                                        "command.settings",
                                                        "command.help",
                                                        "command.spectator",
                                                        "command.endoscope",
                                                        "command.picture",
                                                        "command.quit",
                                                        "command.close",
                                                        "command.cancel",
                                                        "pause.title",
                                                        "spectator.note",
                                                        "restart.question",
                                                        "restart.recording",
                                                        "settings.title",
                                                        "settings.quality",
                                                        "settings.quality_full",
                                                        "settings.quality_lite",
                                                        "settings.quality_none",
                                                        "settings.volume",
                                                        "settings.percent",
                                                        "settings.colors",
                                                        "settings.colors_usual",
                                                        "settings.colors_contrast",
                                                        "settings.text_size",
                                                        "settings.devices",
                                                        "settings.no_devices",
                                                        "settings.connected",
                                                        "settings.lost",
                                                        "help.title",
                                                        "help.begin",
                                                        "help.again"};

/// The {names} in a text.
std::set<std::string> placeholders(const std::string& text) {
  std::set<std::string> names;
  for (std::size_t at = text.find('{'); at != std::string::npos; at = text.find('{', at + 1)) {
    const std::size_t end = text.find('}', at);
    if (end != std::string::npos) names.insert(text.substr(at, end - at + 1));
  }
  return names;
}

std::string listed(const std::set<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "none" : all;
}

std::pair<std::string, std::string> section_and_name(std::string_view key) {
  const std::size_t dot = key.find('.');
  return {std::string(key.substr(0, dot)), std::string(key.substr(dot + 1))};
}

/// Keys by section, for `allow_only`.
std::map<std::string, std::vector<std::string>> known_keys() {
  std::map<std::string, std::vector<std::string>> known;
  for (const std::string_view key : keys) {
    const auto [section, name] = section_and_name(key);
    known[section].push_back(name);
  }
  return known;
}

}  // namespace

std::string_view key_of(Text text) {
  return keys[static_cast<std::size_t>(text)];
}

Text name_of_instrument(InstrumentKind kind) {
  switch (kind) {
    case InstrumentKind::bowel_grasper:
      return Text::instrument_bowel_grasper;
    case InstrumentKind::curved_forceps:
      return Text::instrument_curved_forceps;
    case InstrumentKind::clip_applier:
      return Text::instrument_clip_applier;
    case InstrumentKind::scissors:
      return Text::instrument_scissors;
    case InstrumentKind::hook:
      return Text::instrument_hook;
    case InstrumentKind::suction:
      return Text::instrument_suction;
    case InstrumentKind::fan_retractor:
      return Text::instrument_fan_retractor;
  }
  return Text::hand_empty;
}

TextTable TextTable::english() {
  std::istringstream in{std::string(detail::embedded_english())};
  const toml::value root = toml::parse(in, "english.toml");
  TextTable table;
  for (const std::string_view key : keys) {
    const auto [section, name] = section_and_name(key);
    table.texts_.push_back(toml::find<std::string>(root, section, name));
  }
  for (const auto& [name, words] : toml::find<toml::table>(root, std::string(controls_name)))
    table.controls_[name] = words.as_string().str;
  for (const auto& [name, words] : table.controls_) table.name_of_english_[words] = name;
  return table;
}

TextTable TextTable::load(const std::filesystem::path& path) {
  const TextTable source = english();
  const detail::TomlFile file(path, size_limit);
  auto known = known_keys();
  for (const auto& [name, words] : source.controls_) known[std::string(controls_name)].push_back(name);
  std::vector<std::string> sections;
  for (const auto& [section, names] : known) sections.push_back(section);
  file.allow_only(file.root(), sections);
  for (const auto& [section, names] : known)
    if (const toml::value* table = file.section(section)) file.allow_only(*table, names);
  const auto read = [&](const std::string& section, const std::string& name, const std::string& english_text) {
    const toml::value* table = file.section(section);
    const toml::value* value = table != nullptr ? detail::TomlFile::find(*table, name) : nullptr;
    if (value == nullptr)
      throw InputError(path.string(), "has no text " + section + "." + name,
                       "add " + name + " = " + detail::toml_text(english_text) + ", translated, to [" + section + "]");
    const std::string& text = file.text(*value, section + "." + name);
    if (placeholders(text) != placeholders(english_text))
      file.fail(*value, section + "." + name + " has the placeholders " + listed(placeholders(text)),
                "use these, each as it is: " + listed(placeholders(english_text)));
    return text;
  };
  TextTable table;
  table.name_of_english_ = source.name_of_english_;
  for (std::size_t k = 0; k < text_count; ++k) {
    const auto [section, name] = section_and_name(keys[k]);
    table.texts_.push_back(read(section, name, source.texts_[k]));
  }
  for (const auto& [name, words] : source.controls_)
    table.controls_[name] = read(std::string(controls_name), name, words);
  return table;
}

std::string TextTable::filled(Text text, std::initializer_list<std::pair<std::string_view, std::string>> values) const {
  std::string out = (*this)[text];
  for (const auto& [name, value] : values) {
    const std::string placeholder = std::string(1, '{').append(name).append(1, '}');
    for (std::size_t at = out.find(placeholder); at != std::string::npos; at = out.find(placeholder, at + value.size()))
      out.replace(at, placeholder.size(), value);
  }
  return out;
}

const std::string& TextTable::control(const std::string& name, const std::string& english) const {
  auto found = controls_.find(name);
  if (found == controls_.end())
    if (const auto known = name_of_english_.find(english); known != name_of_english_.end())
      found = controls_.find(known->second);
  return found == controls_.end() ? english : found->second;
}

std::string TextTable::letters() const {
  std::string all;
  for (const std::string& text : texts_) all += text;
  for (const auto& [name, words] : controls_) all += words;
  return all;
}

}  // namespace calot
