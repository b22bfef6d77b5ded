// Gmsh's .msh files, versions 2.2 and 4.1. Physical group = region; entities carry the same numbers.
#include <map>

#include "calot/mesh/number_text.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

constexpr int gmsh_tet = 4;

/// A row of numbers: a line in ASCII, their bytes in binary.
template <class... T>
void put(std::string& out, bool binary, T... values) {
  if (binary)
    (append_bytes(out, values), ...);
  else
    append_line(out, values...);
}

void put_head(std::string& out, const TetMesh& mesh, const char* version, bool binary) {
  out += std::string("$MeshFormat\n") + version + (binary ? " 1 8\n" : " 0 8\n");
  if (binary) {
    append_bytes(out, std::int32_t{1});
    out += '\n';
  }
  out += "$EndMeshFormat\n";
  if (mesh.region_names.empty()) return;
  out += "$PhysicalNames\n";
  append_line(out, mesh.region_names.size());
  for (const auto& [region, name] : mesh.region_names) {
    out += "3 ";
    append_text(out, region);
    out += " \"" + name + "\"\n";
  }
  out += "$EndPhysicalNames\n";
}

void put_node_data(std::string& out, const TetMesh& mesh, const VertexArray& array, bool binary) {
  out += "$NodeData\n1\n\"" + array.name + "\"\n1\n0\n3\n0\n";
  append_line(out, array.components);
  append_line(out, mesh.vertex_count());
  const auto components = static_cast<std::size_t>(array.components);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto number = static_cast<std::int32_t>(v + 1);
    if (binary)
      append_bytes(out, number);
    else
      append_text(out, number);
    for (std::size_t c = 0; c < components; ++c) {
      if (binary) {
        append_bytes(out, array.values[v * components + c]);
      } else {
        out += ' ';
        append_text(out, array.values[v * components + c]);
      }
    }
    if (!binary) out += '\n';
  }
  out += binary ? "\n$EndNodeData\n" : "$EndNodeData\n";
}

using Box = std::pair<Vec3, Vec3>;

std::map<std::int32_t, Box> region_boxes(const TetMesh& mesh) {
  std::map<std::int32_t, Box> boxes;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Vec3& first = mesh.position(mesh.tets[t][0]);
    auto& [low, high] = boxes.try_emplace(mesh.regions[t], first, first).first->second;
    for (const VertexId v : mesh.tets[t]) {
      low = low.cwiseMin(mesh.position(v));
      high = high.cwiseMax(mesh.position(v));
    }
  }
  return boxes;
}

void put_entities(std::string& out, const TetMesh& mesh, bool binary) {
  const std::map<std::int32_t, Box> boxes = region_boxes(mesh);
  out += "$Entities\n";
  put(out, binary, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{boxes.size()});
  for (const auto& [region, box] : boxes)
    put(out, binary, region, box.first.x(), box.first.y(), box.first.z(), box.second.x(), box.second.y(),
        box.second.z(), std::uint64_t{1}, region, std::uint64_t{0});
  out += binary ? "\n$EndEntities\n" : "$EndEntities\n";
}

void put_nodes_4(std::string& out, const TetMesh& mesh, bool binary) {
  const std::uint64_t n = mesh.vertex_count();
  out += "$Nodes\n";
  put(out, binary, std::uint64_t{1}, n, std::uint64_t{1}, n);
  put(out, binary, std::int32_t{3}, mesh.regions.front(), std::int32_t{0}, n);
  for (std::uint64_t v = 1; v <= n; ++v) put(out, binary, v);
  for (const Vec3& p : mesh.positions) put(out, binary, p.x(), p.y(), p.z());
  out += binary ? "\n$EndNodes\n" : "$EndNodes\n";
}

/// The start of each run of tets of one region: a block holds tets of one region, and their order must stay.
std::vector<std::size_t> region_runs(const TetMesh& mesh) {
  std::vector<std::size_t> starts;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (t == 0 || mesh.regions[t] != mesh.regions[t - 1]) starts.push_back(t);
  return starts;
}

void put_elements_4(std::string& out, const TetMesh& mesh, bool binary) {
  const std::uint64_t m = mesh.tet_count();
  std::vector<std::size_t> starts = region_runs(mesh);
  out += "$Elements\n";
  put(out, binary, std::uint64_t{starts.size()}, m, std::uint64_t{1}, m);
  starts.push_back(mesh.tet_count());
  for (std::size_t run = 0; run + 1 < starts.size(); ++run) {
    put(out, binary, std::int32_t{3}, mesh.regions[starts[run]], std::int32_t{gmsh_tet},
        std::uint64_t{starts[run + 1] - starts[run]});
    for (std::uint64_t t = starts[run]; t < starts[run + 1]; ++t) {
      const Tet& tet = mesh.tets[t];
      put(out, binary, t + 1, std::uint64_t{tet[0].value} + 1, std::uint64_t{tet[1].value} + 1,
          std::uint64_t{tet[2].value} + 1, std::uint64_t{tet[3].value} + 1);
    }
  }
  out += binary ? "\n$EndElements\n" : "$EndElements\n";
}

}  // namespace

std::string format_msh22(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary) {
  std::string out;
  put_head(out, mesh, "2.2", binary);
  out += "$Nodes\n";
  append_line(out, mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3& p = mesh.positions[v];
    put(out, binary, static_cast<std::int32_t>(v + 1), p.x(), p.y(), p.z());
  }
  out += binary ? "\n$EndNodes\n$Elements\n" : "$EndNodes\n$Elements\n";
  append_line(out, mesh.tet_count());
  if (binary) put(out, binary, std::int32_t{gmsh_tet}, static_cast<std::int32_t>(mesh.tet_count()), std::int32_t{2});
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const auto number = static_cast<std::int32_t>(t + 1);
    const std::int32_t region = mesh.regions[t];
    const auto node = [&](int c) { return static_cast<std::int32_t>(mesh.tets[t][c].value + 1); };
    if (binary)
      put(out, binary, number, region, region, node(0), node(1), node(2), node(3));
    else
      append_line(out, number, gmsh_tet, 2, region, region, node(0), node(1), node(2), node(3));
  }
  out += binary ? "\n$EndElements\n" : "$EndElements\n";
  for (const VertexArray& array : arrays) put_node_data(out, mesh, array, binary);
  return out;
}

std::string format_msh41(const TetMesh& mesh, const std::vector<VertexArray>& arrays, bool binary) {
  std::string out;
  put_head(out, mesh, "4.1", binary);
  put_entities(out, mesh, binary);
  put_nodes_4(out, mesh, binary);
  put_elements_4(out, mesh, binary);
  for (const VertexArray& array : arrays) put_node_data(out, mesh, array, binary);
  return out;
}

}  // namespace calot::detail
