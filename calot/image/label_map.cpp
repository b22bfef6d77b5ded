#include "calot/image/label_map.h"

#include <algorithm>
#include <charconv>

#include "calot/base/error.h"

namespace calot {
namespace {

/// "2 (gallbladder), 3 (cystic duct) and 4": the labels that have voxels, at most forty of them.
std::string list_labels(const LabelMap& map, const std::map<Label, std::size_t>& counts) {
  if (counts.empty()) return "no label but background";
  std::string text;
  std::size_t listed = 0;
  for (const auto& [label, count] : counts) {
    if (listed++ == 40) return text + " and " + std::to_string(counts.size() - 40) + " more";
    text += (text.empty() ? "" : ", ") + label_text(map, label);
  }
  return text;
}

}  // namespace

std::map<Label, std::size_t> voxel_counts(const LabelMap& map) {
  std::vector<std::size_t> counts(std::size_t{1} << 16);
  for (const Label label : map.voxels) ++counts[label];
  std::map<Label, std::size_t> present;
  for (std::size_t label = 1; label < counts.size(); ++label)
    if (counts[label] > 0) present[static_cast<Label>(label)] = counts[label];
  return present;
}

std::string label_text(const LabelMap& map, Label label) {
  const auto name = map.names.find(label);
  const std::string number = std::to_string(label);
  return name == map.names.end() ? number : number + " (" + name->second + ")";
}

Label label_matching(const LabelMap& map, const std::string& name, const std::string& where) {
  const std::map<Label, std::size_t> counts = voxel_counts(map);
  std::vector<Label> found;
  for (const auto& [label, text] : map.names)
    if (text == name && counts.contains(label)) found.push_back(label);
  if (found.size() > 1)
    throw InputError(where, "the name \"" + name + "\" belongs to several labels", "give the label's number");
  if (found.size() == 1) return found[0];
  Label number = 0;
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (code == std::errc() && end == name.data() + name.size() && counts.contains(number)) return number;
  throw InputError(where, "has no voxels labelled \"" + name + "\"", "it has " + list_labels(map, counts));
}

}  // namespace calot
