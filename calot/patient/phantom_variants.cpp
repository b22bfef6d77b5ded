// The whole operating field: variants by name, and the steps from options to voxels.
#include <algorithm>
#include <array>

#include "calot/base/error.h"
#include "calot/patient/phantom_paint.h"

namespace calot {
namespace {

constexpr std::array<std::string_view, 6> variant_names{
    "usual", "short-cystic-duct", "low-insertion", "aberrant-right-duct", "second-cystic-artery", "inflamed"};

void check(const PhantomOptions& options) {
  if (!(options.voxel >= 0.3e-3 && options.voxel <= 1.0e-3))
    throw InputError("phantom", "the voxel size isn't in 0.3 … 1.0 mm", "use 0.7 mm");
  if (!options.matrix) return;
  const auto& n = *options.matrix;
  if (n[0] < 128 || n[0] > 1024 || n[1] < 128 || n[1] > 1024 || n[2] < 48 || n[2] > 1000)
    throw InputError("phantom", "the matrix isn't within 128x128x48 … 1024x1024x1000", "use 512x512x300");
  if (n[0] * n[1] * n[2] > 200'000'000)
    throw InputError("phantom", "the matrix has more than 200 million voxels", "use 512x512x300");
}

}  // namespace

std::string_view name_of(PhantomVariant variant) {
  return variant_names[static_cast<std::size_t>(variant)];
}

std::optional<PhantomVariant> variant_named(std::string_view name) {
  for (std::size_t v = 0; v < variant_names.size(); ++v)
    if (variant_names[v] == name) return static_cast<PhantomVariant>(v);
  return {};
}

Phantom make_phantom(const PhantomOptions& options, Progress& progress) {
  check(options);
  progress.phase("phantom: anatomy");
  const OperatingField field = draw_operating_field(options.seed, options.variant);
  Random surroundings(scramble(options.seed) ^ 0x61626400u);
  const Abdomen abdomen = draw_abdomen(surroundings, field);
  Phantom phantom;
  phantom.facts = field.facts;
  phantom.lines = field.lines();
  phantom.labels.grid = phantom.ct.grid = phantom_grid(options, field, abdomen);
  phantom.labels.voxels.resize(phantom.labels.grid.count());
  phantom.ct.hounsfield.resize(phantom.labels.grid.count());
  progress.at(1);
  progress.phase("phantom: voxels");
  paint_field(field, abdomen, options.seed, phantom, progress);
  trace_tubes(field, phantom.labels);
  clean_labels(phantom.labels);
  const std::map<Label, std::string> names = structure_names();
  for (const auto& [label, voxels] : voxel_counts(phantom.labels)) phantom.labels.names[label] = names.at(label);
  progress.at(1);
  return phantom;
}

}  // namespace calot
