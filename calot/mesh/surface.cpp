#include "calot/mesh/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "calot/mesh/tet_faces.h"

namespace calot {
namespace {

/// Faces, given as (tet, face) flags, become a surface; its vertices keep the mesh's order.
Surface surface_of(const TetMesh& mesh, const std::vector<bool>& on_boundary) {
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
  Surface surface;
  std::vector<std::uint32_t> number(mesh.vertex_count(), unused);
  for (std::size_t i = 0; i < on_boundary.size(); ++i) {
    if (!on_boundary[i]) continue;
    const Tet& tet = mesh.tets[i / 4];
    Triangle triangle{};
    for (int c = 0; c < 3; ++c) triangle[c] = tet[detail::face_corners[i % 4][c]].value;
    for (const std::uint32_t v : triangle) number[v] = 0;
    surface.triangles.push_back(triangle);
    surface.regions.push_back(mesh.regions[i / 4]);
    surface.tet_of_triangle.emplace_back(i / 4);
  }
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == unused) continue;
    number[v] = static_cast<std::uint32_t>(surface.positions.size());
    surface.positions.push_back(mesh.positions[v]);
    surface.vertex_of_mesh.emplace_back(v);
  }
  for (Triangle& triangle : surface.triangles)
    for (std::uint32_t& v : triangle) v = number[v];
  return surface;
}

/// The faces that one tet only has among those that `counts` says count.
template <class Counts>
Surface single_faces(const TetMesh& mesh, const Counts& counts) {
  const std::vector<detail::TetFace> faces = detail::sorted_faces(mesh);
  std::vector<bool> on_boundary(4 * mesh.tet_count(), false);
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    std::size_t sharing = 0, last = 0;
    for (end = begin; end < faces.size() && faces[end].key == faces[begin].key; ++end) {
      if (!counts(faces[end].tet)) continue;
      ++sharing;
      last = end;
    }
    if (sharing == 1) on_boundary[4 * std::size_t{faces[last].tet} + faces[last].face] = true;
  }
  return surface_of(mesh, on_boundary);
}

struct Edge {
  std::uint32_t a, b;
  friend auto operator<=>(const Edge&, const Edge&) = default;
};

/// Whether the edges opposite a vertex form one path or one cycle.
bool is_one_fan(const std::vector<Edge>& link) {
  std::vector<std::uint32_t> nodes;
  for (const Edge& edge : link) nodes.insert(nodes.end(), {edge.a, edge.b});
  std::sort(nodes.begin(), nodes.end());
  for (std::size_t i = 2; i < nodes.size(); ++i)
    if (nodes[i] == nodes[i - 2]) return false;  // an edge at the vertex with three triangles or more
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const auto index = [&](std::uint32_t v) {
    return static_cast<std::uint32_t>(std::lower_bound(nodes.begin(), nodes.end(), v) - nodes.begin());
  };
  detail::DisjointSets sets(nodes.size());
  for (const Edge& edge : link) sets.join(index(edge.a), index(edge.b));
  for (std::uint32_t i = 0; i < nodes.size(); ++i)
    if (sets.find(i) != 0) return false;
  return true;
}

}  // namespace

Surface boundary_surface(const TetMesh& mesh) {
  return single_faces(mesh, [](std::uint32_t) { return true; });
}

Surface region_surface(const TetMesh& mesh, std::int32_t region) {
  return single_faces(mesh, [&](std::uint32_t tet) { return mesh.regions[tet] == region; });
}

std::vector<Vec3> vertex_normals(const Surface& surface, const std::vector<Vec3>& positions) {
  std::vector<Vec3> normals(positions.size(), Vec3::Zero());
  for (const Triangle& t : surface.triangles) {
    const Vec3 twice_area = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
    for (const std::uint32_t v : t) normals[v] += twice_area;
  }
  for (Vec3& normal : normals) {
    const double length = normal.stableNorm();
    normal = length > 0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
  }
  return normals;
}

ManifoldReport check_manifold(const Surface& surface) {
  ManifoldReport report;
  std::vector<Edge> edges;
  std::vector<std::vector<Edge>> links(surface.positions.size());
  for (const Triangle& t : surface.triangles)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
      links[t[(c + 2) % 3]].push_back({a, b});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end] == edges[begin]) ++end;
    if (end - begin == 1) ++report.boundary_edges;
    if (end - begin > 2) ++report.nonmanifold_edges;
  }
  for (const std::vector<Edge>& link : links)
    if (!link.empty() && !is_one_fan(link)) ++report.nonmanifold_vertices;
  return report;
}

}  // namespace calot
