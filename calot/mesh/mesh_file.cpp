#include "calot/mesh/mesh_file.h"

#include <algorithm>
#include <cctype>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"

namespace calot {
namespace {

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

[[noreturn]] void refuse_ending(const std::filesystem::path& path, const char* known) {
  throw InputError(path.string(), "unknown mesh format \"" + ending_of(path) + "\"", std::string("use ") + known);
}

constexpr const char* mesh_endings = ".msh, .vtu or .vtk";
constexpr const char* surface_endings = ".stl, .obj or .ply";

bool is_msh(MeshFormat format) {
  return format <= MeshFormat::msh41_binary;
}

/// Quotes and line ends would end a name early in .msh, and a zero byte does in the others.
void check_name(const std::string& where, const std::string& name) {
  const bool bad =
      std::any_of(name.begin(), name.end(), [](char c) { return c == '"' || (c >= 0 && c < ' ') || c == 127; });
  if (bad)
    throw InputError(where, "a name with quotes or control characters: " + detail::in_quotes(name),
                     "choose another name");
}

void check_mesh(const std::string& where, const TetMesh& mesh) {
  if (mesh.tets.empty()) throw InputError(where, "a mesh without tetrahedra can't be written", "keep at least one");
  const MeshProblems problems = validate(mesh);
  if (problems.sizes_differ || !problems.out_of_range.empty() || !problems.not_finite.empty())
    throw InputError(where, "the mesh can't be written: " + problems.describe(), "repair it");
  for (const auto& [region, name] : mesh.region_names) check_name(where, name);
}

void check_arrays(const std::string& where, const TetMesh& mesh, const std::vector<VertexArray>& arrays,
                  MeshFormat format) {
  for (const VertexArray& array : arrays) {
    const std::string name = "array " + detail::in_quotes(array.name);
    if (array.name.empty()) throw InputError(where, "an array without a name", "name it");
    check_name(where, array.name);
    if (array.components < 1 || array.values.size() != mesh.vertex_count() * static_cast<std::size_t>(array.components))
      throw InputError(where, name + " has " + std::to_string(array.values.size()) + " values",
                       "give components × vertices values");
    if (is_msh(format) && array.components != 1 && array.components != 3 && array.components != 9)
      throw InputError(where, name + " has " + std::to_string(array.components) + " components",
                       ".msh holds 1, 3 or 9; write .vtu");
  }
}

std::string format_mesh(const TetMesh& mesh, MeshFormat format, const std::vector<VertexArray>& arrays) {
  switch (format) {
    case MeshFormat::msh22:
      return detail::format_msh22(mesh, arrays, false);
    case MeshFormat::msh22_binary:
      return detail::format_msh22(mesh, arrays, true);
    case MeshFormat::msh41:
      return detail::format_msh41(mesh, arrays, false);
    case MeshFormat::msh41_binary:
      return detail::format_msh41(mesh, arrays, true);
    case MeshFormat::vtu_ascii:
      return detail::format_vtu(mesh, arrays, detail::VtuFormat::ascii);
    case MeshFormat::vtu_base64:
      return detail::format_vtu(mesh, arrays, detail::VtuFormat::base64);
    case MeshFormat::vtu_appended:
      return detail::format_vtu(mesh, arrays, detail::VtuFormat::appended);
    case MeshFormat::vtu_zlib:
      return detail::format_vtu(mesh, arrays, detail::VtuFormat::zlib);
    case MeshFormat::vtk_ascii:
      return detail::format_vtk(mesh, arrays, false);
    case MeshFormat::vtk_binary:
      return detail::format_vtk(mesh, arrays, true);
  }
  return {};
}

void check_surface(const std::string& where, const Surface& surface) {
  if (!surface.regions.empty() && surface.regions.size() != surface.triangles.size())
    throw InputError(where, "the surface's regions and triangles differ in number", "give one region to each triangle");
  detail::finish_surface(surface, where, 1.0);
}

std::string format_surface(const Surface& surface, SurfaceFormat format, const std::string& where) {
  switch (format) {
    case SurfaceFormat::stl_ascii:
      return detail::format_stl(surface, false, where);
    case SurfaceFormat::stl_binary:
      return detail::format_stl(surface, true, where);
    case SurfaceFormat::obj:
      return detail::format_obj(surface);
    case SurfaceFormat::ply_ascii:
      return detail::format_ply(surface, false);
    case SurfaceFormat::ply_binary:
      return detail::format_ply(surface, true);
  }
  return {};
}

}  // namespace

MeshFile read_mesh(const std::filesystem::path& path, double scale) {
  const std::string ending = ending_of(path);
  if (ending != ".msh" && ending != ".vtu" && ending != ".vtk") refuse_ending(path, mesh_endings);
  const std::string bytes = read_file(path);
  if (bytes.empty()) throw InputError(path.string(), "the file is empty", "export the mesh again");
  if (ending == ".msh") return detail::parse_msh(bytes, path.string(), scale);
  if (ending == ".vtu") return detail::parse_vtu(bytes, path.string(), scale);
  return detail::parse_vtk(bytes, path.string(), scale);
}

void write_mesh(const std::filesystem::path& path, const TetMesh& mesh, const std::vector<VertexArray>& arrays) {
  const std::string ending = ending_of(path);
  if (ending == ".msh") return write_mesh(path, mesh, MeshFormat::msh22, arrays);
  if (ending == ".vtu") return write_mesh(path, mesh, MeshFormat::vtu_zlib, arrays);
  if (ending == ".vtk") return write_mesh(path, mesh, MeshFormat::vtk_binary, arrays);
  refuse_ending(path, mesh_endings);
}

void write_mesh(const std::filesystem::path& path, const TetMesh& mesh, MeshFormat format,
                const std::vector<VertexArray>& arrays) {
  check_mesh(path.string(), mesh);
  check_arrays(path.string(), mesh, arrays, format);
  const std::string bytes = format_mesh(mesh, format, arrays);
  write_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

Surface read_surface(const std::filesystem::path& path, double scale) {
  const std::string ending = ending_of(path);
  if (ending != ".stl" && ending != ".obj" && ending != ".ply") refuse_ending(path, surface_endings);
  const std::string bytes = read_file(path);
  if (bytes.empty()) throw InputError(path.string(), "the file is empty", "export the surface again");
  if (ending == ".stl") return detail::parse_stl(bytes, path.string(), scale);
  if (ending == ".obj") return detail::parse_obj(bytes, path.string(), scale);
  return detail::parse_ply(bytes, path.string(), scale);
}

void write_surface(const std::filesystem::path& path, const Surface& surface) {
  const std::string ending = ending_of(path);
  if (ending == ".stl") return write_surface(path, surface, SurfaceFormat::stl_binary);
  if (ending == ".obj") return write_surface(path, surface, SurfaceFormat::obj);
  if (ending == ".ply") return write_surface(path, surface, SurfaceFormat::ply_binary);
  refuse_ending(path, surface_endings);
}

void write_surface(const std::filesystem::path& path, const Surface& surface, SurfaceFormat format) {
  check_surface(path.string(), surface);
  const std::string bytes = format_surface(surface, format, path.string());
  write_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

double metres_per(const std::string& unit, const std::string& where) {
  if (unit == "m") return 1.0;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  throw InputError(where, "unknown length unit \"" + unit + "\"", "use \"m\", \"cm\" or \"mm\"");
}

}  // namespace calot
