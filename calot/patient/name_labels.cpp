#include "calot/patient/name_labels.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "calot/base/error.h"

namespace calot {
namespace {

std::string text(const char* format, auto... values) {
  std::array<char, 400> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

std::string title_of(const Segment& segment) {
  return segment.name.empty() ? std::to_string(segment.value) : segment.name;
}

double millilitres(std::size_t voxels, const VoxelGrid& grid) {
  return static_cast<double>(voxels) * grid.voxel_volume() * 1e6;
}

/// At most so many texts, joined by "; ".
std::string listed(const std::vector<std::string>& texts, std::size_t most) {
  std::string line;
  for (std::size_t t = 0; t < texts.size() && t < most; ++t) line += (t == 0 ? "" : "; ") + texts[t];
  if (texts.size() > most) line += " and " + std::to_string(texts.size() - most) + " more";
  return line;
}

/// The structure of every segment; none for those left out.
std::vector<Structure> name_segments(const Segmentation& segmentation, const NameTable& table,
                                     const std::string& where) {
  std::vector<Structure> structures;
  bool any_number = false, any_known = false;
  for (const Segment& segment : segmentation.segments) {
    std::optional<Structure> found;
    if (!segment.name.empty()) {
      found = table.find(segment.name);
    } else {
      any_number = true;
      if (const auto entry = table.numbers.find(segment.value); entry != table.numbers.end()) found = entry->second;
      any_known = any_known || found.has_value();
    }
    structures.push_back(found.value_or(Structure::none));
  }
  if (any_number && !any_known)
    throw InputError(where, "has numbers without names: " + listed(describe_segments(segmentation), 30),
                     "say in labels.toml what they are, e.g. [numbers] 5 = \"liver\", and give it with --table");
  return structures;
}

/// The structure of a segment that files list without a voxel of it, by its name or number.
std::optional<Structure> structure_of_empty(const std::string& title, const NameTable& table) {
  if (const auto found = table.find(title)) return found;
  for (const auto& [number, structure] : table.numbers)
    if (title == std::to_string(number)) return structure;
  return {};
}

void require(Structure needed, const std::vector<Structure>& structures, const Segmentation& segmentation,
             const NameTable& table, const std::string& where) {
  if (std::find(structures.begin(), structures.end(), needed) != structures.end()) return;
  const std::string name(name_of(needed));
  std::vector<std::string> names = segmentation.unread;
  for (const Segment& segment : segmentation.segments) names.push_back(title_of(segment));
  if (std::find_if(segmentation.empty.begin(), segmentation.empty.end(), [&](const std::string& empty) {
        return structure_of_empty(empty, table) == needed;
      }) != segmentation.empty.end())
    throw InputError(where, "its " + name + " is empty: it has no voxel", "segment the " + name);
  throw InputError(where, "has no " + name + " among: " + (names.empty() ? "nothing" : listed(names, 40)),
                   "say in labels.toml which one it is, e.g. [names] \"my segment\" = \"" + name + "\"");
}

/// Voxels that two structures claim, and the first of them.
struct Overlap {
  std::size_t voxels = 0, first = 0;
};

class Painter {
 public:
  Painter(const Segmentation& segmentation, std::vector<Structure> structures)
      : segmentation_(segmentation), structures_(std::move(structures)) {
    voxels_of_.fill(0);
    for (std::size_t s = 0; s < structures_.size(); ++s)
      voxels_of_[label_of(structures_[s])] += segmentation_.segments[s].voxels;
  }

  std::vector<Label> paint() {
    std::vector<Label> labels(segmentation_.grid.count(), 0);
    for (std::size_t layer = 0; layer < segmentation_.layers.size(); ++layer) paint_layer(layer, labels);
    return labels;
  }
  [[nodiscard]] const std::map<std::pair<Label, Label>, Overlap>& overlaps() const { return overlaps_; }

 private:
  void paint_layer(std::size_t layer, std::vector<Label>& labels) {
    std::vector<Label> meaning(std::size_t{1} << 16, 0);
    for (std::size_t s = 0; s < structures_.size(); ++s)
      if (segmentation_.segments[s].layer == layer) meaning[segmentation_.segments[s].value] = label_of(structures_[s]);
    const std::vector<Label>& voxels = segmentation_.layers[layer];
    for (std::size_t v = 0; v < voxels.size(); ++v) {
      const Label here = meaning[voxels[v]];
      if (here == 0 || here == labels[v]) continue;
      if (labels[v] != 0) {
        Overlap& overlap = overlaps_[std::minmax(here, labels[v])];
        if (overlap.voxels++ == 0) overlap.first = v;
        if (voxels_of_[here] >= voxels_of_[labels[v]]) continue;
      }
      labels[v] = here;
    }
  }

  const Segmentation& segmentation_;
  std::vector<Structure> structures_;
  std::array<std::size_t, 64> voxels_of_{};
  std::map<std::pair<Label, Label>, Overlap> overlaps_;
};

void judge_overlaps(const Painter& painter, const VoxelGrid& grid, OverlapRule rule, const std::string& where,
                    std::vector<std::string>& warnings) {
  for (const auto& [pair, overlap] : painter.overlaps()) {
    const auto v = overlap.first;
    const Eigen::Vector3d at =
        1e3 * (grid.to_world * Eigen::Vector3d(static_cast<double>(v % grid.size[0]),
                                               static_cast<double>(v / grid.size[0] % grid.size[1]),
                                               static_cast<double>(v / (grid.size[0] * grid.size[1]))));
    const std::string what =
        text("%s and %s overlap in %zu voxels (%.3g mL), first at (%.1f, %.1f, %.1f) mm",
             name_of(static_cast<Structure>(pair.first)).data(), name_of(static_cast<Structure>(pair.second)).data(),
             overlap.voxels, millilitres(overlap.voxels, grid), at[0], at[1], at[2]);
    if (rule == OverlapRule::refuse)
      throw InputError(where, what, "erase one of them there, or give --overlap smaller: the smaller one keeps them");
    warnings.push_back(what + "; the smaller one keeps them");
  }
}

/// Numbers exchanged by mistake: everything else would be done to the wrong organ.
void refuse_exchanged(const LabelMap& labels, const std::string& where) {
  auto counts = voxel_counts(labels);
  const std::size_t gallbladder = counts[label_of(Structure::gallbladder)], liver = counts[label_of(Structure::liver)];
  if (gallbladder > liver)
    throw InputError(where,
                     text("the gallbladder (%.4g mL) is larger than the liver (%.4g mL)",
                          millilitres(gallbladder, labels.grid), millilitres(liver, labels.grid)),
                     "exchange them in labels.toml, or check the numbers");
}

/// Volumes that no adult has: a wrong name or number, or a wrong unit.
void judge_volumes(const LabelMap& labels, std::vector<std::string>& warnings) {
  struct Range {
    Structure structure;
    double least, most;  // mL
  };
  const std::array<Range, 2> ranges{{{Structure::liver, 500, 4000}, {Structure::gallbladder, 5, 300}}};
  const auto counts = voxel_counts(labels);
  for (const Range& range : ranges) {
    const auto count = counts.find(label_of(range.structure));
    if (count == counts.end()) continue;
    const double ml = millilitres(count->second, labels.grid);
    if (ml < range.least || ml > range.most)
      warnings.push_back(text("the %s has %.4g mL, adults have %.0f to %.0f; check its name and that it is whole",
                              name_of(range.structure).data(), ml, range.least, range.most));
  }
}

}  // namespace

std::vector<std::string> describe_segments(const Segmentation& segmentation) {
  std::vector<std::string> lines;
  for (const Segment& segment : segmentation.segments)
    lines.push_back(text("%s: %zu voxels, %.4g mL", title_of(segment).substr(0, 80).c_str(), segment.voxels,
                         millilitres(segment.voxels, segmentation.grid)));
  return lines;
}

StructureLabels label_structures(const Segmentation& segmentation, const NameTable& table, OverlapRule overlaps,
                                 const std::string& where) {
  const std::vector<Structure> structures = name_segments(segmentation, table, where);
  require(Structure::gallbladder, structures, segmentation, table, where);
  require(Structure::liver, structures, segmentation, table, where);
  StructureLabels result;
  std::map<Structure, std::string> taken;
  for (std::size_t s = 0; s < structures.size(); ++s) {
    const Segment& segment = segmentation.segments[s];
    const std::string title = title_of(segment);
    result.segments.push_back({title, structures[s], segment.voxels, millilitres(segment.voxels, segmentation.grid)});
    if (structures[s] == Structure::none) continue;
    const auto [before, first] = taken.try_emplace(structures[s], title);
    if (!first)
      result.warnings.push_back("\"" + before->second + "\" and \"" + title + "\" are joined to one " +
                                std::string(name_of(structures[s])));
  }
  Painter painter(segmentation, structures);
  result.labels.grid = segmentation.grid;
  result.labels.voxels = painter.paint();
  judge_overlaps(painter, segmentation.grid, overlaps, where, result.warnings);
  for (const auto& [structure, name] : taken) result.labels.names[label_of(structure)] = name_of(structure);
  refuse_exchanged(result.labels, where);
  judge_volumes(result.labels, result.warnings);
  return result;
}

}  // namespace calot
