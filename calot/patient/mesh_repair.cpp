#include "calot/patient/mesh_repair.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "calot/mesh/parts.h"
#include "calot/mesh/surface.h"
#include "calot/mesh/topology_edit.h"

namespace calot {
namespace {

using FaceKey = std::array<std::uint32_t, 3>;

FaceKey face_key(const Tet& tet, std::size_t opposite) {
  FaceKey key{};
  for (std::size_t c = 0, n = 0; c < 4; ++c)
    if (c != opposite) key[n++] = tet[c].value;
  std::sort(key.begin(), key.end());
  return key;
}

/// The tets of one region as a mesh of their own (same vertices), and their numbers in the whole.
struct RegionTets {
  TetMesh mesh;
  std::vector<TetId> whole;
};

RegionTets tets_of(const TetMesh& mesh, std::int32_t region) {
  RegionTets part;
  part.mesh.positions = mesh.positions;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.regions[t] == region) {
      part.mesh.tets.push_back(mesh.tets[t]);
      part.mesh.regions.push_back(region);
      part.whole.emplace_back(t);
    }
  return part;
}

/// Tets in parts of their region that aren't its largest.
std::vector<std::vector<TetId>> stray_parts(const TetMesh& mesh, std::int32_t region) {
  const RegionTets own = tets_of(mesh, region);
  const Parts parts = face_connected_parts(own.mesh);
  std::vector<std::vector<TetId>> stray;
  if (parts.count() < 2) return stray;
  const auto largest = std::max_element(parts.tets.begin(), parts.tets.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (auto part = parts.tets.begin(); part != parts.tets.end(); ++part) {
    if (part == largest) continue;
    stray.emplace_back();
    for (const TetId t : *part) stray.back().push_back(own.whole[t.index()]);
  }
  return stray;
}

/// The region that a part shares most faces with, or 0.
std::int32_t neighbour_region(const TetMesh& mesh, const std::vector<TetId>& part,
                              const std::map<FaceKey, std::vector<TetId>>& faces) {
  std::map<std::int32_t, std::size_t> shared;
  for (const TetId t : part)
    for (std::size_t f = 0; f < 4; ++f)
      for (const TetId other : faces.at(face_key(mesh.tet(t), f)))
        if (mesh.regions[other.index()] != mesh.regions[t.index()]) ++shared[mesh.regions[other.index()]];
  std::int32_t best = 0;
  std::size_t most = 0;
  for (const auto& [region, count] : shared)
    if (count > most) {
      most = count;
      best = region;
    }
  return best;
}

/// Gives away or marks for removal the stray parts of every region. Returns how many tets changed region.
std::size_t give_away_strays(TetMesh& mesh, std::size_t regions, std::vector<TetId>& removed) {
  std::map<FaceKey, std::vector<TetId>> faces;
  std::size_t given = 0;
  for (std::size_t r = 1; r <= regions; ++r) {
    const auto stray = stray_parts(mesh, static_cast<std::int32_t>(r));
    if (!stray.empty() && faces.empty())
      for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        for (std::size_t f = 0; f < 4; ++f) faces[face_key(mesh.tets[t], f)].emplace_back(t);
    for (const auto& part : stray) {
      const std::int32_t region = neighbour_region(mesh, part, faces);
      if (region == 0)
        removed.insert(removed.end(), part.begin(), part.end());
      else
        given += part.size();
      for (const TetId t : part)
        if (region != 0) mesh.regions[t.index()] = region;
    }
  }
  return given;
}

/// Groups items that share a key; of the groups, the smallest (the first of equals), or nothing when there is one
/// group.
template <class Item>
std::vector<Item> smallest_group(const std::vector<Item>& items, const std::vector<std::vector<std::uint32_t>>& keys) {
  std::vector<std::size_t> group(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) group[i] = i;
  for (bool changed = true; std::exchange(changed, false);)  // a handful of items: the plain way
    for (std::size_t i = 0; i < items.size(); ++i)
      for (std::size_t j = 0; j < items.size(); ++j) {
        const bool shared = std::any_of(keys[i].begin(), keys[i].end(), [&](std::uint32_t k) {
          return std::find(keys[j].begin(), keys[j].end(), k) != keys[j].end();
        });
        if (!shared || group[i] >= group[j]) continue;
        group[j] = group[i];
        changed = true;
      }
  std::map<std::size_t, std::vector<Item>> groups;
  for (std::size_t i = 0; i < items.size(); ++i) groups[group[i]].push_back(items[i]);
  if (groups.size() < 2) return {};
  return std::min_element(groups.begin(), groups.end(),
                          [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); })
      ->second;
}

/// The tets among `around` that hold every vertex of `held`, and of each the vertices that aren't in it.
std::vector<TetId> tets_holding(const TetMesh& mesh, std::span<const TetId> around, std::span<const VertexId> held,
                                std::vector<std::vector<std::uint32_t>>& others) {
  std::vector<TetId> tets;
  for (const TetId t : around) {
    const Tet& tet = mesh.tet(t);
    if (!std::all_of(held.begin(), held.end(),
                     [&](VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); }))
      continue;
    tets.push_back(t);
    others.emplace_back();
    for (const VertexId v : tet)
      if (std::find(held.begin(), held.end(), v) == held.end()) others.back().push_back(v.value);
  }
  return tets;
}

/// Faces of tets around a vertex, keyed by their other two vertices, so that tets sharing one share a key.
std::vector<std::vector<std::uint32_t>> face_keys_around(std::vector<std::vector<std::uint32_t>> others,
                                                         std::size_t vertices) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> number;
  for (auto& three : others) {
    std::sort(three.begin(), three.end());
    const std::array<std::pair<std::uint32_t, std::uint32_t>, 3> pairs{
        {{three[0], three[1]}, {three[0], three[2]}, {three[1], three[2]}}};
    for (std::size_t p = 0; p < 3; ++p)
      three[p] = number.try_emplace(pairs[p], static_cast<std::uint32_t>(vertices + number.size())).first->second;
  }
  return others;
}

/// Tets that keep the outer surface from being a manifold: where it touches itself along an edge or at a vertex, those
/// of the smallest side.
std::vector<TetId> pinching_tets(const TetMesh& mesh) {
  const Surface surface = boundary_surface(mesh);
  const VertexTets around = vertex_tets(mesh);
  const auto tets_at = [&](VertexId v) {
    return std::span(around.tets)
        .subspan(around.start[v.index()], around.start[v.index() + 1] - around.start[v.index()]);
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::vector<std::vector<std::uint32_t>> triangles(surface.positions.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = surface.triangles[t][c], b = surface.triangles[t][(c + 1) % 3];
      ++edges[{std::min(a, b), std::max(a, b)}];
      triangles[a].push_back(t);
    }
  std::vector<TetId> pinching;
  const auto drop = [&](const std::vector<TetId>& tets) { pinching.insert(pinching.end(), tets.begin(), tets.end()); };
  for (const auto& [edge, count] : edges) {
    if (count == 2) continue;
    const std::array<VertexId, 2> ends{surface.vertex_of_mesh[edge.first], surface.vertex_of_mesh[edge.second]};
    std::vector<std::vector<std::uint32_t>> others;
    const std::vector<TetId> tets = tets_holding(mesh, tets_at(ends[0]), ends, others);
    drop(smallest_group(tets, others));
  }
  if (!pinching.empty()) return pinching;  // vertices once the edges are right
  for (std::uint32_t s = 0; s < surface.positions.size(); ++s) {
    std::vector<std::vector<std::uint32_t>> corners;
    for (const std::uint32_t t : triangles[s]) {
      corners.emplace_back();
      for (const std::uint32_t c : surface.triangles[t])
        if (c != s) corners.back().push_back(c);
    }
    const std::vector<std::uint32_t> fan = smallest_group(triangles[s], corners);
    if (fan.empty()) continue;
    const std::array<VertexId, 1> centre{surface.vertex_of_mesh[s]};
    std::vector<std::vector<std::uint32_t>> others;
    const std::vector<TetId> tets = tets_holding(mesh, tets_at(centre[0]), centre, others);
    const std::vector<TetId> side = smallest_group(tets, face_keys_around(std::move(others), mesh.vertex_count()));
    drop(side.empty() ? std::vector<TetId>{surface.tet_of_triangle[fan.front()]} : side);
  }
  return pinching;
}

void remove(TetMesh& mesh, std::vector<TetId> tets) {
  if (tets.empty()) return;
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  TopologyEdit edit;
  edit.removed = std::move(tets);
  apply(mesh, edit);
}

}  // namespace

std::vector<std::string> repair_regions(TetMesh& mesh, std::size_t regions) {
  std::size_t given = 0, dropped = 0;
  for (int round = 0; round < 20; ++round) {  // dropping may part a region, and giving away may not
    std::vector<TetId> removed;
    const std::size_t now = give_away_strays(mesh, regions, removed);
    if (removed.empty()) removed = pinching_tets(mesh);
    const std::size_t before = mesh.tet_count();
    remove(mesh, std::move(removed));
    given += now;
    dropped += before - mesh.tet_count();
    if (now == 0 && before == mesh.tet_count()) break;
  }
  std::vector<std::string> notes;
  if (given > 0)
    notes.push_back(std::to_string(given) + " tets apart from the rest of their region were given to its neighbour");
  if (dropped > 0)
    notes.push_back(std::to_string(dropped) +
                    " tets were dropped where the outer surface touched itself or that hung apart");
  return notes;
}

}  // namespace calot
