#include "calot/mesh/topology_edit.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/mesh/quality.h"

namespace calot {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw InputError("topology edit", what, "give the edit in numbers of the mesh before it");
}

void check_removed(const TetMesh& mesh, const TopologyEdit& edit) {
  for (std::size_t i = 0; i < edit.removed.size(); ++i) {
    const TetId tet = edit.removed[i];
    if (tet.index() >= mesh.tet_count())
      refuse("removes tet " + std::to_string(tet.value) + " of " + std::to_string(mesh.tet_count()));
    if (i > 0 && !(edit.removed[i - 1] < tet))
      refuse("the removed tets are not ascending and unique at " + std::to_string(tet.value));
  }
}

void check_added(const TetMesh& mesh, const TopologyEdit& edit) {
  const std::size_t n = mesh.vertex_count();
  for (const AddedVertex& vertex : edit.vertices) {
    if (vertex.from.index() >= n || vertex.to.index() >= n)
      refuse("an added vertex lies between vertices that don't exist");
    if (!vertex.position.allFinite() || !std::isfinite(vertex.weight)) refuse("an added vertex has no finite position");
  }
  std::vector<bool> used(edit.vertices.size(), false);
  for (const AddedTet& tet : edit.tets) {
    if (!std::binary_search(edit.removed.begin(), edit.removed.end(), tet.parent))
      refuse("an added tet is no piece of a removed tet");
    for (const VertexId v : tet.vertices) {
      if (v.index() >= n + used.size())
        refuse("an added tet uses vertex " + std::to_string(v.value) + ", which doesn't exist");
      if (v.index() >= n) used[v.index() - n] = true;
    }
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused != used.end()) refuse("no tet uses added vertex " + std::to_string(unused - used.begin()));
}

/// Calls body(v) for each old vertex of the removed and added tets, repeats included.
template <class Body>
void for_each_touched(const TetMesh& mesh, const TopologyEdit& edit, const Body& body) {
  for (const TetId t : edit.removed)
    for (const VertexId v : mesh.tet(t)) body(v);
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < mesh.vertex_count()) body(v);
}

/// Whether each old vertex still has a tet after the edit.
std::vector<bool> survivors(const TetMesh& mesh, const TopologyEdit& edit) {
  std::vector<bool> alive(mesh.vertex_count(), false);
  auto removed = edit.removed.begin();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (removed != edit.removed.end() && removed->index() == t) {
      ++removed;
      continue;
    }
    for (const VertexId v : mesh.tets[t]) alive[v.index()] = true;
  }
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < alive.size()) alive[v.index()] = true;
  return alive;
}

void map_vertices(const TetMesh& mesh, const TopologyEdit& edit, Remap& remap) {
  const std::vector<bool> alive = survivors(mesh, edit);
  remap.vertex_to_new.resize(mesh.vertex_count());
  for (std::size_t v = 0; v < alive.size(); ++v) {
    if (!alive[v]) {
      remap.orphaned.emplace_back(v);
      continue;
    }
    remap.vertex_to_new[v] = VertexId(remap.vertex_to_old.size());
    remap.vertex_to_old.emplace_back(v);
  }
  std::vector<bool> touched(mesh.vertex_count(), false);
  for_each_touched(mesh, edit, [&](VertexId v) { touched[v.index()] = alive[v.index()]; });
  for (std::size_t v = 0; v < touched.size(); ++v)
    if (touched[v]) remap.touched.emplace_back(v);
  for (std::size_t k = 0; k < edit.vertices.size(); ++k) {
    remap.added_vertices.emplace_back(remap.vertex_to_old.size());
    remap.vertex_to_old.push_back(VertexId::none());
  }
}

void map_tets(const TetMesh& mesh, const TopologyEdit& edit, Remap& remap) {
  remap.tet_to_new.resize(mesh.tet_count());
  auto removed = edit.removed.begin();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (removed != edit.removed.end() && removed->index() == t) {
      ++removed;
      continue;
    }
    remap.tet_to_new[t] = TetId(remap.tet_to_old.size());
    remap.tet_to_old.emplace_back(t);
  }
  for (std::size_t k = 0; k < edit.tets.size(); ++k) {
    remap.added_tets.emplace_back(remap.tet_to_old.size());
    remap.tet_to_old.push_back(TetId::none());
  }
}

TetMesh edited(const TetMesh& mesh, const TopologyEdit& edit, const Remap& remap) {
  TetMesh result;
  result.region_names = mesh.region_names;
  result.positions.reserve(remap.vertex_to_old.size());
  for (const VertexId old : remap.vertex_to_old)
    if (old.valid()) result.positions.push_back(mesh.position(old));
  for (const AddedVertex& vertex : edit.vertices) result.positions.push_back(vertex.position);
  const auto renumber = [&](Tet tet) {
    for (VertexId& v : tet)
      v = v.index() < mesh.vertex_count() ? remap.vertex_to_new[v.index()]
                                          : remap.added_vertices[v.index() - mesh.vertex_count()];
    return tet;
  };
  result.tets.reserve(remap.tet_to_old.size());
  result.regions.reserve(remap.tet_to_old.size());
  const auto add = [&](const Tet& tet, TetId source) {
    result.tets.push_back(renumber(tet));
    result.regions.push_back(mesh.regions[source.index()]);
  };
  for (const TetId old : remap.tet_to_old)
    if (old.valid()) add(mesh.tet(old), old);
  for (const AddedTet& tet : edit.tets) add(tet.vertices, tet.parent);
  return result;
}

}  // namespace

Remap apply(TetMesh& mesh, const TopologyEdit& edit) {
  check_removed(mesh, edit);
  check_added(mesh, edit);
  Remap remap;
  map_vertices(mesh, edit, remap);
  map_tets(mesh, edit, remap);
  mesh = edited(mesh, edit, remap);
#ifdef CALOT_CHECKED
  const MeshProblems problems = validate(mesh);
  if (problems.fatal()) refuse("leaves a bad mesh: " + problems.describe());
#endif
  return remap;
}

EditExtent extent_of(const TetMesh& mesh, const VertexTets& around, const TopologyEdit& edit) {
  check_removed(mesh, edit);
  check_added(mesh, edit);
  const std::size_t n = mesh.vertex_count();
  // Tets that each vertex has, less the removed, plus the added ones.
  std::vector<std::uint32_t> tets_left(n);
  for (std::size_t v = 0; v < n; ++v) tets_left[v] = around.start[v + 1] - around.start[v];
  for (const TetId t : edit.removed)
    for (const VertexId v : mesh.tet(t)) --tets_left[v.index()];
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < n) ++tets_left[v.index()];
  EditExtent extent;
  for (std::size_t v = 0; v < n; ++v)
    if (tets_left[v] == 0) extent.orphaned.emplace_back(v);
  for_each_touched(mesh, edit, [&](VertexId v) {
    if (tets_left[v.index()] > 0) extent.touched.push_back(v);
  });
  std::sort(extent.touched.begin(), extent.touched.end());
  extent.touched.erase(std::unique(extent.touched.begin(), extent.touched.end()), extent.touched.end());
  return extent;
}

}  // namespace calot
