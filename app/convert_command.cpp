// calot convert: between the formats of meshes, surfaces and compliances.
#include <filesystem>
#include <map>
#include <memory>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/full_matrix.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

struct ConvertArguments {
  std::filesystem::path from, to, model;
  std::string region, format;
  bool float32 = false;
};

const std::map<std::string, MeshFormat> mesh_formats{{"msh22", MeshFormat::msh22},
                                                     {"msh22-binary", MeshFormat::msh22_binary},
                                                     {"msh41", MeshFormat::msh41},
                                                     {"msh41-binary", MeshFormat::msh41_binary},
                                                     {"vtu-ascii", MeshFormat::vtu_ascii},
                                                     {"vtu-base64", MeshFormat::vtu_base64},
                                                     {"vtu-appended", MeshFormat::vtu_appended},
                                                     {"vtu-zlib", MeshFormat::vtu_zlib},
                                                     {"vtk-ascii", MeshFormat::vtk_ascii},
                                                     {"vtk-binary", MeshFormat::vtk_binary}};
const std::map<std::string, SurfaceFormat> surface_formats{{"stl-ascii", SurfaceFormat::stl_ascii},
                                                           {"stl-binary", SurfaceFormat::stl_binary},
                                                           {"obj", SurfaceFormat::obj},
                                                           {"ply-ascii", SurfaceFormat::ply_ascii},
                                                           {"ply-binary", SurfaceFormat::ply_binary}};

enum class Kind { mesh, surface, h5, comp };

Kind kind_of(const std::filesystem::path& path) {
  static const std::map<std::string, Kind> kinds{
      {".msh", Kind::mesh},    {".vtu", Kind::mesh},    {".vtk", Kind::mesh}, {".stl", Kind::surface},
      {".obj", Kind::surface}, {".ply", Kind::surface}, {".h5", Kind::h5},    {".comp", Kind::comp}};
  const auto found = kinds.find(ending_of(path));
  if (found == kinds.end())
    throw InputError(path.string(), "unknown ending \"" + ending_of(path) + "\"",
                     "use .msh, .vtu, .vtk, .stl, .obj, .ply, .h5 or .comp");
  return found->second;
}

/// The format that --format names for this file; throws if it doesn't go with the ending.
template <class Format>
Format format_named(const std::map<std::string, Format>& formats, const ConvertArguments& arguments) {
  const auto found = formats.find(arguments.format);
  if (found == formats.end() || !arguments.format.starts_with(ending_of(arguments.to).substr(1)))
    throw InputError("--format", "\"" + arguments.format + "\" does not go with " + arguments.to.filename().string(),
                     "see `calot convert --help`");
  return found->second;
}

void store(const ConvertArguments& arguments, const TetMesh& mesh) {
  if (arguments.format.empty())
    write_mesh(arguments.to, mesh);
  else
    write_mesh(arguments.to, mesh, format_named(mesh_formats, arguments));
}

void store(const ConvertArguments& arguments, const Surface& surface) {
  if (arguments.format.empty())
    write_surface(arguments.to, surface);
  else
    write_surface(arguments.to, surface, format_named(surface_formats, arguments));
}

Surface surface_of(const TetMesh& mesh, const std::string& region) {
  if (region.empty()) return boundary_surface(mesh);
  const std::vector<std::int32_t> regions = regions_matching(mesh, region, "--region");
  TetMesh chosen = mesh;
  chosen.tets.clear();
  chosen.regions.clear();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (std::find(regions.begin(), regions.end(), mesh.regions[t]) == regions.end()) continue;
    chosen.tets.push_back(mesh.tets[t]);
    chosen.regions.push_back(mesh.regions[t]);
  }
  return boundary_surface(chosen);
}

void convert_geometry(const ConvertArguments& arguments, Kind from, Kind to) {
  if (from == Kind::surface) {
    if (to == Kind::mesh)
      throw InputError(arguments.to.string(), "a surface has no tetrahedra", "mesh a label map with `calot mesh`");
    if (!arguments.region.empty()) throw InputError("--region", "goes with tetrahedral meshes only", "leave it out");
    return store(arguments, read_surface(arguments.from));
  }
  const MeshFile file = read_mesh(arguments.from);
  for (const std::string& note : file.notes) warn(arguments.from.string() + ": " + note);
  if (to == Kind::surface) return store(arguments, surface_of(file.mesh, arguments.region));
  if (!arguments.region.empty()) throw InputError("--region", "goes with surfaces only", "write .stl, .obj or .ply");
  store(arguments, file.mesh);
}

void convert_compliance(const ConvertArguments& arguments, Kind from) {
  if (arguments.model.empty())
    throw InputError("--model", "is needed: a compliance belongs to a model", "add --model model.toml");
  const Model model = load_model(arguments.model);
  const double step = model.dynamics().time_step;
  if (from == Kind::h5) {
    const FullCompliance compliance = load_whole_matrix(arguments.from, model);
    return write_comp(arguments.to, compliance, step);
  }
  constexpr double exact_enough = 1e-6;
  const FullCompliance compliance = read_comp(arguments.from, model.mesh().vertex_count(), step);
  const double residual = probe_residual(compliance, model);
  const bool approximate = !(residual < exact_enough);
  if (approximate)
    warn(arguments.from.string() + " is not the inverse of this model's stiffness (residual " +
         number_text(residual, 2) + "): stored as approximate");
  save_full_compliance(arguments.to, compliance, model, arguments.float32, &terminal_progress(), approximate);
}

void run_convert(const ConvertArguments& arguments) {
  const Kind from = kind_of(arguments.from), to = kind_of(arguments.to);
  check_output_file(arguments.to);
  const auto is_geometry = [](Kind kind) { return kind == Kind::mesh || kind == Kind::surface; };
  if (is_geometry(from) && is_geometry(to))
    convert_geometry(arguments, from, to);
  else if (!is_geometry(from) && !is_geometry(to) && from != to)
    convert_compliance(arguments, from);
  else
    throw InputError(arguments.to.string(), "can't be made from " + ending_of(arguments.from),
                     "see `calot convert --help`");
  say("wrote " + arguments.to.string());
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command = app.add_subcommand("convert", "Convert meshes, surfaces and compliances, by the files' endings");
  command->add_option("A", arguments->from, ".msh .vtu .vtk | .stl .obj .ply | .h5 | .comp")->required();
  command->add_option("B", arguments->to, "the file to write: a mesh or its surface; .comp of .h5; .h5 of .comp")
      ->required();
  command->add_option("--model", arguments->model, "the model.toml of a compliance");
  command->add_option("--region", arguments->region, "only the surface of this region (name or number)")
      ->type_name("NAME");
  command->add_option("--format", arguments->format,
                      "msh22[-binary] msh41[-binary] vtu-{ascii,base64,appended,zlib} vtk-{ascii,binary} "
                      "stl-{ascii,binary} obj ply-{ascii,binary}");
  command->add_flag("--float32", arguments->float32, "store 4-byte reals in .h5");
  command->footer(
      "Examples:\n  calot convert organ.msh organ.vtu\n  calot convert organ.msh gallbladder.stl --region gallbladder\n"
      "  calot convert C.h5 organ.comp --model model.toml");
  command->callback([arguments] { run_convert(*arguments); });
}

}  // namespace calot
