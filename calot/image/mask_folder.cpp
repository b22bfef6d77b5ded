// Segmentations of one file a class: masks and surfaces.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "calot/base/error.h"
#include "calot/image/nifti.h"
#include "calot/image/segment_layers.h"
#include "calot/image/surface_voxels.h"
#include "calot/image/text.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

/// A mask's header, whatever its format.
struct MaskFile {
  VoxelGrid grid;
  StoredNumbers stored;
  std::vector<std::string> inputs;
  std::unique_ptr<ByteSource> source;
};

MaskFile open_mask(const fs::path& path) {
  MaskFile mask;
  mask.inputs = {path.string()};
  if (path.extension() != ".nrrd") {
    mask.source = std::make_unique<ByteSource>(path);
    const NiftiHeader header = read_nifti_header(*mask.source);
    mask.grid = header.grid;
    mask.stored = header.stored;
    return mask;
  }
  NrrdFile file = open_nrrd(path);
  if (file.header.components > 1 || nrrd_segments(file.header, path.string()).size() > 1)
    throw InputError(path.string(), "holds several segments, so it is no mask of one class", "give the file itself");
  if (file.data != path) mask.inputs.push_back(file.data.string());
  mask.grid = file.header.grid;
  mask.stored = file.header.stored;
  mask.source = std::move(file.source);
  return mask;
}

/// Voxels ≠ 0. A map of several labels is no mask: taking all of them for one class would be wrong without a word.
std::vector<std::uint8_t> read_mask(MaskFile& file, const std::function<void(double)>& at) {
  NumberReader numbers(*file.source, file.stored, file.grid.count());
  std::vector<std::uint8_t> mask;
  mask.reserve(file.grid.count());
  Label only = 0;
  for (auto block = numbers.next(); !block.empty(); block = numbers.next()) {
    const std::size_t first = mask.size();
    mask.resize(first + block.size());
    for (std::size_t v = 0; v < block.size(); ++v) {
      if (block[v] == 0) continue;
      const Label label = label_of(block[v], first + v, numbers.name());
      if (only == 0) only = label;
      if (label != only)
        throw InputError(numbers.name(),
                         "holds the labels " + std::to_string(only) + " and " + std::to_string(label) +
                             ", so it is no mask of one class",
                         "give the file itself, or a folder of one mask a class");
      mask[first + v] = 1;
    }
    at(static_cast<double>(numbers.done()) / static_cast<double>(numbers.count()));
  }
  return mask;
}

bool is_label_map(const fs::path& path, const std::function<void(double)>& at) {
  try {
    if (path.extension() == ".nrrd") {
      const NrrdFile file = open_nrrd(path);
      if (nrrd_segments(file.header, path.string()).size() > 1) return true;
    }
    MaskFile file = open_mask(path);
    NumberReader numbers(*file.source, file.stored, file.grid.count());
    Label first = 0;
    bool several = false;
    std::size_t v = 0;
    for (auto block = numbers.next(); !block.empty(); block = numbers.next()) {
      for (const double value : block) {
        const Label label = label_of(value, v++, numbers.name());  // throws for a CT's
        if (first == 0) first = label;
        several = several || (label != 0 && label != first);
      }
      at(static_cast<double>(numbers.done()) / static_cast<double>(numbers.count()));
    }
    return several;
  } catch (const InputError&) {
    return false;
  }
}

/// No file's name is a structure's: one that holds a map of all structures must be named itself.
void advise_label_map(const std::vector<fs::path>& files, Progress& progress) {
  for (std::size_t f = 0; f < files.size(); ++f)
    if (is_label_map(files[f], [&](double part) {
          progress.at((static_cast<double>(f) + part) / static_cast<double>(files.size()));
        }))
      throw InputError(files[f].parent_path().string(),
                       "no file in it is named like a structure, but " + files[f].filename().string() +
                           " holds a map of several labels",
                       "give " + files[f].string() + " itself");
}

/// The files that are wanted, in order of their names; two of one name are an error.
std::vector<fs::path> wanted_files(const std::vector<fs::path>& files, const SegmentationOptions& options,
                                   Segmentation& found) {
  std::map<std::string, fs::path> names;
  std::vector<fs::path> wanted;
  for (const fs::path& file : files) {
    const std::string name = stem_of(file);
    const auto [at, added] = names.emplace(name, file);
    if (!added)
      throw InputError(file.string(),
                       "is a second file for " + in_quotes(name) + ", beside " + at->second.filename().string(),
                       "remove one of them");
    if (options.wanted(name))
      wanted.push_back(file);
    else
      found.unread.push_back(name);
  }
  return wanted;
}

/// 3D Slicer writes into a surface which axes it is in; LPS is its default.
bool says_lps(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string head(1024, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head.find("SPACE=LPS") != std::string::npos;
}

double enclosed_volume(const Surface& surface) {
  double six = 0;
  for (const Triangle& t : surface.triangles)
    six += surface.positions[t[0]].dot(surface.positions[t[1]].cross(surface.positions[t[2]]));
  return std::abs(six) / 6;
}

}  // namespace

Segmentation read_masks(const std::vector<fs::path>& files, const SegmentationOptions& options, Progress& progress) {
  Segmentation found;
  found.format = "folder of masks";
  LayerPacker packer(found);
  std::optional<VoxelGrid> grid;
  std::optional<ToReference> to_reference;
  const std::vector<fs::path> wanted = wanted_files(files, options, found);
  if (wanted.empty()) advise_label_map(files, progress);
  for (std::size_t f = 0; f < wanted.size(); ++f) {
    MaskFile mask = open_mask(wanted[f]);
    if (!grid) {
      grid = mask.grid;
      to_reference.emplace(*grid, options, wanted[f].string(), found.notes);
      found.grid = to_reference->grid();
    }
    const std::string difference = grid_difference(*grid, mask.grid);
    if (!difference.empty())
      throw InputError(
          wanted[f].string(),
          "is on another grid than " + wanted[0].filename().string() + " (that and this differ: " + difference + ")",
          "export all masks on one grid");
    const auto at = [&](double part) {
      progress.at((static_cast<double>(f) + part) / static_cast<double>(wanted.size()));
    };
    packer.add(to_reference->apply(read_mask(mask, at)), stem_of(wanted[f]), wanted[f].string());
    found.inputs.insert(found.inputs.end(), mask.inputs.begin(), mask.inputs.end());
  }
  return found;
}

Segmentation read_surfaces(const std::vector<fs::path>& files, const SegmentationOptions& options, Progress& progress) {
  Segmentation found;
  found.format = "surfaces";
  if (!options.reference)
    throw InputError(files[0].string(), "is a surface, and there is no CT whose voxels it could be put into",
                     "give a CT too, or a label map");
  found.grid = *options.reference;
  LayerPacker packer(found);
  const std::vector<fs::path> wanted = wanted_files(files, options, found);
  for (std::size_t f = 0; f < wanted.size(); ++f) {
    const std::string where = wanted[f].string(), name = wanted[f].filename().string();
    Surface surface = read_surface(wanted[f], options.surface_unit);
    if (says_lps(wanted[f])) {
      for (Vec3& position : surface.positions) position.head<2>() *= -1;
      found.notes.push_back(name + ": in LPS, as its header says (SPACE=LPS); turned into RAS");
    }
    const SurfaceVoxels voxels = voxels_inside(surface, found.grid, where);
    if (voxels.cut) found.notes.push_back(name + ": reaches beyond the CT; cut off at its border");
    const std::size_t before = found.segments.size();
    packer.add(voxels.inside, stem_of(wanted[f]), where);
    const double inside = found.segments.size() > before
                              ? static_cast<double>(found.segments.back().voxels) * found.grid.voxel_volume()
                              : 0;
    found.notes.push_back(name + ": encloses " + short_number(1e6 * enclosed_volume(surface)) + " mL, " +
                          short_number(1e6 * inside) + " mL in voxels");
    found.inputs.push_back(where);
    progress.at(static_cast<double>(f + 1) / static_cast<double>(wanted.size()));
  }
  return found;
}

}  // namespace calot
