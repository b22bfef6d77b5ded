// Segmentations of one file: NIfTI and NRRD, with 3D Slicer's layers.
#include <algorithm>
#include <array>

#include "calot/base/error.h"
#include "calot/base/memory.h"
#include "calot/image/nifti.h"
#include "calot/image/segment_layers.h"
#include "calot/image/text.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

/// Counts of all labels of a layer, by label.
std::vector<std::size_t> counts_of(const std::vector<Label>& layer) {
  std::vector<std::size_t> counts(std::size_t{1} << 16);
  for (const Label label : layer) ++counts[label];
  return counts;
}

/// Segments that nobody wants leave the list, and their voxels become background.
void drop_unwanted(Segmentation& found, const SegmentationOptions& options) {
  std::vector<std::vector<std::uint8_t>> drop(found.layers.size());
  std::vector<Segment> kept;
  for (Segment& segment : found.segments) {
    if (segment.name.empty() || options.wanted(segment.name)) {
      kept.push_back(std::move(segment));
      continue;
    }
    found.unread.push_back(segment.name);
    auto& table = drop[segment.layer];
    table.resize(std::size_t{1} << 16);
    table[segment.value] = 1;
  }
  found.segments = std::move(kept);
  for (std::size_t l = 0; l < drop.size(); ++l)
    if (!drop[l].empty())
      for (Label& label : found.layers[l])
        if (drop[l][label]) label = 0;
}

/// Labels that have voxels but that the file says nothing about.
void declare_others(Segmentation& found, const std::string& source) {
  for (std::size_t l = 0; l < found.layers.size(); ++l) {
    std::vector<std::size_t> counts = counts_of(found.layers[l]);
    for (const Segment& segment : found.segments)
      if (segment.layer == l) counts[segment.value] = 0;
    for (std::size_t label = 1; label < counts.size(); ++label)
      if (counts[label] > 0) found.segments.push_back({"", static_cast<Label>(label), l, 0, source});
  }
}

void by_number(std::vector<Segment>& segments) {
  std::stable_sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
}

// ---- NRRD

/// Which of the file's layers are wanted, and where each goes.
struct LayerChoice {
  std::vector<std::ptrdiff_t> slot;  // −1: not read
  std::size_t count = 0;
};

LayerChoice choose_layers(std::vector<NrrdSegment>& segments, std::size_t components,
                          const SegmentationOptions& options) {
  LayerChoice choice{std::vector<std::ptrdiff_t>(components, -1), 0};
  std::vector<bool> named(components), wanted(components);
  for (const NrrdSegment& segment : segments) {
    named[segment.layer] = true;
    if (segment.name.empty() || options.wanted(segment.name)) wanted[segment.layer] = true;
  }
  for (std::size_t c = 0; c < components; ++c)
    if (wanted[c] || !named[c]) choice.slot[c] = static_cast<std::ptrdiff_t>(choice.count++);
  return choice;
}

std::vector<std::vector<Label>> read_layers(NumberReader& numbers, const NrrdHeader& header, const LayerChoice& choice,
                                            Progress& progress) {
  const std::size_t voxels = header.grid.count(), components = header.components;
  require_memory(choice.count * voxels * sizeof(Label), "the segmentation's layers");
  std::vector<std::vector<Label>> layers(choice.count);
  for (auto& layer : layers) layer.reserve(voxels);
  std::size_t n = 0;
  for (auto block = numbers.next(); !block.empty(); block = numbers.next()) {
    for (const double value : block) {
      const std::size_t component = header.components_first ? n % components : n / voxels;
      const std::ptrdiff_t slot = choice.slot[component];
      if (slot >= 0) {
        auto& layer = layers[static_cast<std::size_t>(slot)];
        layer.push_back(label_of(value, layer.size(), numbers.name()));
      }
      ++n;
    }
    progress.at(static_cast<double>(numbers.done()) / static_cast<double>(numbers.count()));
  }
  return layers;
}

/// Notes segments with voxels outside the extent that their header gives: somebody changed one without the other.
void check_extents(const Segmentation& found, const std::vector<NrrdSegment>& declared, const LayerChoice& choice,
                   std::vector<std::string>& notes) {
  const auto& size = found.grid.size;
  for (const NrrdSegment& segment : declared) {
    if (!segment.extent || choice.slot[segment.layer] < 0) continue;
    const auto& layer = found.layers[static_cast<std::size_t>(choice.slot[segment.layer])];
    const auto& extent = *segment.extent;
    std::size_t outside = 0, v = 0;
    for (std::int64_t k = 0; k < static_cast<std::int64_t>(size[2]); ++k)
      for (std::int64_t j = 0; j < static_cast<std::int64_t>(size[1]); ++j) {
        const bool row_inside = j >= extent[2] && j <= extent[3] && k >= extent[4] && k <= extent[5];
        for (std::int64_t i = 0; i < static_cast<std::int64_t>(size[0]); ++i, ++v)
          outside += layer[v] == segment.value && !(row_inside && i >= extent[0] && i <= extent[1]);
      }
    if (outside > 0)
      notes.push_back(in_quotes(segment.name) + " has " + count_of(outside, "voxel") +
                      " outside the extent that the header gives it");
  }
}

}  // namespace

Segmentation read_nifti_segments(const fs::path& path, const SegmentationOptions& options, Progress& progress) {
  ByteSource source(path);
  const NiftiHeader header = read_nifti_header(source);
  NumberReader numbers(source, header.stored, header.grid.count());
  Segmentation found;
  found.format = "NIfTI";
  found.inputs = {path.string()};
  found.grid = header.grid;
  found.layers.push_back(read_labels(numbers, progress));
  for (const auto& [label, name] : header.names) found.segments.push_back({name, label, 0, 0, path.string()});
  declare_others(found, path.string());
  by_number(found.segments);
  drop_unwanted(found, options);
  return found;
}

Segmentation read_nrrd_segments(const fs::path& path, const SegmentationOptions& options, Progress& progress) {
  const NrrdFile file = open_nrrd(path);
  const NrrdHeader& header = file.header;
  std::vector<NrrdSegment> declared = nrrd_segments(header, path.string());
  if (declared.empty() && header.components > 1)
    throw InputError(
        path.string(),
        "has " + std::to_string(header.components) + " numbers a voxel (4-D) but names no segments for them",
        "export it from 3D Slicer as .seg.nrrd, or as one label map");
  const LayerChoice choice = choose_layers(declared, header.components, options);
  NumberReader numbers(*file.source, header.stored, header.grid.count() * header.components);
  Segmentation found;
  found.format = declared.empty() ? "NRRD" : "3D Slicer .seg.nrrd";
  found.inputs = {path.string()};
  if (file.data != path) found.inputs.push_back(file.data.string());
  found.grid = header.grid;
  found.layers = read_layers(numbers, header, choice, progress);
  check_extents(found, declared, choice, found.notes);
  for (const NrrdSegment& segment : declared) {
    const std::ptrdiff_t slot = choice.slot[segment.layer];
    if (slot < 0)
      found.unread.push_back(segment.name);
    else
      found.segments.push_back({segment.name, segment.value, static_cast<std::size_t>(slot), 0, path.string()});
  }
  declare_others(found, path.string());
  drop_unwanted(found, options);
  return found;
}

}  // namespace calot
