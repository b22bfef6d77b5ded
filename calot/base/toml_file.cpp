#include "calot/base/toml_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot::detail {
namespace {

constexpr int nesting_limit = 64;      // the parser recurses into brackets …
constexpr int dotted_key_limit = 100;  // … and along the parts of a key

/// Number of insertions, deletions and replacements that turn a into b [Levenshtein1966].
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

void check_depth(const std::string& bytes, const std::string& file) {
  int depth = 0, dots = 0;
  for (const char c : bytes) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    dots = c == '=' || c == ',' || c == '\n' ? 0 : dots + (c == '.' ? 1 : 0);
    if (depth > nesting_limit || dots > dotted_key_limit)
      throw InputError(file, "is nested too deeply", "check its brackets and quotes");
  }
}

/// The parser draws a picture of the place below its first line, and begins with the name of its own function.
std::string first_line(const std::string& message) {
  std::string line = "not TOML: " + message.substr(0, message.find('\n'));
  for (const std::string noise : {"[error] ", "toml::"})
    if (const auto place = line.find(noise); place != std::string::npos) line.erase(place, noise.size());
  return line;
}

toml::value parse(const std::filesystem::path& path, std::uint64_t size_limit) {
  const std::string bytes = read_file(path, size_limit);
  check_depth(bytes, path.string());
  std::istringstream in(bytes);
  try {
    return toml::parse(in, path.string());
  } catch (const toml::exception& wrong) {
    throw InputError(at_line(path.string(), wrong.location().line()), first_line(wrong.what()), "see toml.io");
  } catch (const std::exception& wrong) {
    throw InputError(path.string(), first_line(wrong.what()), "see toml.io");
  }
}

}  // namespace

TomlFile::TomlFile(std::filesystem::path path, std::uint64_t size_limit)
    : path_(std::move(path)), root_(parse(path_, size_limit)) {}

std::string TomlFile::at(const toml::value& value) const {
  return at_line(path_.string(), value.location().line());
}

void TomlFile::fail(const toml::value& value, const std::string& what, const std::string& what_to_do) const {
  throw InputError(at(value), what, what_to_do);
}

void TomlFile::allow_only(const toml::value& table, const std::vector<std::string>& known) const {
  // Finding a line takes a pass over the file: a few of the unknown keys will do.
  constexpr std::size_t looked_up = 8;
  std::set<std::string> unknown;
  for (const auto& [key, value] : table.as_table())
    if (std::find(known.begin(), known.end(), key) == known.end()) unknown.insert(key);
  if (unknown.empty()) return;
  while (unknown.size() > looked_up) unknown.erase(std::prev(unknown.end()));
  const auto line = [&](const std::string& key) { return find(table, key)->location().line(); };
  const std::string first = *std::min_element(unknown.begin(), unknown.end(),
                                              [&](const auto& a, const auto& b) { return line(a) < line(b); });
  fail(*find(table, first), "unknown key \"" + brief(first) + "\"", suggestion(first, known));
}

const toml::value* TomlFile::find(const toml::value& table, const std::string& key) {
  const auto& entries = table.as_table();
  const auto found = entries.find(key);
  return found == entries.end() ? nullptr : &found->second;
}

const toml::value& TomlFile::need(const toml::value& table, const std::string& key, const std::string& example) const {
  if (const toml::value* value = find(table, key)) return *value;
  fail(table, "\"" + key + "\" is missing", "add e.g. " + key + " = " + example);
}

const toml::value* TomlFile::section(const std::string& name) const {
  const toml::value* value = find(root_, name);
  if (value != nullptr && !value->is_table()) fail(*value, name + " must be a section", "write [" + name + "]");
  return value;
}

std::span<const toml::value> TomlFile::tables(const std::string& name) const {
  const toml::value* value = find(root_, name);
  if (value == nullptr) return {};
  const bool fits = value->is_array() && std::all_of(value->as_array().begin(), value->as_array().end(),
                                                     [](const toml::value& entry) { return entry.is_table(); });
  if (!fits) fail(*value, name + " must be a list of tables", "write [[" + name + "]]");
  return value->as_array();
}

double TomlFile::number(const toml::value& value, const std::string& name) const {
  double number = 0;
  if (value.is_integer())
    number = static_cast<double>(value.as_integer());
  else if (value.is_floating())
    number = value.as_floating();
  else
    fail(value, name + " must be a number", "write e.g. 1.5");
  if (!std::isfinite(number)) fail(value, name + " is not a finite number", "give a finite number");
  return number;
}

double TomlFile::number_in(const toml::value& value, const std::string& name, double low, double high,
                           const std::string& unit) const {
  const double found = number(value, name);
  if (found >= low && found <= high) return found;
  fail(value, name + " = " + short_number(found) + " is out of range",
       "give " + short_number(low) + " to " + short_number(high) + (unit.empty() ? "" : " " + unit));
}

std::int64_t TomlFile::whole(const toml::value& value, const std::string& name) const {
  if (!value.is_integer()) fail(value, name + " must be a whole number", "write e.g. 4");
  return value.as_integer();
}

const std::string& TomlFile::text(const toml::value& value, const std::string& name) const {
  if (!value.is_string()) fail(value, name + " must be text", "write it in quotes");
  return value.as_string().str;
}

const std::vector<toml::value>& TomlFile::array(const toml::value& value, const std::string& name) const {
  if (!value.is_array()) fail(value, name + " must be a list", "write it in [ ]");
  return value.as_array();
}

Eigen::Vector3d TomlFile::point(const toml::value& value, const std::string& name) const {
  const std::vector<toml::value>& list = array(value, name);
  if (list.size() != 3) fail(value, name + " needs three numbers", "write [x, y, z]");
  Eigen::Vector3d point;
  for (std::size_t axis = 0; axis < 3; ++axis) point[static_cast<int>(axis)] = number(list[axis], name);
  return point;
}

std::string suggestion(const std::string& wrong_word, const std::vector<std::string>& known) {
  const std::string wrong = wrong_word.substr(0, 80);
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(wrong, a) < edit_distance(wrong, b);
  });
  if (nearest != known.end() && edit_distance(wrong, *nearest) <= 1 + wrong.size() / 3)
    return "did you mean " + *nearest + "?";
  std::string list;
  for (const std::string& word : known) list += (list.empty() ? "" : ", ") + word;
  return "there are: " + list;
}

std::string brief(const std::string& text) {
  constexpr std::size_t longest = 60;
  std::string out = text.substr(0, longest);
  if (text.size() > longest) out += "…";
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return out;
}

std::string toml_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (code < 0x20 || code == 0x7f)
      out += {'\\', 'u', '0', '0', "0123456789abcdef"[code >> 4], "0123456789abcdef"[code & 15]};
    else
      out += c;
  }
  return out + '"';
}

std::string toml_real(double value) {
  std::array<char, 40> text;
  std::string out(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  if (out.find_first_of(".en") == std::string::npos) out += ".0";
  return out;
}

std::string short_number(double value) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string toml_mm(double metres) {
  std::array<char, 400> text;
  const double mm = metres * 1e3;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), mm, std::chars_format::fixed, 6).ptr;
  std::string out(text.data(), end);
  while (out.back() == '0' && out[out.size() - 2] != '.') out.pop_back();
  return out == "-0.0" ? "0.0" : out;
}

std::string toml_mm(const Eigen::Vector3d& metres) {
  std::string out = "[";
  for (int axis = 0; axis < 3; ++axis) out += (axis == 0 ? "" : ", ") + toml_mm(metres[axis]);
  return out + "]";
}

}  // namespace calot::detail
