// Inside the library only: TOML files whose every complaint names file and line, and text that reads back.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <toml.hpp>
#include <vector>

namespace calot::detail {

/// A parsed file. Integers are accepted for reals. Everything throws InputError.
class TomlFile {
 public:
  /// Any bytes are safe: files above `size_limit` bytes and deep nesting are refused before the parser, which recurses.
  TomlFile(std::filesystem::path path, std::uint64_t size_limit);

  [[nodiscard]] const toml::value& root() const { return root_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// "FILE:LINE" of a value.
  [[nodiscard]] std::string at(const toml::value& value) const;
  [[noreturn]] void fail(const toml::value& value, const std::string& what, const std::string& what_to_do) const;

  /// Refuses keys that nobody reads; the first in the file is named, with the nearest known one.
  void allow_only(const toml::value& table, const std::vector<std::string>& known) const;
  /// The value of a key, or nullptr.
  static const toml::value* find(const toml::value& table, const std::string& key);
  [[nodiscard]] const toml::value& need(const toml::value& table, const std::string& key,
                                        const std::string& example) const;
  /// A table of the root ([name]); nullptr where there is none.
  [[nodiscard]] const toml::value* section(const std::string& name) const;
  /// The tables of [[name]]; none if there is no such key.
  [[nodiscard]] std::span<const toml::value> tables(const std::string& name) const;

  [[nodiscard]] double number(const toml::value& value, const std::string& name) const;
  /// A number in low … high, both in `unit`.
  [[nodiscard]] double number_in(const toml::value& value, const std::string& name, double low, double high,
                                 const std::string& unit) const;
  [[nodiscard]] std::int64_t whole(const toml::value& value, const std::string& name) const;
  [[nodiscard]] const std::string& text(const toml::value& value, const std::string& name) const;
  [[nodiscard]] const std::vector<toml::value>& array(const toml::value& value, const std::string& name) const;
  /// Three numbers.
  [[nodiscard]] Eigen::Vector3d point(const toml::value& value, const std::string& name) const;

 private:
  std::filesystem::path path_;
  toml::value root_;
};

/// The one of `known` that is nearest to a misspelled word ("did you mean …?"), or the list of all.
std::string suggestion(const std::string& wrong, const std::vector<std::string>& known);

/// Text of a file for a message: its beginning, without control characters.
std::string brief(const std::string& text);

/// In quotes, escaped as TOML wants it.
std::string toml_text(const std::string& text);
/// The shortest text that reads back as the same double and is a TOML float.
std::string toml_real(double value);
/// A number for people, such as "12.5".
std::string short_number(double value);
/// A length as millimetres, to the nanometre: "12.5", "-0.000017".
std::string toml_mm(double metres);
/// "[1.0, 2.5, -3.0]", in millimetres.
std::string toml_mm(const Eigen::Vector3d& metres);

}  // namespace calot::detail
