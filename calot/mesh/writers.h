// Inside this room only: the writers; each gives the bytes of a file. Meshes and arrays were checked before.
#pragma once
#include <string>
#include <vector>

#include "calot/mesh/mesh_file.h"

namespace calot::detail {

std::string format_msh22(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary);
std::string format_msh41(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary);

enum class VtuFormat { ascii, base64, appended, zlib };
std::string format_vtu(const TetMesh& mesh, const std::vector<VertexArray>& arrays, VtuFormat format);
std::string format_vtk(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary);

std::string format_stl(const Surface& surface, bool binary, const std::string& name);
std::string format_obj(const Surface& surface);
std::string format_ply(const Surface& surface, bool binary);

}  // namespace calot::detail
