#include "tests/support/edits.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace calot::test {
namespace {

using Face = std::array<VertexId, 3>;

bool has(const Tet& tet, VertexId v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

std::array<Face, 4> faces_of(const Tet& t) {
  std::array<Face, 4> faces{{{t[1], t[2], t[3]}, {t[0], t[2], t[3]}, {t[0], t[1], t[3]}, {t[0], t[1], t[2]}}};
  for (Face& face : faces) std::sort(face.begin(), face.end());
  return faces;
}

/// Volume against the longest edge cubed; 0.118 for a regular tet.
double shape_of(const std::array<Vec3, 4>& p) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) longest = std::max(longest, (p[i] - p[j]).norm());
  return signed_volume(p[0], p[1], p[2], p[3]) / (longest * longest * longest);
}

constexpr double sliver = 2e-4;  // below this a generated edit is left out: accuracy would be the mesh's, not ours

/// Groups of the tets around a vertex that hang together through faces that stay joined.
class Fan {
 public:
  Fan(const TetMesh& mesh, const std::vector<TetId>& tets, VertexId v, const std::set<Face>& open)
      : root_(tets.size()) {
    std::iota(root_.begin(), root_.end(), std::size_t{0});
    std::map<Face, std::size_t> first;
    for (std::size_t k = 0; k < tets.size(); ++k)
      for (const Face& face : faces_of(mesh.tet(tets[k]))) {
        if (open.contains(face) || std::find(face.begin(), face.end(), v) == face.end()) continue;
        const auto [at, fresh] = first.try_emplace(face, k);
        if (!fresh) root_[find(k)] = find(at->second);
      }
  }
  std::size_t find(std::size_t k) {
    while (root_[k] != k) k = root_[k] = root_[root_[k]];
    return k;
  }

 private:
  std::vector<std::size_t> root_;
};

}  // namespace

TopologyEdit bisect_edges(const TetMesh& mesh, const std::vector<EdgeCut>& edges) {
  TopologyEdit edit;
  std::vector<std::uint8_t> taken(mesh.tet_count(), 0);
  const VertexTets around = vertex_tets(mesh);
  for (const EdgeCut& edge : edges) {
    std::vector<TetId> ring;
    for (std::uint32_t k = around.start[edge.a.index()]; k < around.start[edge.a.index() + 1]; ++k)
      if (has(mesh.tet(around.tets[k]), edge.b)) ring.push_back(around.tets[k]);
    const Vec3 at = (1 - edge.weight) * mesh.position(edge.a) + edge.weight * mesh.position(edge.b);
    const auto spoils = [&](TetId t) {
      for (const VertexId end : {edge.a, edge.b}) {
        std::array<Vec3, 4> p;
        for (std::size_t c = 0; c < 4; ++c) p[c] = mesh.tet(t)[c] == end ? at : mesh.position(mesh.tet(t)[c]);
        if (shape_of(p) < sliver) return true;
      }
      return taken[t.index()] != 0;
    };
    if (ring.empty() || std::any_of(ring.begin(), ring.end(), spoils)) continue;
    const VertexId middle(mesh.vertex_count() + edit.vertices.size());
    edit.vertices.push_back({at, edge.a, edge.b, edge.weight});
    for (const TetId t : ring) {
      taken[t.index()] = 1;
      edit.removed.push_back(t);
      for (const VertexId end : {edge.a, edge.b}) {
        Tet half = mesh.tet(t);
        std::replace(half.begin(), half.end(), end, middle);
        edit.tets.push_back({half, t});
      }
    }
  }
  std::sort(edit.removed.begin(), edit.removed.end());
  return edit;
}

TopologyEdit random_bisections(const TetMesh& mesh, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<EdgeCut> edges;
  for (std::size_t k = 0; k < count && mesh.tet_count() > 0; ++k) {
    const Tet& tet = mesh.tets[random.below(mesh.tet_count())];
    const std::size_t a = random.below(4), b = (a + 1 + random.below(3)) % 4;
    edges.push_back({tet[a], tet[b], random.between(0.3, 0.7)});
  }
  return bisect_edges(mesh, edges);
}

TopologyEdit separate(const TetMesh& mesh, const std::vector<std::uint8_t>& above,
                      const std::function<bool(const Face&)>& cut) {
  std::map<Face, std::size_t> lower, upper;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (const Face& face : faces_of(mesh.tets[t])) (above[t] ? upper : lower)[face] = t;
  std::set<Face> open;
  std::set<VertexId> on_it;
  for (const auto& [face, t] : lower)
    if (upper.contains(face) && (!cut || cut(face))) {
      open.insert(face);
      on_it.insert(face.begin(), face.end());
    }
  const VertexTets around = vertex_tets(mesh);
  std::map<std::pair<TetId, VertexId>, VertexId> instead;
  TopologyEdit edit;
  for (const VertexId v : on_it) {
    const std::vector<TetId> tets(around.tets.begin() + around.start[v.index()],
                                  around.tets.begin() + around.start[v.index() + 1]);
    Fan fan(mesh, tets, v, open);
    std::map<std::size_t, VertexId> copy{{fan.find(0), v}};
    for (std::size_t k = 0; k < tets.size(); ++k) {
      const auto [at, fresh] = copy.try_emplace(fan.find(k), VertexId(mesh.vertex_count() + edit.vertices.size()));
      if (fresh) edit.vertices.push_back({mesh.position(v), v, v, 0});
      if (at->second != v) instead[{tets[k], v}] = at->second;
    }
  }
  std::map<TetId, Tet> changed;
  for (const auto& [where, vertex] : instead) {
    Tet& tet = changed.try_emplace(where.first, mesh.tet(where.first)).first->second;
    std::replace(tet.begin(), tet.end(), where.second, vertex);
  }
  for (const auto& [t, tet] : changed) {
    edit.removed.push_back(t);
    edit.tets.push_back({tet, t});
  }
  return edit;
}

TopologyEdit random_moves(const TetMesh& mesh, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const VertexTets around = vertex_tets(mesh);
  std::map<VertexId, MovedVertex> moved;
  const auto position = [&](VertexId v) { return moved.contains(v) ? moved.at(v).position : mesh.position(v); };
  for (std::size_t k = 0; k < count && mesh.tet_count() > 0; ++k) {
    const Tet& tet = mesh.tets[random.below(mesh.tet_count())];
    const std::size_t a = random.below(4), b = (a + 1 + random.below(3)) % 4;
    const double weight = random.between(0.02, 0.3);
    if (moved.contains(tet[a])) continue;
    const Vec3 place = (1 - weight) * mesh.position(tet[a]) + weight * mesh.position(tet[b]);
    moved[tet[a]] = {tet[a], tet[b], weight, place};
    bool sound = true;
    for (std::uint32_t i = around.start[tet[a].index()]; i < around.start[tet[a].index() + 1]; ++i) {
      const Tet& near = mesh.tet(around.tets[i]);
      sound = sound && shape_of({position(near[0]), position(near[1]), position(near[2]), position(near[3])}) > sliver;
    }
    if (!sound) moved.erase(tet[a]);
  }
  TopologyEdit edit;
  for (const auto& [v, move] : moved) edit.moved.push_back(move);
  return edit;
}

TopologyEdit random_edit(const TetMesh& mesh, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const std::size_t kind = random.below(5);
  if (kind == 0) return random_moves(mesh, count, random.next());
  if (kind == 1) {
    TopologyEdit edit;
    edit.removed = random_tets(mesh, count, random.next());
    return edit;
  }
  if (kind == 2 && mesh.tet_count() > 0) {  // a slit in a random plane, near a random tet
    const Vec3 centre = mesh.position(mesh.tets[random.below(mesh.tet_count())][0]);
    const Vec3 normal = Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)).normalized();
    const double reach = random.between(0.003, 0.012);
    std::vector<std::uint8_t> above(mesh.tet_count(), 0);
    for (const TetId t : tets_where(mesh, [&](const Vec3& c) { return normal.dot(c - centre) > 0; }))
      above[t.index()] = 1;
    return separate(mesh, above, [&](const Face& face) {
      return (mesh.position(face[0]) - centre).norm() < reach && (mesh.position(face[1]) - centre).norm() < reach &&
             (mesh.position(face[2]) - centre).norm() < reach;
    });
  }
  return random_bisections(mesh, count, random.next());
}

}  // namespace calot::test
