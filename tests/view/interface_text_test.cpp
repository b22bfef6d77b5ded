// Every word comes from one file, which can be replaced.
#include <gtest/gtest.h>

#include <algorithm>

#include "calot/device/controls.h"
#include "calot/view/interface/text.h"
#include "tests/support/files.h"

namespace calot {
namespace {

using test::message_of;
using test::read_bytes;
using test::TempFolder;
using test::write_bytes;

const std::filesystem::path english_file = std::filesystem::path(CALOT_SOURCE_FOLDER) / "data/text/english.toml";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// What loading says to the English file with one thing replaced.
std::string complaint(const std::string& from, const std::string& to) {
  const TempFolder folder;
  write_bytes(folder / "other.toml", replaced(read_bytes(english_file), from, to));
  return message_of([&] { TextTable::load(folder / "other.toml"); });
}

TEST(InterfaceText, EnglishIsInTheProgramAsItIsInTheFile) {
  const TextTable inside = TextTable::english(), file = TextTable::load(english_file);
  for (std::size_t k = 0; k < text_count; ++k) {
    EXPECT_FALSE(inside[static_cast<Text>(k)].empty()) << key_of(static_cast<Text>(k));
    EXPECT_EQ(inside[static_cast<Text>(k)], file[static_cast<Text>(k)]);
  }
  EXPECT_EQ(inside.controls(), file.controls());
}

TEST(InterfaceText, ATranslationReplacesAll) {
  const TempFolder folder;
  std::string text = replaced(read_bytes(english_file), "count = \"Step {number} of {count}\"",
                              "count = \"Schritt {number} von {count}\"");
  text = replaced(text, "pedal = \"foot pedal\"", "pedal = \"Fußpedal\"");
  write_bytes(folder / "german.toml", text);
  const TextTable table = TextTable::load(folder / "german.toml");
  EXPECT_EQ(table.filled(Text::step_count, {{"number", "2"}, {"count", "7"}}), "Schritt 2 von 7");
  EXPECT_EQ(table.control("pedal", "foot pedal"), "Fußpedal");
  EXPECT_EQ(table.control("", "foot pedal"), "Fußpedal");
  EXPECT_EQ(table.control("", "something new"), "something new");
  EXPECT_NE(table.letters().find("ß"), std::string::npos);
}

TEST(InterfaceText, SaysWhatIsWrongWithAFile) {
  const std::string missing = complaint("too_much = \"too much force\"\n", "");
  EXPECT_NE(missing.find("has no text hand.too_much"), std::string::npos) << missing;
  EXPECT_NE(missing.find("too much force"), std::string::npos) << missing;
  const std::string unknown = complaint("too_much = ", "to_much = ");
  EXPECT_NE(unknown.find("to_much"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("too_much"), std::string::npos) << unknown;
  const std::string placeholder = complaint("{newton} N", "{newtons} N");
  EXPECT_NE(placeholder.find("{newtons}"), std::string::npos) << placeholder;
  EXPECT_NE(placeholder.find("{newton}"), std::string::npos) << placeholder;
  const std::string number = complaint("blood = \"Blood\"", "blood = 7");
  EXPECT_NE(number.find("count.blood"), std::string::npos) << number;
  const std::string section = complaint("[spectator]", "[spectators]");
  EXPECT_NE(section.find("spectators"), std::string::npos) << section;
  EXPECT_NE(complaint("wheel = ", "wheels = "), "");
  EXPECT_NE(message_of([] { TextTable::load("no-such-file.toml"); }), "");
  for (const std::string& line : {missing, unknown, placeholder, number, section})
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
}

TEST(InterfaceText, EveryTextIsUsed) {
  std::string sources;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(CALOT_SOURCE_FOLDER) / "calot/view/interface"))
    if (entry.path().extension() == ".cpp") sources += read_bytes(entry.path());
  for (std::size_t k = 0; k < text_count; ++k) {
    std::string name(key_of(static_cast<Text>(k)));
    name[name.find('.')] = '_';
    const std::size_t at = sources.find("Text::" + name);
    ASSERT_NE(at, std::string::npos) << name;
    // Whole, not the beginning of a longer one.
    bool whole = false;
    for (std::size_t p = at; p != std::string::npos; p = sources.find("Text::" + name, p + 1)) {
      const char next = sources[p + 6 + name.size()];
      whole = whole || (next != '_' && (next < 'a' || next > 'z'));
    }
    EXPECT_TRUE(whole) << name;
  }
}

TEST(InterfaceText, KnowsWhatEveryKeyDoes) {
  const TextTable table = TextTable::english();
  for (const ActionInfo& action : all_actions()) {
    const std::string name(action.name);
    if (name.substr(0, 11) == "instrument_") continue;  // they share a line
    ASSERT_TRUE(table.controls().contains(name)) << name;
    EXPECT_EQ(table.controls().at(name), action.words);
  }
  for (const BindingRow& row : bindings()) {
    const bool known = std::any_of(table.controls().begin(), table.controls().end(),
                                   [&](const auto& control) { return control.second == row.words; });
    EXPECT_TRUE(known) << row.words;
  }
}

}  // namespace
}  // namespace calot
