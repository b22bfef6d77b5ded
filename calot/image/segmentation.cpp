#include "calot/image/segmentation.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/image/segment_layers.h"
#include "calot/image/text.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

enum class Kind { nifti, nrrd, surface, other };

Kind kind_of(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto ends = [&](const char* ending) { return name.ends_with(ending); };
  if (ends(".nii") || ends(".nii.gz")) return Kind::nifti;
  if (ends(".nrrd") || ends(".nhdr")) return Kind::nrrd;
  if (ends(".stl") || ends(".obj") || ends(".ply")) return Kind::surface;
  return Kind::other;
}

/// The masks or surfaces of a folder, by name.
struct FolderFiles {
  std::vector<fs::path> masks, surfaces;
  std::size_t others = 0;
  std::string example;
};

FolderFiles files_of(const fs::path& folder) {
  FolderFiles files;
  std::error_code code;
  fs::directory_iterator it(folder, code), end;
  for (; !code && it != end; it.increment(code)) {
    const fs::path path = it->path();
    const std::string name = path.filename().string();
    if (name.starts_with('.')) continue;
    const Kind kind = it->is_regular_file(code) ? kind_of(path) : Kind::other;
    if (kind == Kind::nifti || (kind == Kind::nrrd && name.ends_with(".nrrd")))
      files.masks.push_back(path);
    else if (kind == Kind::surface)
      files.surfaces.push_back(path);
    else if (files.others++ == 0 || name < files.example)
      files.example = name;
  }
  if (code) throw InputError(folder.string(), "can't be listed: " + code.message(), "check its permissions");
  std::sort(files.masks.begin(), files.masks.end());
  std::sort(files.surfaces.begin(), files.surfaces.end());
  return files;
}

Segmentation read_folder(const fs::path& folder, const SegmentationOptions& options, Progress& progress) {
  const FolderFiles files = files_of(folder);
  if (files.masks.empty() && files.surfaces.empty())
    throw InputError(folder.string(), "holds neither masks (.nii, .nii.gz, .nrrd) nor surfaces (.stl, .obj, .ply)",
                     "name a folder with one file a class, or a label map");
  if (!files.masks.empty() && !files.surfaces.empty())
    throw InputError(folder.string(),
                     "holds masks (" + files.masks[0].filename().string() + ") and surfaces (" +
                         files.surfaces[0].filename().string() + ")",
                     "put them into folders of their own");
  Segmentation found = files.surfaces.empty() ? read_masks(files.masks, options, progress)
                                              : read_surfaces(files.surfaces, options, progress);
  if (files.others > 0)
    found.notes.push_back(count_of(files.others, "other file") + " passed over, e.g. " + files.example);
  return found;
}

/// Puts the layers of a single file onto the reference, then counts: what has no voxel (any more) is empty.
void finish_file(Segmentation& found, const SegmentationOptions& options, const std::string& where) {
  const ToReference to_reference(found.grid, options, where, found.notes);
  for (auto& layer : found.layers) layer = to_reference.apply(std::move(layer));
  found.grid = to_reference.grid();
  std::vector<std::vector<std::size_t>> counts;
  for (const auto& layer : found.layers) {
    counts.emplace_back(std::size_t{1} << 16);
    for (const Label label : layer) ++counts.back()[label];
  }
  std::vector<Segment> kept;
  for (Segment& segment : found.segments) {
    segment.voxels = counts[segment.layer][segment.value];
    if (segment.voxels > 0)
      kept.push_back(std::move(segment));
    else
      found.empty.push_back(segment.name.empty() ? std::to_string(segment.value) : segment.name);
  }
  found.segments = std::move(kept);
}

void check_names(const Segmentation& found, const std::string& where) {
  std::map<std::string, const Segment*> names;
  for (const Segment& segment : found.segments) {
    if (segment.name.empty()) continue;
    const auto [at, added] = names.emplace(segment.name, &segment);
    if (!added)
      throw InputError(where,
                       "names two segments " + in_quotes(segment.name) + " (values " +
                           std::to_string(at->second->value) + " and " + std::to_string(segment.value) + ")",
                       "rename one of them");
  }
}

Segmentation read_any(const fs::path& path, const SegmentationOptions& options, Progress& progress) {
  std::error_code code;
  if (fs::is_directory(path, code)) return read_folder(path, options, progress);
  const Kind kind = kind_of(path);
  if (kind == Kind::surface) return read_surfaces({path}, options, progress);
  if (kind == Kind::other) {
    ByteSource there(path);  // says so where it is missing
    throw InputError(path.string(), "is no segmentation that can be read",
                     "give .nii, .nii.gz, .nrrd, .seg.nrrd, .stl, .obj or .ply, or a folder of these");
  }
  Segmentation found =
      kind == Kind::nifti ? read_nifti_segments(path, options, progress) : read_nrrd_segments(path, options, progress);
  finish_file(found, options, path.string());
  return found;
}

}  // namespace

Segmentation read_segmentation(const fs::path& path, const SegmentationOptions& options, Progress& progress) {
  progress.phase("reading the segmentation");
  Segmentation found = read_any(path, options, progress);
  check_names(found, path.string());
  std::sort(found.inputs.begin(), found.inputs.end());
  return found;
}

}  // namespace calot
