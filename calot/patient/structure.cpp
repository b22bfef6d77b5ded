#include "calot/patient/structure.h"

#include <array>

namespace calot {
namespace {

struct Entry {
  Structure structure;
  std::string_view name;
};

constexpr std::array<Entry, 12> entries{{{Structure::liver, "liver"},
                                         {Structure::gallbladder, "gallbladder"},
                                         {Structure::cystic_duct, "cystic duct"},
                                         {Structure::common_bile_duct, "common bile duct"},
                                         {Structure::common_hepatic_duct, "common hepatic duct"},
                                         {Structure::cystic_artery, "cystic artery"},
                                         {Structure::right_hepatic_artery, "right hepatic artery"},
                                         {Structure::hepatocystic_fat, "hepatocystic fat"},
                                         {Structure::gallbladder_bed, "gallbladder bed"},
                                         {Structure::second_cystic_artery, "second cystic artery"},
                                         {Structure::aberrant_right_duct, "aberrant right hepatic duct"},
                                         {Structure::gallbladder_wall, "gallbladder wall"}}};

constexpr std::array<Structure, entries.size()> structures = [] {
  std::array<Structure, entries.size()> all{};
  for (std::size_t e = 0; e < entries.size(); ++e) all[e] = entries[e].structure;
  return all;
}();

}  // namespace

std::span<const Structure> all_structures() {
  return structures;
}

std::string_view name_of(Structure s) {
  return s == Structure::none ? "none" : entries[label_of(s) - 1u].name;
}

std::optional<Structure> structure_named(std::string_view name) {
  for (const Entry& entry : entries)
    if (entry.name == name) return entry.structure;
  return {};
}

std::map<Label, std::string> structure_names() {
  std::map<Label, std::string> names;
  for (const Entry& entry : entries) names[label_of(entry.structure)] = entry.name;
  return names;
}

bool is_tube(Structure s) {
  switch (s) {
    case Structure::cystic_duct:
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
    case Structure::cystic_artery:
    case Structure::right_hepatic_artery:
    case Structure::second_cystic_artery:
    case Structure::aberrant_right_duct:
      return true;
    default:
      return false;
  }
}

}  // namespace calot
