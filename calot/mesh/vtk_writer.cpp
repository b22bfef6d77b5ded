// Legacy .vtk files, version 3.0, which every program that reads .vtk can read.
#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/vtk_arrays.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

/// Numbers, `per_line` to a line in ASCII, big endian in binary; a line end behind them.
template <class T>
void put_numbers(std::string& out, bool binary, const std::vector<T>& values, std::size_t per_line) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (binary) {
      append_bytes(out, values[i], true);
      continue;
    }
    if constexpr (sizeof(T) == 1)
      append_text(out, static_cast<int>(values[i]));
    else
      append_text(out, values[i]);
    out += (i + 1) % per_line == 0 && i + 1 < values.size() ? '\n' : ' ';
  }
  out += '\n';
}

void put_names(std::string& out, const TetMesh& mesh, bool binary) {
  if (mesh.region_names.empty()) return;
  std::vector<std::int32_t> ids;
  for (const auto& [region, name] : mesh.region_names) ids.push_back(region);
  const std::string packed = pack_names(mesh.region_names);
  out += "FIELD FieldData 2\nregion_ids 1 " + std::to_string(ids.size()) + " int\n";
  put_numbers(out, binary, ids, 8);
  out += "region_names 1 " + std::to_string(packed.size()) + " unsigned_char\n";
  put_numbers(out, binary, std::vector<std::uint8_t>(packed.begin(), packed.end()), 16);
}

void put_cells(std::string& out, const TetMesh& mesh, bool binary) {
  constexpr std::int32_t vtk_tetra = 10;
  const std::string count = std::to_string(mesh.tet_count());
  out += "CELLS " + count + " " + std::to_string(5 * mesh.tet_count()) + "\n";
  std::vector<std::int32_t> cells;
  for (const Tet& tet : mesh.tets) {
    cells.push_back(4);
    for (const VertexId v : tet) cells.push_back(static_cast<std::int32_t>(v.value));
  }
  put_numbers(out, binary, cells, 5);
  out += "CELL_TYPES " + count + "\n";
  put_numbers(out, binary, std::vector<std::int32_t>(mesh.tet_count(), vtk_tetra), 16);
  out += "CELL_DATA " + count + "\nSCALARS region int 1\nLOOKUP_TABLE default\n";
  put_numbers(out, binary, mesh.regions, 16);
}

}  // namespace

std::string format_vtk(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary) {
  std::string out = "# vtk DataFile Version 3.0\nCalot mesh\n";
  out += binary ? "BINARY\nDATASET UNSTRUCTURED_GRID\n" : "ASCII\nDATASET UNSTRUCTURED_GRID\n";
  put_names(out, mesh, binary);
  const std::string count = std::to_string(mesh.vertex_count());
  out += "POINTS " + count + " double\n";
  std::vector<double> coordinates;
  for (const Vec3& p : mesh.positions) coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
  put_numbers(out, binary, coordinates, 3);
  put_cells(out, mesh, binary);
  if (arrays.empty()) return out;
  out += "POINT_DATA " + count + "\nFIELD FieldData " + std::to_string(arrays.size()) + "\n";
  for (const VertexArray& array : arrays) {
    const std::string components = std::to_string(array.components);
    out += percent_encode(array.name) + " " + components + " " + count + " double\n";
    put_numbers(out, binary, array.values, static_cast<std::size_t>(array.components));
  }
  return out;
}

}  // namespace calot::detail
