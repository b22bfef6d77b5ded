// Inside this room only: the tet on the other side of a face, without sorting all faces of the mesh.
#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// Corners of face f of a tet, counter-clockwise seen from outside; face f lies opposite corner f.
inline constexpr std::array<std::array<std::size_t, 3>, 4> tet_face_corners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

inline std::array<VertexId, 3> face_of(const Tet& tet, std::size_t f) {
  const auto& c = tet_face_corners[f];
  return {tet[c[0]], tet[c[1]], tet[c[2]]};
}

inline bool has(const Tet& tet, VertexId v) {
  return tet[0] == v || tet[1] == v || tet[2] == v || tet[3] == v;
}

/// The tet that shares face f of `tet`; none() on the boundary.
inline TetId across(const TetMesh& mesh, const VertexTets& around, TetId tet, std::size_t f) {
  const std::array<VertexId, 3> face = face_of(mesh.tet(tet), f);
  const std::size_t begin = around.start[face[0].index()], end = around.start[face[0].index() + 1];
  for (std::size_t k = begin; k < end; ++k) {
    const TetId other = around.tets[k];
    if (other != tet && has(mesh.tet(other), face[1]) && has(mesh.tet(other), face[2])) return other;
  }
  return TetId::none();
}

/// Bytes of plain values, for hashing a state.
template <class T>
void append_bytes(std::string& bytes, const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}
template <class T>
void append_bytes(std::string& bytes, const T& value) {
  static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace calot::detail
