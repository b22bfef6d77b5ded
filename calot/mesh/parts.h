// Connected parts. Tets that share only a vertex or an edge are hinged, not joined.
#pragma once
#include <span>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// The tets of a mesh grouped by shared faces. Parts are numbered by their first tet.
struct Parts {
  std::vector<std::uint32_t> of_tet;            ///< m, part of each tet
  std::vector<std::vector<TetId>> tets;         ///< of each part, ascending
  std::vector<std::vector<VertexId>> vertices;  ///< of each part, ascending; a hinge vertex is in several
  [[nodiscard]] std::size_t count() const { return tets.size(); }
};
Parts face_connected_parts(const TetMesh& mesh);

/// Groups of vertices joined through tets in any way (also by a single vertex): the blocks of the stiffness matrix.
/// @return n, group of each vertex, numbered by first vertex; vertices without tets form groups of their own.
std::vector<std::uint32_t> vertex_connected_groups(const TetMesh& mesh);

/// Vertices through which a part hangs on other parts without a shared face.
struct Hinge {
  std::uint32_t part, other;       ///< part < other; each pair once
  std::vector<VertexId> vertices;  ///< ascending
};
std::vector<Hinge> hinges(const TetMesh& mesh, const Parts& parts);

}  // namespace calot
