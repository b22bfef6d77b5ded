#include "calot/patient/import_options.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace {

using namespace calot;
using namespace calot::test;

ImportOptions read_text(const std::string& text) {
  TempFolder folder;
  write_bytes(folder / "labels.toml", text);
  return read_import_options(folder / "labels.toml");
}

std::string written(const ImportOptions& options) {
  std::ostringstream out;
  write_import_options(out, options);
  return out.str();
}

void expect_same(const CompletionOptions& a, const CompletionOptions& b) {
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.margin, b.margin);
  EXPECT_EQ(a.closing, b.closing);
  EXPECT_EQ(a.ragged_above, b.ragged_above);
  EXPECT_EQ(a.largest_hole, b.largest_hole);
  EXPECT_EQ(a.overlap, b.overlap);
  EXPECT_EQ(a.joint_reach, b.joint_reach);
  EXPECT_EQ(a.fat, b.fat);
  EXPECT_EQ(a.fat_low, b.fat_low);
  EXPECT_EQ(a.fat_high, b.fat_high);
  EXPECT_EQ(a.connective_low, b.connective_low);
  EXPECT_EQ(a.connective_high, b.connective_high);
  EXPECT_EQ(a.connective_reach, b.connective_reach);
  EXPECT_EQ(a.triangle_reach, b.triangle_reach);
  EXPECT_EQ(a.bed_thickness, b.bed_thickness);
  EXPECT_EQ(a.bed_reach, b.bed_reach);
}

TEST(NameTable, FindsNamesWhateverTheirSpelling) {
  const NameTable table = NameTable::built_in();
  for (const Structure s : all_structures()) EXPECT_EQ(table.find(std::string(name_of(s))), s);
  EXPECT_EQ(table.find("common_bile_duct"), Structure::common_bile_duct);
  EXPECT_EQ(table.find("Common-Bile  Duct"), Structure::common_bile_duct);
  EXPECT_EQ(table.find(" LIVER_"), Structure::liver);
  EXPECT_EQ(table.find("Gall Bladder"), Structure::gallbladder);
  EXPECT_EQ(table.find("Calot's triangle"), Structure::hepatocystic_fat);
  EXPECT_EQ(table.find("liver_segment_4"), Structure::liver);
  EXPECT_EQ(table.find("liver_vessels"), Structure::liver);
  for (const char* other : {"spleen", "kidney_left", "urinary_bladder", "portal_vein_and_splenic_vein", "", "___"})
    EXPECT_FALSE(table.find(other)) << other;
  EXPECT_TRUE(table.numbers.empty());
}

TEST(NameTable, PlainNamesKeepWordsOfAnyAlphabet) {
  EXPECT_EQ(plain_name("  Cystic__Duct-2 "), "cystic duct 2");
  EXPECT_EQ(plain_name("Galle (Blase)"), "galle blase");
  EXPECT_EQ(plain_name("胆囊"), "胆囊");
  EXPECT_EQ(plain_name("!?"), "");
}

TEST(ImportOptions, DefaultsReadBackEqual) {
  const ImportOptions defaults, again = read_text(written(defaults));
  expect_same(defaults.completion, again.completion);
  EXPECT_EQ(defaults.table.names, again.table.names);
  EXPECT_EQ(defaults.table.numbers, again.table.numbers);
  EXPECT_EQ(written(again), written(defaults));
  expect_same(read_text("").completion, defaults.completion);
}

TEST(ImportOptions, WhatWasReadReadsBackEqual) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    std::ostringstream text;
    text << "[resample]\nspacing = " << random.between(0.3, 1) << "\nmargin = " << random.between(5, 100)
         << "\n[clean]\nclosing = " << random.between(0, 5) << "\nlargest_hole = " << random.between(0, 100)
         << "\n[fat]\nfill = false\nbed_reach = " << random.between(0, 50) << "\n[names]\n\"seg " << round
         << "\" = \"cystic duct\"\nliver = \"ignore\"\n[numbers]\n"
         << 1 + random.below(65535) << " = \"common bile duct\"\n65535 = \"ignore\"\n";
    const ImportOptions options = read_text(text.str()), again = read_text(written(options));
    expect_same(options.completion, again.completion);
    EXPECT_FALSE(again.completion.fat);
    EXPECT_EQ(options.table.names, again.table.names);
    EXPECT_EQ(options.table.numbers, again.table.numbers);
    EXPECT_EQ(again.table.find("LIVER"), Structure::none);
    EXPECT_EQ(again.table.find("Seg_" + std::to_string(round)), Structure::cystic_duct);
  }
}

TEST(ImportOptions, UnitsAreThoseOfTheFile) {
  const ImportOptions options =
      read_text("[resample]\nspacing = 0.5\n[clean]\nlargest_hole = 3\n[fat]\nfat_low = -120\n");
  EXPECT_DOUBLE_EQ(options.completion.spacing, 0.5e-3);
  EXPECT_DOUBLE_EQ(options.completion.largest_hole, 3e-6);
  EXPECT_EQ(options.completion.fat_low, -120);
  EXPECT_EQ(options.completion.fat_high, CompletionOptions().fat_high);
}

TEST(ImportOptions, TheManualsExampleReadsAndShowsTheDefaults) {
  const std::string page = read_bytes(std::string(CALOT_SOURCE_DIR) + "/docs/formats.md");
  const std::string fence = "```toml\n";
  const std::size_t start = page.find(fence, page.find("# labels.toml")) + fence.size();
  const ImportOptions options = read_text(page.substr(start, page.find("```", start) - start));
  expect_same(options.completion, CompletionOptions());
  EXPECT_EQ(options.table.find("gallenblase"), Structure::gallbladder);
  EXPECT_EQ(options.table.find("spleen"), Structure::none);
  EXPECT_EQ(options.table.numbers.at(5), Structure::liver);
}

struct Mistake {
  std::string text;
  int line;
  std::string message;
};

TEST(ImportOptions, NamesFileLineAndCureOfEveryMistake) {
  const std::vector<Mistake> mistakes{
      {"[name]\n", 1, "unknown key \"name\"; did you mean names?"},
      {"names = 3\n", 1, "names must be a section; write [names]"},
      {"[names]\na = 'liver'\nb = 'lver'\n", 3, "there is no structure \"lver\"; did you mean liver?"},
      {"[names]\na = 'spleen'\n", 2, "there are: liver, gallbladder, cystic duct"},
      {"[names]\na = 5\n", 2, "the structure of \"a\" must be text"},
      {"[names]\n\"Gall_Bladder\" = 'liver'\n\n'gall bladder' = 'liver'\n", 4,
       "\"gall bladder\" is the same name as \"Gall_Bladder\""},
      {"[names]\n'--' = 'liver'\n", 2, "has no letter or digit"},
      {"[numbers]\n5 = 'liver'\n0 = 'liver'\n", 3, "\"0\" is not a label's number"},
      {"[numbers]\n65536 = 'liver'\n", 2, "\"65536\" is not a label's number"},
      {"[numbers]\n5 = 'liver'\n05 = 'liver'\n", 3, "05 is the same number as 5"},
      {"[numbers]\nfive = 'liver'\n", 2, "\"five\" is not a label's number"},
      {"[resample]\nspacing = 0.0007\n", 2, "spacing = 0.0007 is out of range; give 0.3 to 1 mm"},
      {"[resample]\nspacing = inf\n", 2, "spacing is not a finite number"},
      {"[resample]\nspacing = 'fine'\n", 2, "spacing must be a number"},
      {"[clean]\nclosing = 0.5\nclosin = 0.5\n", 3, "unknown key \"closin\"; did you mean closing?"},
      {"[clean]\nclosing = -1\n", 2, "closing = -1 is out of range; give 0 to 5 mm"},
      {"[fat]\nfill = 1\n", 2, "fill must be true or false"},
      {"[fat]\nfat_low = -20\nfat_high = -150\n", 1, "fat_low is not below fat_high"},
      {"[fat]\nconnective_low = 90\n", 1, "connective_low is not below connective_high"},
      {"[names]\na = 'liver'\na = 'liver'\n", 0, "not TOML"},
      {"[names\n", 0, "not TOML"}};
  for (const Mistake& mistake : mistakes) {
    const std::string message = message_of([&] { read_text(mistake.text); });
    EXPECT_NE(message.find(mistake.message), std::string::npos) << mistake.text << "\ngave: " << message;
    const std::string where = mistake.line == 0 ? "labels.toml:" : "labels.toml:" + std::to_string(mistake.line) + ": ";
    EXPECT_NE(message.find(where), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_NE(message_of([] { read_import_options("/nowhere/labels.toml"); }).find("labels.toml"), std::string::npos);
}

}  // namespace
