#include "calot/mesh/topology_edit.h"

#include <algorithm>
#include <cmath>
#include <string>

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

void check_place(const Vec3& position, double weight, const std::string& which) {
  if (!position.allFinite() || !std::isfinite(weight)) refuse(which + " has no finite position");
  if (!(weight >= 0 && weight <= 1)) refuse(which + " lies beyond the edge it belongs to: its weight is not in [0, 1]");
}

void check_added(const TetMesh& mesh, const TopologyEdit& edit) {
  const std::size_t n = mesh.vertex_count();
  for (const AddedVertex& vertex : edit.vertices) {
    if (vertex.from.index() >= n || vertex.to.index() >= n)
      refuse("an added vertex lies between vertices that don't exist");
    check_place(vertex.position, vertex.weight, "an added vertex");
  }
  std::vector<std::uint8_t> used(edit.vertices.size(), 0);
  for (const AddedTet& tet : edit.tets) {
    if (!std::binary_search(edit.removed.begin(), edit.removed.end(), tet.parent))
      refuse("an added tet is no piece of a removed tet");
    for (const VertexId v : tet.vertices) {
      if (v.index() >= n + used.size())
        refuse("an added tet uses vertex " + std::to_string(v.value) + ", which doesn't exist");
      if (v.index() >= n) used[v.index() - n] = 1;
    }
  }
  const auto unused = std::find(used.begin(), used.end(), std::uint8_t{0});
  if (unused != used.end()) refuse("no tet uses added vertex " + std::to_string(unused - used.begin()));
}

constexpr std::uint32_t stays = ~0u;

/// Of each vertex its place in `edit.moved`, or `stays`; empty when nothing moves.
std::vector<std::uint32_t> places_in_moved(const TetMesh& mesh, const TopologyEdit& edit) {
  std::vector<std::uint32_t> place;
  if (edit.moved.empty()) return place;
  place.assign(mesh.vertex_count(), stays);
  for (std::size_t k = 0; k < edit.moved.size(); ++k)
    place[edit.moved[k].vertex.index()] = static_cast<std::uint32_t>(k);
  return place;
}

void check_moved(const TetMesh& mesh, const TopologyEdit& edit) {
  const std::size_t n = mesh.vertex_count();
  for (std::size_t k = 0; k < edit.moved.size(); ++k) {
    const MovedVertex& moved = edit.moved[k];
    const std::string name = "moved vertex " + std::to_string(moved.vertex.value);
    if (moved.vertex.index() >= n || moved.to.index() >= n) refuse(name + " or where it goes doesn't exist");
    if (k > 0 && !(edit.moved[k - 1].vertex < moved.vertex)) refuse(name + " is not in ascending order or there twice");
    if (moved.vertex == moved.to) refuse(name + " goes to itself");
    check_place(moved.position, moved.weight, name);
  }
}

/// What the edit does to the tets that stay, beside moving out of the way of the removed.
struct Staying {
  std::vector<std::uint8_t> alive;  // of each old vertex: has a tet after the edit
  std::vector<TetId> reshaped;      // ascending
};

/// Every tet once. Throws when a moved vertex shares no tet with the one it goes to, or does not survive.
Staying look_at_staying(const TetMesh& mesh, const TopologyEdit& edit) {
  Staying staying{std::vector<std::uint8_t>(mesh.vertex_count(), 0), {}};
  const std::vector<std::uint32_t> place = places_in_moved(mesh, edit);
  std::vector<std::uint8_t> has_edge(edit.moved.size(), 0);
  auto removed = edit.removed.begin();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    const bool goes = removed != edit.removed.end() && removed->index() == t;
    if (goes) ++removed;
    bool moves = false;
    if (!place.empty())
      for (const VertexId v : tet) {
        const std::uint32_t k = place[v.index()];
        if (k == stays) continue;
        moves = true;
        if (std::find(tet.begin(), tet.end(), edit.moved[k].to) != tet.end()) has_edge[k] = 1;
      }
    if (goes) continue;
    if (moves) staying.reshaped.emplace_back(t);
    for (const VertexId v : tet) staying.alive[v.index()] = 1;
  }
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < staying.alive.size()) staying.alive[v.index()] = 1;
  for (std::size_t k = 0; k < edit.moved.size(); ++k) {
    const std::string name = "moved vertex " + std::to_string(edit.moved[k].vertex.value);
    if (!has_edge[k]) refuse(name + " shares no tet with vertex " + std::to_string(edit.moved[k].to.value));
    if (!staying.alive[edit.moved[k].vertex.index()]) refuse(name + " has no tet left");
  }
  return staying;
}

constexpr double flat_limit = 1e-14;  // of the longest edge cubed, as in validate()

void check_shape(const std::array<Vec3, 4>& p, const std::string& which) {
  double longest = 0;  // squared
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) longest = std::max(longest, (p[i] - p[j]).squaredNorm());
  const double volume = signed_volume(p[0], p[1], p[2], p[3]);
  if (volume > flat_limit * longest * std::sqrt(longest)) return;
  refuse(which + (volume < 0 ? " is inverted" : " is flat"));
}

/// Every tet that the edit adds or reshapes has a volume.
void check_shapes(const TetMesh& mesh, const TopologyEdit& edit, const std::vector<TetId>& reshaped) {
  const auto position = [&](VertexId v) -> const Vec3& {
    if (v.index() >= mesh.vertex_count()) return edit.vertices[v.index() - mesh.vertex_count()].position;
    const auto moved = std::lower_bound(edit.moved.begin(), edit.moved.end(), v,
                                        [](const MovedVertex& m, VertexId vertex) { return m.vertex < vertex; });
    return moved != edit.moved.end() && moved->vertex == v ? moved->position : mesh.position(v);
  };
  const auto corners = [&](const Tet& t) {
    return std::array<Vec3, 4>{position(t[0]), position(t[1]), position(t[2]), position(t[3])};
  };
  for (std::size_t k = 0; k < edit.tets.size(); ++k)
    check_shape(corners(edit.tets[k].vertices), "added tet " + std::to_string(k));
  for (const TetId t : reshaped) check_shape(corners(mesh.tet(t)), "reshaped tet " + std::to_string(t.value));
}

/// Throws unless the edit can be applied.
Staying check(const TetMesh& mesh, const TopologyEdit& edit) {
  check_removed(mesh, edit);
  check_added(mesh, edit);
  check_moved(mesh, edit);
  Staying staying = look_at_staying(mesh, edit);
  check_shapes(mesh, edit, staying.reshaped);
  return staying;
}

/// Calls body(v) for each old vertex of the removed, added and reshaped tets, repeats included.
template <class Body>
void for_each_touched(const TetMesh& mesh, const TopologyEdit& edit, const std::vector<TetId>& reshaped,
                      const Body& body) {
  for (const TetId t : edit.removed)
    for (const VertexId v : mesh.tet(t)) body(v);
  for (const TetId t : reshaped)
    for (const VertexId v : mesh.tet(t)) body(v);
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < mesh.vertex_count()) body(v);
}

/// The touched vertices among those alive, ascending.
std::vector<VertexId> touched_vertices(const TetMesh& mesh, const TopologyEdit& edit, const Staying& staying) {
  std::vector<VertexId> touched;
  for_each_touched(mesh, edit, staying.reshaped, [&](VertexId v) {
    if (staying.alive[v.index()]) touched.push_back(v);
  });
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

void map_vertices(const TopologyEdit& edit, const Staying& staying, Remap& remap) {
  remap.vertex_to_new.resize(staying.alive.size());
  remap.vertex_to_old.reserve(staying.alive.size() + edit.vertices.size());
  for (std::size_t v = 0; v < staying.alive.size(); ++v) {
    if (!staying.alive[v]) {
      remap.orphaned.emplace_back(v);
      continue;
    }
    remap.vertex_to_new[v] = VertexId(remap.vertex_to_old.size());
    remap.vertex_to_old.emplace_back(v);
  }
  for (std::size_t k = 0; k < edit.vertices.size(); ++k) {
    remap.added_vertices.emplace_back(remap.vertex_to_old.size());
    remap.vertex_to_old.push_back(VertexId::none());
  }
}

void map_tets(const TetMesh& mesh, const TopologyEdit& edit, Remap& remap) {
  remap.tet_to_new.resize(mesh.tet_count());
  remap.tet_to_old.reserve(mesh.tet_count() - edit.removed.size() + edit.tets.size());
  auto removed = edit.removed.begin();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (removed != edit.removed.end() && removed->index() == t) {
      ++removed;
      continue;
    }
    remap.tet_to_new[t] = TetId(remap.tet_to_old.size());
    remap.tet_to_old.emplace_back(t);
  }
  for (const AddedTet& tet : edit.tets) {
    remap.added_tets.emplace_back(remap.tet_to_old.size());
    remap.added_parents.push_back(tet.parent);
    remap.tet_to_old.push_back(TetId::none());
  }
}

/// Closes the gaps in place; nothing here can fail but for memory, which is asked for first.
void carry_out(TetMesh& mesh, const TopologyEdit& edit, const Remap& remap) {
  const std::size_t n = mesh.vertex_count(), vertices = remap.vertex_to_old.size(), tets = remap.tet_to_old.size();
  mesh.positions.reserve(vertices);
  mesh.tets.reserve(tets);
  mesh.regions.reserve(tets);
  std::vector<std::int32_t> added_regions;
  for (const AddedTet& tet : edit.tets) added_regions.push_back(mesh.regions[tet.parent.index()]);
  for (const MovedVertex& moved : edit.moved) mesh.positions[moved.vertex.index()] = moved.position;
  const std::size_t kept_vertices = vertices - edit.vertices.size(), kept_tets = tets - edit.tets.size();
  for (std::size_t v = 0; v < kept_vertices; ++v) mesh.positions[v] = mesh.position(remap.vertex_to_old[v]);
  mesh.positions.resize(kept_vertices);
  for (const AddedVertex& vertex : edit.vertices) mesh.positions.push_back(vertex.position);
  const auto renumber = [&](Tet tet) {
    for (VertexId& v : tet) v = v.index() < n ? remap.vertex_to_new[v.index()] : remap.added_vertices[v.index() - n];
    return tet;
  };
  for (std::size_t t = 0; t < kept_tets; ++t) {
    const TetId old = remap.tet_to_old[t];
    mesh.tets[t] = renumber(mesh.tet(old));
    mesh.regions[t] = mesh.regions[old.index()];
  }
  mesh.tets.resize(kept_tets);
  mesh.regions.resize(kept_tets);
  for (const AddedTet& tet : edit.tets) mesh.tets.push_back(renumber(tet.vertices));
  mesh.regions.insert(mesh.regions.end(), added_regions.begin(), added_regions.end());
}

}  // namespace

Remap apply(TetMesh& mesh, const TopologyEdit& edit) {
  Staying staying = check(mesh, edit);
  Remap remap;
  map_vertices(edit, staying, remap);
  map_tets(mesh, edit, remap);
  remap.touched = touched_vertices(mesh, edit, staying);
  remap.added_from = edit.vertices;
  remap.moved = edit.moved;
  remap.reshaped = std::move(staying.reshaped);
#ifdef CALOT_CHECKED
  const TetMesh before = mesh;
  carry_out(mesh, edit, remap);
  if (const MeshProblems problems = validate(mesh); problems.fatal()) {
    mesh = before;
    refuse("leaves a bad mesh: " + problems.describe());
  }
#else
  carry_out(mesh, edit, remap);
#endif
  return remap;
}

std::vector<TetId> reshaped_tets(const TetMesh& mesh, const TopologyEdit& edit) {
  if (edit.moved.empty()) return {};
  check_removed(mesh, edit);
  check_moved(mesh, edit);
  const std::vector<std::uint32_t> place = places_in_moved(mesh, edit);
  std::vector<TetId> reshaped;
  auto removed = edit.removed.begin();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (removed != edit.removed.end() && removed->index() == t) {
      ++removed;
      continue;
    }
    const Tet& tet = mesh.tets[t];
    if (std::any_of(tet.begin(), tet.end(), [&](VertexId v) { return place[v.index()] != stays; }))
      reshaped.emplace_back(t);
  }
  return reshaped;
}

EditExtent extent_of(const TetMesh& mesh, const TopologyEdit& edit) {
  const Staying staying = check(mesh, edit);
  EditExtent extent;
  for (std::size_t v = 0; v < staying.alive.size(); ++v)
    if (!staying.alive[v]) extent.orphaned.emplace_back(v);
  extent.touched = touched_vertices(mesh, edit, staying);
  return extent;
}

}  // namespace calot
