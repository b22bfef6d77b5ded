#include "calot/cut/separate.h"

#include <algorithm>
#include <string>

#include "calot/base/error.h"

namespace calot {
namespace detail {
namespace {

struct Corner {
  std::uint32_t vertex, tet;
  friend auto operator<=>(const Corner&, const Corner&) = default;
};

/// A face at the vertex in question, by its other two vertices.
struct Spoke {
  std::uint32_t low, high, member;  // member: place in the list of tets around the vertex
  friend auto operator<=>(const Spoke&, const Spoke&) = default;
};

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// The fan of each tet around a vertex, named by the fan's first tet.
std::vector<std::uint32_t> fans_around(std::uint32_t vertex, std::span<const Corner> corners,
                                       const std::vector<std::array<std::uint32_t, 4>>& tets,
                                       const std::vector<FaceKey>& blocked) {
  std::vector<Spoke> spokes;
  std::vector<std::uint32_t> parent(corners.size());
  for (std::uint32_t m = 0; m < corners.size(); ++m) {
    parent[m] = m;
    std::array<std::uint32_t, 3> others{};
    std::size_t count = 0;
    for (const std::uint32_t v : tets[corners[m].tet])
      if (v != vertex) others[count++] = v;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(others[i], others[(i + 1) % 3]);
      spokes.push_back({low, high, m});
    }
  }
  std::sort(spokes.begin(), spokes.end());
  for (std::size_t i = 0; i + 1 < spokes.size(); ++i) {
    const Spoke &a = spokes[i], &b = spokes[i + 1];
    if (a.low != b.low || a.high != b.high) continue;
    if (std::binary_search(blocked.begin(), blocked.end(), face_key(vertex, a.low, a.high))) continue;
    const std::uint32_t one = root_of(parent, a.member), other = root_of(parent, b.member);
    parent[std::max(one, other)] = std::min(one, other);
  }
  for (std::uint32_t m = 0; m < parent.size(); ++m) parent[m] = root_of(parent, m);
  return parent;
}

}  // namespace

FaceKey face_key(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  FaceKey key{a, b, c};
  std::sort(key.begin(), key.end());
  return key;
}

std::vector<std::uint32_t> separate_fans(std::vector<std::array<std::uint32_t, 4>>& tets,
                                         const std::vector<FaceKey>& blocked, std::uint32_t next_copy) {
  std::vector<std::uint32_t> vertices;
  for (const FaceKey& face : blocked) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Corner> corners;
  for (std::uint32_t t = 0; t < tets.size(); ++t)
    for (const std::uint32_t v : tets[t])
      if (std::binary_search(vertices.begin(), vertices.end(), v)) corners.push_back({v, t});
  std::sort(corners.begin(), corners.end());

  struct Change {
    std::uint32_t tet, from, to;
  };
  std::vector<Change> changes;
  std::vector<std::uint32_t> origins;
  for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
    const std::uint32_t vertex = corners[begin].vertex;
    while (end < corners.size() && corners[end].vertex == vertex) ++end;
    const std::span<const Corner> here(corners.data() + begin, end - begin);
    const std::vector<std::uint32_t> fan = fans_around(vertex, here, tets, blocked);
    std::vector<std::uint32_t> size(fan.size(), 0), name(fan.size(), vertex);
    for (const std::uint32_t f : fan) ++size[f];
    const auto largest = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
    for (std::size_t f = 0; f < size.size(); ++f) {
      if (size[f] == 0 || f == largest) continue;
      name[f] = next_copy++;
      origins.push_back(vertex);
    }
    for (std::size_t m = 0; m < fan.size(); ++m)
      if (name[fan[m]] != vertex) changes.push_back({here[m].tet, vertex, name[fan[m]]});
  }
  // Only now, so that faces were recognised by their old numbers.
  for (const Change& change : changes)
    std::replace(tets[change.tet].begin(), tets[change.tet].end(), change.from, change.to);
  return origins;
}

}  // namespace detail

TopologyEdit separate(const TetMesh& mesh, const VertexTets& around, std::span<const std::array<VertexId, 3>> faces) {
  std::vector<detail::FaceKey> blocked;
  std::vector<TetId> near;
  for (const std::array<VertexId, 3>& face : faces) {
    for (const VertexId v : face) {
      if (v.index() >= mesh.vertex_count())
        throw InputError(
            "separate", "a face names vertex " + std::to_string(v.value) + " of " + std::to_string(mesh.vertex_count()),
            "give faces of this mesh");
      near.insert(near.end(), around.tets.begin() + around.start[v.index()],
                  around.tets.begin() + around.start[v.index() + 1]);
    }
    blocked.push_back(detail::face_key(face[0].value, face[1].value, face[2].value));
  }
  std::sort(blocked.begin(), blocked.end());
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const TetId t : near) {
    const Tet& tet = mesh.tet(t);
    tets.push_back({tet[0].value, tet[1].value, tet[2].value, tet[3].value});
  }
  TopologyEdit edit;
  const auto n = static_cast<std::uint32_t>(mesh.vertex_count());
  for (const std::uint32_t origin : detail::separate_fans(tets, blocked, n))
    edit.vertices.push_back({mesh.positions[origin], VertexId(origin), VertexId(origin), 0});
  for (std::size_t i = 0; i < near.size(); ++i) {
    Tet fresh;
    for (std::size_t c = 0; c < 4; ++c) fresh[c] = VertexId(tets[i][c]);
    if (fresh == mesh.tet(near[i])) continue;
    edit.removed.push_back(near[i]);
    edit.tets.push_back({fresh, near[i]});
  }
  return edit;
}

}  // namespace calot
