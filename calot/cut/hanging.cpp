#include "calot/cut/hanging.h"

#include <algorithm>
#include <map>
#include <utility>

#include "calot/mesh/parts.h"

namespace calot::detail {
namespace {

/// The mesh without the removed tets; vertices keep their numbers, `number` gives each kept tet's old one.
struct Kept {
  TetMesh mesh;
  std::vector<TetId> number;
  Parts parts;
};

Kept without(const TetMesh& mesh, const std::vector<TetId>& removed) {
  Kept kept;
  kept.mesh.positions = mesh.positions;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (std::binary_search(removed.begin(), removed.end(), TetId(t))) continue;
    kept.mesh.tets.push_back(mesh.tets[t]);
    kept.mesh.regions.push_back(mesh.regions[t]);
    kept.number.emplace_back(t);
  }
  kept.parts = face_connected_parts(kept.mesh);
  return kept;
}

std::vector<std::uint8_t> vertices_of(const TetMesh& mesh, const std::vector<TetId>& tets) {
  std::vector<std::uint8_t> used(mesh.vertex_count(), 0);
  for (const TetId t : tets)
    for (const VertexId v : mesh.tet(t)) used[v.index()] = 1;
  return used;
}

/// Where a piece comes from and lies; pieces of one place compete for being its main one.
using Place = std::pair<std::uint32_t, std::vector<std::int8_t>>;

/// For each blade, the side that all vertices of the piece are on, or 2 where they are on both.
std::vector<std::int8_t> sides_of(const std::vector<VertexId>& vertices,
                                  const std::vector<std::vector<std::int8_t>>& side_of_vertex) {
  std::vector<std::int8_t> sides;
  for (const auto& of_blade : side_of_vertex) {
    std::int8_t side = 0;
    for (const VertexId v : vertices) {
      const std::int8_t here = of_blade[v.index()];
      if (here == 0 || here == side) continue;
      side = side == 0 ? here : std::int8_t{2};
    }
    sides.push_back(side);
  }
  return sides;
}

/// The piece with the most tets for each key; the first of equals.
template <class Key>
std::map<Key, std::uint32_t> largest_by(const Parts& pieces, const std::vector<Key>& keys) {
  std::map<Key, std::uint32_t> largest;
  for (std::uint32_t p = 0; p < pieces.count(); ++p) {
    const auto [entry, is_new] = largest.try_emplace(keys[p], p);
    if (!is_new && pieces.tets[p].size() > pieces.tets[entry->second].size()) entry->second = p;
  }
  return largest;
}

bool all_border(const Kept& kept, const std::vector<TetId>& tets, const std::vector<std::uint8_t>& at_the_cut) {
  return std::all_of(tets.begin(), tets.end(), [&](TetId t) {
    const Tet& tet = kept.mesh.tet(t);
    return std::any_of(tet.begin(), tet.end(), [&](VertexId v) { return at_the_cut[v.index()] != 0; });
  });
}

std::vector<std::uint8_t> hinged_pieces(const Kept& kept) {
  std::vector<std::uint8_t> hinged(kept.parts.count(), 0);
  for (const Hinge& hinge : hinges(kept.mesh, kept.parts)) hinged[hinge.part] = hinged[hinge.other] = 1;
  return hinged;
}

}  // namespace

std::vector<std::vector<TetId>> hanging_pieces(const TetMesh& mesh, const std::vector<TetId>& removed,
                                               const std::vector<std::vector<std::int8_t>>& side_of_vertex) {
  const Parts before = face_connected_parts(mesh);
  const Kept kept = without(mesh, removed);
  const Parts& pieces = kept.parts;
  std::vector<std::uint32_t> origins;
  std::vector<Place> places;
  for (std::size_t p = 0; p < pieces.count(); ++p) {
    origins.push_back(before.of_tet[kept.number[pieces.tets[p].front().index()].index()]);
    places.emplace_back(origins.back(), sides_of(pieces.vertices[p], side_of_vertex));
  }
  const auto largest_of_origin = largest_by(pieces, origins);
  const auto largest_of_place = largest_by(pieces, places);
  const std::vector<std::uint8_t> hinged = hinged_pieces(kept), at_the_cut = vertices_of(mesh, removed);
  std::vector<std::vector<TetId>> hanging;
  for (std::uint32_t p = 0; p < pieces.count(); ++p) {
    const std::vector<TetId>& tets = pieces.tets[p];
    if (largest_of_origin.at(origins[p]) == p || tets.size() == before.tets[origins[p]].size()) continue;
    const bool crumb = hinged[p] != 0 && largest_of_place.at(places[p]) != p && all_border(kept, tets, at_the_cut);
    if (tets.size() > 1 && !crumb) continue;
    hanging.emplace_back();
    for (const TetId t : tets) hanging.back().push_back(kept.number[t.index()]);
  }
  return hanging;
}

std::string describe_hinges(const TetMesh& mesh, const std::vector<TetId>& removed) {
  const Kept kept = without(mesh, removed);
  const std::vector<std::uint8_t> before = hinged_pieces(without(mesh, {}));
  const std::vector<Hinge> found = hinges(kept.mesh, kept.parts);
  if (found.empty() || std::any_of(before.begin(), before.end(), [](std::uint8_t h) { return h != 0; })) return {};
  constexpr std::size_t shown = 5;
  std::vector<VertexId> vertices;
  for (const Hinge& hinge : found) vertices.insert(vertices.end(), hinge.vertices.begin(), hinge.vertices.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::string text = "parts stay hinged on each other, without a shared face, at " + std::to_string(vertices.size()) +
                     (vertices.size() == 1 ? " vertex (" : " vertices (");
  for (std::size_t i = 0; i < std::min(shown, vertices.size()); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(vertices[i].value);
  return text + (vertices.size() > shown ? ", …)" : ")");
}

}  // namespace calot::detail
