// Every word that the interface writes: from data/text/english.toml, or a translation of it.
#pragma once
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calot/sim/instrument.h"
#include "calot/view/interface/text_keys.h"

namespace calot {

std::string_view key_of(Text text);
Text name_of_instrument(InstrumentKind kind);

/// The texts of one language.
class TextTable {
 public:
  /// English, as it is in the program.
  static TextTable english();
  /// A translation. Throws InputError naming file and line: for a key that is missing or unknown, for text that isn't
  /// text, and for one that has other {placeholders} than English has.
  static TextTable load(const std::filesystem::path& file);

  [[nodiscard]] const std::string& operator[](Text text) const { return texts_[static_cast<std::size_t>(text)]; }
  /// With {placeholders} filled.
  [[nodiscard]] std::string filled(Text text,
                                   std::initializer_list<std::pair<std::string_view, std::string>> values) const;
  /// What a key does, in this language: by its name in [controls], or by the English words there; `english` itself
  /// where the table has neither.
  [[nodiscard]] const std::string& control(const std::string& name, const std::string& english) const;
  [[nodiscard]] const std::map<std::string, std::string>& controls() const { return controls_; }
  /// All of it in one string, so that a font can be made with every letter it needs.
  [[nodiscard]] std::string letters() const;

 private:
  std::vector<std::string> texts_;
  std::map<std::string, std::string> controls_;
  std::map<std::string, std::string> name_of_english_;  // of controls, by their words
};

}  // namespace calot
