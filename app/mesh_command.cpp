// calot mesh: a label map becomes a tetrahedral mesh with its model.toml.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/staged_folder.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/patient/label_mesh_files.h"
#include "calot/picture/picture.h"

namespace calot {
namespace {

struct MeshArguments {
  std::filesystem::path labels, folder;
  std::vector<std::string> chosen, refine;
  MesherOptions options;
};

/// "REGION:MM", the region by name or number.
Refinement parse_refinement(const std::string& text, const LabelMap& map) {
  const std::size_t colon = text.rfind(':');
  double millimetres = 0;
  const char* end = text.data() + text.size();
  if (colon != std::string::npos) {
    const auto [stop, code] = std::from_chars(text.data() + colon + 1, end, millimetres);
    if (code != std::errc() || stop != end) millimetres = 0;
  }
  if (!(millimetres > 0))
    throw InputError("--refine " + text, "isn't REGION:MM", "write e.g. --refine \"cystic duct:1.0\"");
  return {label_matching(map, text.substr(0, colon), "--refine " + text), millimetres * 1e-3};
}

MesherOptions options_for(const MeshArguments& arguments, const LabelMap& map) {
  MesherOptions options = arguments.options;
  for (const std::string& name : arguments.chosen) {
    const Label label = label_matching(map, name, "--labels");
    if (std::find(options.labels.begin(), options.labels.end(), label) == options.labels.end())
      options.labels.push_back(label);
  }
  for (const std::string& text : arguments.refine) options.refine.push_back(parse_refinement(text, map));
  return options;
}

void print_row(const std::string& name, const Quality& q, double voxel_volume) {
  char line[300];
  std::snprintf(line, sizeof line, "%-26s %8zu %8zu %9.2f %7.1f %7.1f %10.3f %10.3f %+7.2f %%", name.c_str(),
                q.vertices, q.tets, q.mean_edge * 1e3, q.min_dihedral, q.max_dihedral, voxel_volume * 1e6,
                q.volume * 1e6, 100 * (q.volume / voxel_volume - 1));
  say(line);
}

void print_table(const LabelMesh& meshed) {
  char line[300];
  std::snprintf(line, sizeof line, "%-26s %8s %8s %9s %7s %7s %10s %10s %9s", "region", "vertices", "tets", "edge mm",
                "angle", "to deg", "voxels mL", "mesh mL", "volume");
  say(line);
  double voxels = 0;
  for (const MeshedRegion& region : meshed.regions) {
    print_row(std::to_string(region.label) + (region.name.empty() ? "" : " " + region.name), region.quality,
              region.voxel_volume);
    voxels += region.voxel_volume;
  }
  if (meshed.regions.size() > 1) print_row("all", meshed.quality, voxels);
}

// What the mesh falls short of, so that nobody has to find it in the table.
void warn_of_shortfalls(const LabelMesh& meshed, const MesherOptions& options) {
  for (const MeshedRegion& region : meshed.regions) {
    const double off = 100 * (region.quality.volume / region.voxel_volume - 1);
    if (std::abs(off) <= 5) continue;
    char line[200];
    std::snprintf(line, sizeof line, "%s has %+.1f %% of its voxels' volume; ask for more --vertices, or --refine it",
                  region.name.empty() ? ("region " + std::to_string(region.label)).c_str() : region.name.c_str(), off);
    warn(line);
  }
  if (meshed.quality.min_dihedral < options.min_dihedral) {
    char line[200];
    std::snprintf(line, sizeof line,
                  "the smallest dihedral angle is %.1f degrees, %.0f were wanted; try another --vertices",
                  meshed.quality.min_dihedral, options.min_dihedral);
    warn(line);
  }
}

void write_preview(const std::filesystem::path& path, const LabelMesh& meshed) {
  const Vec3 palette[] = {
      {0.45, 0.66, 0.36}, {0.93, 0.76, 0.30}, {0.36, 0.55, 0.78}, {0.72, 0.38, 0.33}, {0.62, 0.48, 0.72}};
  std::vector<Surface> surfaces;
  for (const MeshedRegion& region : meshed.regions) surfaces.push_back(region_surface(meshed.mesh, region.label));
  std::vector<PictureItem> items;
  for (std::size_t r = 0; r < surfaces.size(); ++r) {
    const MeshedRegion& region = meshed.regions[r];
    PictureItem item;
    item.surface = &surfaces[r];
    item.color = palette[r % std::size(palette)];
    item.label = region.name.empty() ? "region " + std::to_string(region.label) : region.name;
    item.edges = true;
    items.push_back(item);
  }
  PictureOptions options;
  options.title =
      std::to_string(meshed.quality.vertices) + " vertices, " + std::to_string(meshed.quality.tets) + " tetrahedra";
  write_picture(path, items, options);
}

void run_mesh(const MeshArguments& arguments) {
  Stopwatch watch;
  StagedFolder folder(arguments.folder);
  const LabelMap map = read_label_map(arguments.labels);
  const LabelMesh meshed = mesh_labels(map, options_for(arguments, map), terminal_progress());
  for (const std::string& note : meshed.notes) warn(note);
  warn_of_shortfalls(meshed, arguments.options);
  std::vector<std::string> files = label_mesh_files(meshed);
  files.insert(files.begin(), "preview.png");
  folder.fill(
      [&](const std::filesystem::path& place) {
        write_label_mesh(place, meshed, arguments.labels.filename().string());
        write_preview(place / "preview.png", meshed);
      },
      files);
  print_table(meshed);
  say("wrote " + (arguments.folder / "model.toml").string() + " (" + std::to_string(meshed.tries) + " meshes made, " +
      seconds_text(watch.lap()) + ")");
}

}  // namespace

void add_mesh_command(CLI::App& app) {
  auto arguments = std::make_shared<MeshArguments>();
  CLI::App* command =
      app.add_subcommand("mesh", "Mesh a label map: one conforming tetrahedral mesh of all chosen organs");
  command->add_option("LABELS", arguments->labels, "label map (.nii, .nii.gz)")->required();
  command
      ->add_option("-o,--output", arguments->folder,
                   "folder for model.toml, mesh.msh, mesh.vtu, surfaces and quality.json")
      ->required()
      ->type_name("DIR");
  command->add_option("--vertices", arguments->options.vertices, "how many, met within 3 %")
      ->check(CLI::Range(50, 2000000))
      ->capture_default_str();
  command->add_option("--labels", arguments->chosen, "organs to mesh, by name or number; default: all")
      ->delimiter(',')
      ->type_name("NAME,NAME...");
  command->add_option("--refine", arguments->refine, "a mean edge length for one region; the others give way")
      ->type_name("REGION:MM")
      ->take_all();
  command->add_option("--smooth", arguments->options.smoothing, "Gaussian on the labels, sigma in voxels")
      ->check(CLI::Range(0.0, 2.0))
      ->capture_default_str();
  command->footer("Example:\n  calot mesh labels.nii.gz -o model --vertices 2442 --refine \"cystic duct:1.0\"");
  command->callback([arguments] { run_mesh(*arguments); });
}

}  // namespace calot
