#include "calot/mesh/tet_faces.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace calot::detail {
namespace {

bool in_range(const Tet& tet, std::size_t n) {
  return std::all_of(tet.begin(), tet.end(), [n](VertexId v) { return v.index() < n; });
}

TetFace face_of(const Tet& tet, std::uint32_t t, std::uint32_t f) {
  const auto& c = face_corners[f];
  TetFace face{{tet[c[0]].value, tet[c[1]].value, tet[c[2]].value}, t, f};
  std::sort(face.key.begin(), face.key.end());
  return face;
}

}  // namespace

// Buckets by the smallest vertex first: a bucket holds about 16 faces, so this runs several times faster than one
// big sort, and it is on the way of every cut (the support test needs the parts).
std::vector<TetFace> sorted_faces(const TetMesh& mesh) {
  const std::size_t n = mesh.vertex_count();
  std::vector<std::uint32_t> start(n + 1, 0);
  const auto for_each_face = [&](const auto& body) {
    for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) {
      if (!in_range(mesh.tets[t], n)) continue;
      for (std::uint32_t f = 0; f < 4; ++f) body(face_of(mesh.tets[t], t, f));
    }
  };
  for_each_face([&](const TetFace& face) { ++start[face.key[0] + 1]; });
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<TetFace> faces(start[n]);
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for_each_face([&](const TetFace& face) { faces[next[face.key[0]]++] = face; });
  for (std::size_t v = 0; v < n; ++v)
    std::sort(faces.begin() + start[v], faces.begin() + start[v + 1], [](const TetFace& a, const TetFace& b) {
      return std::tie(a.key, a.tet, a.face) < std::tie(b.key, b.tet, b.face);
    });
  return faces;
}

DisjointSets::DisjointSets(std::size_t n) : parent_(n) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

std::uint32_t DisjointSets::find(std::uint32_t i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void DisjointSets::join(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

}  // namespace calot::detail
