// labels.toml: what the names and numbers of a segmentation mean, and the thresholds of everything done to it.
#pragma once
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>

#include "calot/patient/completion.h"
#include "calot/patient/structure.h"

namespace calot {

/// What segments are, by name or number. A name that means "ignore" maps to Structure::none.
struct NameTable {
  std::map<std::string, Structure> names;  ///< keys as `plain_name` writes them
  std::map<Label, Structure> numbers;      ///< for maps without names only

  /// Calot's own names, TotalSegmentator's, 3D Slicer's common ones, and usual synonyms. No numbers: what a number
  /// means differs between tools and versions.
  static NameTable built_in();
  /// The structure of a name, whatever its case, spaces, underscores or hyphens; empty when the table doesn't have it.
  [[nodiscard]] std::optional<Structure> find(const std::string& name) const;
};

/// Lower case, one space for every run of anything but letters and digits.
std::string plain_name(const std::string& name);

/// Everything labels.toml can say.
struct ImportOptions {
  NameTable table = NameTable::built_in();
  CompletionOptions completion;
};

/// Reads labels.toml over the defaults: sections [names], [numbers], [resample], [clean], [fat], [draw]; keys and units
/// are those that `write_import_options` writes. Throws InputError naming file and line: unknown sections, keys and
/// structures (listing those there are), values out of range, a name given twice.
ImportOptions read_import_options(const std::filesystem::path& path);

/// Writes a labels.toml that says everything, with comments; reads back equal.
void write_import_options(std::ostream& out, const ImportOptions& options);

}  // namespace calot
