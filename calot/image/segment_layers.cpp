#include "calot/image/segment_layers.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/image/text.h"

namespace calot {

ToReference::ToReference(const VoxelGrid& from, const SegmentationOptions& options, const std::string& where,
                         std::vector<std::string>& notes)
    : from_(from), to_(options.reference.value_or(from)) {
  if (!options.reference) {
    as_it_is_ = true;
    return;
  }
  placement_ = placement_in(to_, from_);
  const std::string difference = grid_difference(to_, from_);
  if (placement_) {
    as_it_is_ = placement_->is_identity(to_, from_);
    if (!as_it_is_) notes.push_back("its voxels are the CT's, in another order or a part of them: put in place");
    if (placement_->off > 0.01)
      notes.push_back("its voxels lie up to " + short_number(placement_->off) + " of a voxel from the CT's");
    return;
  }
  if (!options.resample)
    throw InputError(where, "is on another grid than the CT (CT and labels differ: " + difference + ")",
                     "export it on the CT's grid, or give --resample-labels");
  notes.push_back("resampled onto the CT's grid by the nearest voxel; CT and labels differed: " + difference);
}

void LayerPacker::add(const std::vector<std::uint8_t>& mask, const std::string& name, const std::string& source) {
  const auto is_set = [](std::uint8_t value) { return value != 0; };
  const auto first = std::find_if(mask.begin(), mask.end(), is_set);
  if (first == mask.end()) {
    into_.empty.push_back(name);
    return;
  }
  const auto begin = static_cast<std::size_t>(first - mask.begin());
  const auto end = static_cast<std::size_t>(std::find_if(mask.rbegin(), mask.rend(), is_set).base() - mask.begin());
  std::size_t layer = 0;
  for (; layer < into_.layers.size(); ++layer) {
    std::size_t v = begin;
    while (v < end && !(mask[v] != 0 && into_.layers[layer][v] != 0)) ++v;
    if (v == end) break;
  }
  if (layer == into_.layers.size()) into_.layers.emplace_back(mask.size());
  if (into_.segments.size() == 65535) throw InputError(source, "is one mask too many: 65535 are there already");
  Segment segment{name, static_cast<Label>(into_.segments.size() + 1), layer, 0, source};
  for (std::size_t v = begin; v < end; ++v)
    if (mask[v] != 0) {
      into_.layers[layer][v] = segment.value;
      ++segment.voxels;
    }
  into_.segments.push_back(std::move(segment));
}

std::string stem_of(const std::filesystem::path& path) {
  std::filesystem::path name = path.filename();
  if (name.extension() == ".gz") name = name.stem();
  std::string stem = name.stem().string();
  if (stem.ends_with(".seg")) stem.resize(stem.size() - 4);
  return stem;
}

}  // namespace calot
