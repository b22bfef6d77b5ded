#include "calot/patient/import_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <ostream>
#include <vector>

#include "calot/base/error.h"
#include "calot/base/toml_file.h"

namespace calot {
namespace {

using detail::TomlFile;

constexpr std::uint64_t size_limit = std::uint64_t{256} << 10;  // a name a line; finding a line takes a pass over it
constexpr std::string_view ignore = "ignore";

/// One number of the file: where it belongs, in which unit and range.
struct Setting {
  const char* section;
  const char* key;
  double CompletionOptions::*value;
  double unit;       ///< SI per unit of the file
  double low, high;  ///< in the file's unit
  const char* unit_name;
  const char* comment;
};

constexpr double mm = 1e-3, ml = 1e-6;
using Options = CompletionOptions;

constexpr std::array settings{
    Setting{"resample", "spacing", &Options::spacing, mm, 0.3, 1, "mm",
            "edge of the working grid's voxels; made finer where a thin tube needs it"},
    Setting{"resample", "margin", &Options::margin, mm, 5, 100, "mm", "kept around all structures"},
    Setting{"clean", "closing", &Options::closing, mm, 0, 5, "mm", "radius of the closing of ragged outlines; 0: none"},
    Setting{"clean", "ragged_above", &Options::ragged_above, 1, 1, 10, "",
            "ragged: a surface larger than its smoothed self so many times"},
    Setting{"clean", "largest_hole", &Options::largest_hole, ml, 0, 100, "mL", "enclosed holes up to this are filled"},
    Setting{"draw", "overlap", &Options::overlap, mm, 0, 10, "mm",
            "tubes are prolonged into the neighbour they end at by this, and their radius"},
    Setting{"draw", "joint_reach", &Options::joint_reach, mm, 0, 50, "mm",
            "an end nearer than this to its neighbour is joined to it"},
    Setting{"fat", "fat_low", &Options::fat_low, 1, -1024, 3071, "HU", "fat lies between this …"},
    Setting{"fat", "fat_high", &Options::fat_high, 1, -1024, 3071, "HU", "… and this"},
    Setting{"fat", "connective_low", &Options::connective_low, 1, -1024, 3071, "HU",
            "connective tissue lies between this …"},
    Setting{"fat", "connective_high", &Options::connective_high, 1, -1024, 3071, "HU", "… and this"},
    Setting{"fat", "connective_reach", &Options::connective_reach, mm, 0, 20, "mm",
            "and at most so far from a structure"},
    Setting{"fat", "triangle_reach", &Options::triangle_reach, mm, 0, 50, "mm",
            "Calot's triangle reaches so far beyond the surface between its sides"},
    Setting{"fat", "bed_thickness", &Options::bed_thickness, mm, 0, 20, "mm",
            "of the layer between gallbladder and liver"},
    Setting{"fat", "bed_reach", &Options::bed_reach, mm, 0, 50, "mm",
            "a gap between gallbladder and liver up to this is bed"},
};

constexpr std::array<const char*, 6> sections{"names", "numbers", "resample", "clean", "draw", "fat"};

std::vector<std::string> structure_words() {
  std::vector<std::string> words;
  for (const Structure s : all_structures()) words.emplace_back(name_of(s));
  words.emplace_back(ignore);
  return words;
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : toml_(path, size_limit) {}

  ImportOptions read() {
    toml_.allow_only(toml_.root(), {sections.begin(), sections.end()});
    for (const char* name : sections) {
      const toml::value* section = toml_.section(name);
      if (section == nullptr) continue;
      if (name == std::string_view("names"))
        read_names(*section);
      else if (name == std::string_view("numbers"))
        read_numbers(*section);
      else
        read_settings(name, *section);
    }
    check_order();
    return std::move(options_);
  }

 private:
  [[nodiscard]] Structure structure(const toml::value& value, const std::string& key) const {
    const std::string& text = toml_.text(value, "the structure of \"" + detail::brief(key) + "\"");
    const std::string plain = plain_name(text);
    if (plain == ignore) return Structure::none;
    if (const auto found = structure_named(plain)) return *found;
    toml_.fail(value, "there is no structure \"" + detail::brief(text) + "\"",
               detail::suggestion(plain, structure_words()));
  }

  void read_names(const toml::value& section) {
    std::map<std::string, std::string> given;  // plain → as written
    for (const auto& [key, value] : ordered(section)) {
      const std::string plain = plain_name(key);
      if (plain.empty())
        toml_.fail(*value, "the name \"" + detail::brief(key) + "\" has no letter or digit",
                   "write the name of a segment");
      const auto [other, fresh] = given.emplace(plain, key);
      if (!fresh)
        toml_.fail(*value,
                   "\"" + detail::brief(key) + "\" is the same name as \"" + detail::brief(other->second) + "\"",
                   "give it once; case, blanks, hyphens and underscores don't count");
      options_.table.names[plain] = structure(*value, key);
    }
  }

  void read_numbers(const toml::value& section) {
    std::map<Label, std::string> given;
    for (const auto& [key, value] : ordered(section)) {
      Label number = 0;
      const auto [end, code] = std::from_chars(key.data(), key.data() + key.size(), number);
      if (code != std::errc() || end != key.data() + key.size() || number == 0)
        toml_.fail(*value, "\"" + detail::brief(key) + "\" is not a label's number",
                   "use 1 to 65535, e.g. 5 = \"liver\"");
      const auto [other, fresh] = given.emplace(number, key);
      if (!fresh)
        toml_.fail(*value, detail::brief(key) + " is the same number as " + detail::brief(other->second),
                   "give it once");
      options_.table.numbers[number] = structure(*value, key);
    }
  }

  void read_settings(const std::string& name, const toml::value& section) {
    std::vector<std::string> known;
    for (const Setting& setting : settings)
      if (name == setting.section) known.emplace_back(setting.key);
    if (name == "fat") known.emplace_back("fill");
    toml_.allow_only(section, known);
    for (const Setting& setting : settings) {
      if (name != setting.section) continue;
      const toml::value* value = TomlFile::find(section, setting.key);
      if (value == nullptr) continue;
      options_.completion.*setting.value =
          setting.unit * toml_.number_in(*value, setting.key, setting.low, setting.high, setting.unit_name);
    }
    if (const toml::value* fill = name == "fat" ? TomlFile::find(section, "fill") : nullptr) {
      if (!fill->is_boolean()) toml_.fail(*fill, "fill must be true or false", "write fill = true");
      options_.completion.fat = fill->as_boolean();
    }
  }

  /// Thresholds that exchange their places select nothing.
  void check_order() const {
    const toml::value* section = toml_.section("fat");
    if (section == nullptr) return;
    const Options& o = options_.completion;
    if (o.fat_low >= o.fat_high)
      toml_.fail(*section, "fat_low is not below fat_high", "give the lower threshold in fat_low");
    if (o.connective_low >= o.connective_high)
      toml_.fail(*section, "connective_low is not below connective_high", "give the lower threshold in connective_low");
  }

  /// The entries of a section in the file's order, so that the first mistake is the one that is named.
  [[nodiscard]] static std::vector<std::pair<std::string, const toml::value*>> ordered(const toml::value& section) {
    std::vector<std::pair<std::string, const toml::value*>> entries;
    for (const auto& [key, value] : section.as_table()) entries.emplace_back(key, &value);
    std::map<const toml::value*, std::size_t> line;
    for (const auto& [key, value] : entries) line[value] = value->location().line();
    std::sort(entries.begin(), entries.end(), [&](const auto& a, const auto& b) {
      return std::pair(line[a.second], a.first) < std::pair(line[b.second], b.first);
    });
    return entries;
  }

  TomlFile toml_;
  ImportOptions options_;
};

/// A number in the file's unit that reads back as the same double, with as few digits as that takes.
std::string in_unit(double value, double unit) {
  for (const int digits : {6, 9, 12, 15, 17}) {
    std::array<char, 40> text;
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value / unit, std::chars_format::general, digits).ptr;
    double read = 0;
    std::from_chars(text.data(), end, read);
    if (unit * read == value) return detail::toml_real(read);
  }
  return detail::toml_real(value / unit);
}

std::string structure_text(Structure s) {
  return detail::toml_text(std::string(s == Structure::none ? ignore : name_of(s)));
}

void write_names(std::ostream& out, const NameTable& table) {
  out << "# What the segments of a label map are called, and which structure each is. Case, blanks, hyphens and\n"
         "# underscores don't count. Names that aren't here are left out, and listed. \"ignore\" leaves one out "
         "silently.\n"
         "# The structures:\n";
  for (const Structure s : all_structures()) out << "#   " << name_of(s) << '\n';
  out << "[names]\n";
  for (const auto& [name, structure] : table.names)
    out << detail::toml_text(name) << " = " << structure_text(structure) << '\n';
  out << "\n# The same for label maps that have numbers only. There is no default: what a number means differs "
         "between\n"
         "# programs and their versions. For example: 5 = \"liver\"\n[numbers]\n";
  for (const auto& [number, structure] : table.numbers) out << number << " = " << structure_text(structure) << '\n';
}

const std::map<std::string, const char*> section_comments{
    {"resample", "The grid that everything is worked out on."},
    {"clean", "Ragged labels."},
    {"draw", "Ducts and arteries drawn along centrelines."},
    {"fat", "Fat and connective tissue in Calot's triangle and between gallbladder and liver, found in the CT."}};

void write_settings(std::ostream& out, const CompletionOptions& options) {
  std::string section;
  for (const Setting& setting : settings) {
    if (section != setting.section) {
      section = setting.section;
      out << "\n# " << section_comments.at(section) << "\n[" << section << "]\n";
      if (section == "fat")
        out << "fill = " << (options.fat ? "true" : "false") << "  # false: leave them as the labels have them\n";
    }
    out << setting.key << " = " << in_unit(options.*setting.value, setting.unit) << "  # "
        << (*setting.unit_name == '\0' ? "" : std::string(setting.unit_name) + "; ") << setting.comment << " ("
        << detail::short_number(setting.low) << " to " << detail::short_number(setting.high) << ")\n";
  }
}

}  // namespace

ImportOptions read_import_options(const std::filesystem::path& path) {
  return Reader(path).read();
}

void write_import_options(std::ostream& out, const ImportOptions& options) {
  out << "# labels.toml: how Calot reads a segmentation, and what it completes. What is left out keeps its "
         "default.\n\n";
  write_names(out, options.table);
  write_settings(out, options.completion);
}

}  // namespace calot
