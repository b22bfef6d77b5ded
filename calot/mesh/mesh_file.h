// Mesh files: .msh (Gmsh 2.2 and 4.1), .vtu, legacy .vtk; surfaces: .stl, .obj, .ply.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/mesh/surface.h"
#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Coordinates and numbers exactly as a file gives them (its own unit), plus what was noticed on the way.
struct MeshFile {
  TetMesh mesh;                    ///< positions in the file's unit times `scale`
  std::vector<std::string> notes;  ///< e.g. "12 triangles ignored"; for the log
};

/// Reads a tetrahedral mesh, format by ending (.msh, .vtu, .vtk), and checks it with `validate`.
/// @param scale  metres per file unit, e.g. 1e-3 for millimetres; > 0
/// Region numbers come from Gmsh's physical groups (entity numbers where there are none) or from a cell array named
/// "region", "gmsh:physical", "medit:ref", "label", "material" or "CellEntityIds" (any case, the first of these); names
/// from $PhysicalNames or the field arrays "region_ids" and "region_names" (docs/formats.md). Surface elements are left
/// out and counted in `notes`; so are vertices that no tet uses, and vertices at exactly the same place, both of which
/// are kept: after a cut the lips are so, and only the tets' numbers tell that they are apart. Inverted tets are an
/// error unless all are inverted (some tools wind the other way; then all are turned). Throws InputError naming file
/// and line (or byte, or XML element) for anything wrong.
MeshFile read_mesh(const std::filesystem::path& path, double scale = 1.0);

enum class MeshFormat {
  msh22,
  msh22_binary,
  msh41,
  msh41_binary,
  vtu_ascii,
  vtu_base64,
  vtu_appended,
  vtu_zlib,
  vtk_ascii,
  vtk_binary
};
enum class SurfaceFormat { stl_ascii, stl_binary, obj, ply_ascii, ply_binary };

/// A named array on the vertices, for result files: `components` values a vertex.
struct VertexArray {
  std::string name;
  int components = 1;
  std::vector<double> values;  ///< n × components
};

/// Writes a mesh (whole or not at all; the same bytes every time). Coordinates read back bit for bit. Throws InputError
/// for a mesh without tets, numbers out of range, positions that aren't finite, and names with quotes or control
/// characters. Arrays go into .vtu and .vtk as point data, into .msh as $NodeData. The two-argument form chooses the
/// format by the ending: .msh → msh22 (ascii), .vtu → vtu_zlib, .vtk → vtk_binary.
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh, const std::vector<VertexArray>& arrays = {});
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh, MeshFormat format,
                const std::vector<VertexArray>& arrays = {});

/// Reads a triangle surface, format by ending (.stl, .obj, .ply). Polygons become fans of triangles; in .stl, which has
/// no shared vertices, corners at exactly the same place become one. Regions come from .obj groups named region_N and
/// from a .ply face property "region". Throws InputError naming file and line (or byte) for anything wrong.
/// @param scale  metres per file unit; > 0
Surface read_surface(const std::filesystem::path& path, double scale = 1.0);
/// Writes a surface; reads back bit for bit, except that binary .stl holds single precision only.
/// By ending: .stl → stl_binary, .obj → obj, .ply → ply_binary.
void write_surface(const std::filesystem::path& path, const Surface& surface);
void write_surface(const std::filesystem::path& path, const Surface& surface, SurfaceFormat format);

/// Metres per "m", "cm" or "mm". Throws InputError naming `where`.
double metres_per(const std::string& unit, const std::string& where);

}  // namespace calot
