#include "calot/mesh/parts.h"

#include <algorithm>
#include <map>
#include <utility>

#include "calot/mesh/tet_faces.h"

namespace calot {
namespace {

/// Numbers the sets by their first member. @return count, number of each member's set
std::vector<std::uint32_t> number_sets(detail::DisjointSets& sets, std::size_t count, std::uint32_t& set_count) {
  std::vector<std::uint32_t> number(count);
  set_count = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t root = sets.find(i);  // the smallest member, so numbered already when it isn't i
    number[i] = root == i ? set_count++ : number[root];
  }
  return number;
}

}  // namespace

Parts face_connected_parts(const TetMesh& mesh) {
  const std::vector<detail::TetFace> faces = detail::sorted_faces(mesh);
  detail::DisjointSets sets(mesh.tet_count());
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].key == faces[i - 1].key) sets.join(faces[i].tet, faces[i - 1].tet);
  Parts parts;
  std::uint32_t count = 0;
  parts.of_tet = number_sets(sets, mesh.tet_count(), count);
  parts.tets.resize(count);
  parts.vertices.resize(count);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) parts.tets[parts.of_tet[t]].emplace_back(t);
  std::vector<std::uint32_t> seen_in(mesh.vertex_count(), count);
  for (std::uint32_t p = 0; p < count; ++p) {
    for (const TetId t : parts.tets[p])
      for (const VertexId v : mesh.tet(t))
        if (std::exchange(seen_in[v.index()], p) != p) parts.vertices[p].push_back(v);
    std::sort(parts.vertices[p].begin(), parts.vertices[p].end());
  }
  return parts;
}

std::vector<std::uint32_t> vertex_connected_groups(const TetMesh& mesh) {
  detail::DisjointSets sets(mesh.vertex_count());
  for (const Tet& tet : mesh.tets)
    for (int c = 1; c < 4; ++c) sets.join(tet[0].value, tet[c].value);
  std::uint32_t count = 0;
  return number_sets(sets, mesh.vertex_count(), count);
}

std::vector<Hinge> hinges(const TetMesh& mesh, const Parts& parts) {
  std::vector<std::vector<std::uint32_t>> parts_of(mesh.vertex_count());
  for (std::uint32_t p = 0; p < parts.count(); ++p)
    for (const VertexId v : parts.vertices[p]) parts_of[v.index()].push_back(p);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<VertexId>> shared;
  for (std::size_t v = 0; v < parts_of.size(); ++v)
    for (std::size_t i = 0; i < parts_of[v].size(); ++i)
      for (std::size_t j = i + 1; j < parts_of[v].size(); ++j) shared[{parts_of[v][i], parts_of[v][j]}].emplace_back(v);
  std::vector<Hinge> result;
  result.reserve(shared.size());
  for (auto& [pair, vertices] : shared) result.push_back({pair.first, pair.second, std::move(vertices)});
  return result;
}

}  // namespace calot
