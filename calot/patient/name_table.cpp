// Which structure a segment's name stands for.
#include <array>
#include <cctype>
#include <string_view>

#include "calot/patient/import_options.h"

namespace calot {
namespace {

struct Synonym {
  Structure structure;
  std::string_view name;
};

// What each word stands for was looked up in: TotalSegmentator's class_map (total v1 and v2, liver_vessels,
// liver_segments), the DICOM and SNOMED terms that 3D Slicer's segment editor offers (CID 7154), the lists of public
// abdominal data sets (BTCV, AMOS, FLARE), and surgeons' abbreviations. Parts of the liver are liver: it moves as one.
constexpr std::array synonyms{
    Synonym{Structure::liver, "liver parenchyma"},
    Synonym{Structure::liver, "liver vessels"},
    Synonym{Structure::liver, "liver tumor"},
    Synonym{Structure::liver, "liver tumour"},
    Synonym{Structure::liver, "liver lesion"},
    Synonym{Structure::liver, "liver lesions"},
    Synonym{Structure::liver, "right lobe of liver"},
    Synonym{Structure::liver, "left lobe of liver"},
    Synonym{Structure::liver, "liver segment 1"},
    Synonym{Structure::liver, "liver segment 2"},
    Synonym{Structure::liver, "liver segment 3"},
    Synonym{Structure::liver, "liver segment 4"},
    Synonym{Structure::liver, "liver segment 5"},
    Synonym{Structure::liver, "liver segment 6"},
    Synonym{Structure::liver, "liver segment 7"},
    Synonym{Structure::liver, "liver segment 8"},
    Synonym{Structure::gallbladder, "gall bladder"},
    Synonym{Structure::gallbladder, "lumen of gallbladder"},
    Synonym{Structure::gallbladder, "gallbladder lumen"},
    Synonym{Structure::gallbladder_wall, "wall of gallbladder"},
    Synonym{Structure::gallbladder_wall, "gall bladder wall"},
    Synonym{Structure::cystic_duct, "duct cystic"},
    Synonym{Structure::cystic_duct, "ductus cysticus"},
    Synonym{Structure::common_bile_duct, "bile duct"},
    Synonym{Structure::common_bile_duct, "bile ducts"},
    Synonym{Structure::common_bile_duct, "choledochal duct"},
    Synonym{Structure::common_bile_duct, "choledochus"},
    Synonym{Structure::common_bile_duct, "ductus choledochus"},
    Synonym{Structure::common_bile_duct, "cbd"},
    Synonym{Structure::common_hepatic_duct, "hepatic duct"},
    Synonym{Structure::common_hepatic_duct, "chd"},
    Synonym{Structure::cystic_artery, "artery cystic"},
    Synonym{Structure::cystic_artery, "arteria cystica"},
    Synonym{Structure::right_hepatic_artery, "hepatic artery right"},
    Synonym{Structure::right_hepatic_artery, "right branch of hepatic artery"},
    Synonym{Structure::right_hepatic_artery, "rha"},
    Synonym{Structure::hepatocystic_fat, "calot s triangle"},
    Synonym{Structure::hepatocystic_fat, "calot triangle"},
    Synonym{Structure::hepatocystic_fat, "calots triangle"},
    Synonym{Structure::hepatocystic_fat, "hepatocystic triangle"},
    Synonym{Structure::hepatocystic_fat, "triangle fat"},
    Synonym{Structure::gallbladder_bed, "cystic plate"},
    Synonym{Structure::gallbladder_bed, "liver bed"},
    Synonym{Structure::gallbladder_bed, "gall bladder bed"},
    Synonym{Structure::gallbladder_bed, "gallbladder fossa"},
    Synonym{Structure::aberrant_right_duct, "aberrant right duct"},
    Synonym{Structure::aberrant_right_duct, "aberrant hepatic duct"},
};

}  // namespace

std::string plain_name(const std::string& name) {
  std::string plain;
  bool gap = false;
  for (const char c : name) {
    // Bytes beyond ASCII are letters: a word in any alphabet stays a word.
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80 && std::isalnum(code) == 0) {
      gap = !plain.empty();
      continue;
    }
    if (gap) plain += ' ';
    gap = false;
    plain += code < 0x80 ? static_cast<char>(std::tolower(code)) : c;
  }
  return plain;
}

NameTable NameTable::built_in() {
  NameTable table;
  for (const Structure s : all_structures()) table.names[std::string(name_of(s))] = s;
  for (const Synonym& synonym : synonyms) table.names[std::string(synonym.name)] = synonym.structure;
  return table;
}

std::optional<Structure> NameTable::find(const std::string& name) const {
  const auto found = names.find(plain_name(name));
  if (found == names.end()) return {};
  return found->second;
}

}  // namespace calot
