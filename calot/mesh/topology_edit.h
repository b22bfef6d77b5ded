// A cut, a burn and a tear are the same thing: a TopologyEdit on one TetMesh.
#pragma once
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// A vertex that an edit adds: a copy of, or a point between, two vertices of the mesh before the edit.
struct AddedVertex {
  Vec3 position;      ///< rest position [m]
  VertexId from, to;  ///< the old vertices it lies between (equal: a copy, as at a split)
  double weight = 0;  ///< 0 at `from`, 1 at `to`; interpolates fixed flags, velocities, texture …
};

/// A tet that an edit adds. Vertices below the old vertex count are old vertices; n + k is the k-th added vertex.
struct AddedTet {
  Tet vertices;
  TetId parent;  ///< the removed old tet it is a piece of; gives region and material
};

/// A vertex whose rest position slides along an edge of the mesh, as when it snaps onto a blade. The tets around it
/// stay, in a new shape.
struct MovedVertex {
  VertexId vertex;    ///< old id
  VertexId to;        ///< the other end of the edge, old id
  double weight = 0;  ///< how far along the edge, 0 … 1; carries velocities, temperatures … along
  Vec3 position;      ///< new rest position [m]
};

/// What to change, in numbers of the mesh before the edit.
struct TopologyEdit {
  std::vector<TetId> removed;  ///< ascending, unique
  std::vector<AddedVertex> vertices;
  std::vector<AddedTet> tets;
  std::vector<MovedVertex> moved = {};  ///< ascending by vertex, unique
  [[nodiscard]] bool empty() const { return removed.empty() && vertices.empty() && tets.empty() && moved.empty(); }
};

/// What an edit did: how old numbers map to new ones. Survivors keep their order; added ones follow them.
struct Remap {
  std::vector<VertexId> vertex_to_new;  ///< old n; none() where the vertex lost its last tet
  std::vector<TetId> tet_to_new;        ///< old m; none() where the tet was removed
  std::vector<VertexId> vertex_to_old;  ///< new n; none() for added vertices
  std::vector<TetId> tet_to_old;        ///< new m; for an added tet none()
  std::vector<VertexId> orphaned;       ///< old ids of vertices that lost their last tet, ascending
  std::vector<VertexId> touched;        ///< old ids of surviving vertices of removed, added or reshaped tets, ascending
  std::vector<VertexId> added_vertices;  ///< new ids
  std::vector<TetId> added_tets;         ///< new ids
  std::vector<AddedVertex> added_from;   ///< where each of `added_vertices` comes from, old ids
  std::vector<TetId> added_parents;      ///< what each of `added_tets` is a piece of, old ids
  std::vector<MovedVertex> moved;        ///< as in the edit, old ids
  std::vector<TetId> reshaped;           ///< old ids of tets that stay and have a moved vertex, ascending
};

/// Applies an edit: removes tets, adds vertices and tets, moves vertices, drops vertices that no tet uses any more, and
/// renumbers. Vertices that no tet used before the edit are dropped as orphans too. Throws InputError, and leaves the
/// mesh as it was, for ids out of range, `removed` or `moved` not ascending, an added tet whose parent is not removed,
/// an added vertex that no added tet uses, a moved vertex that does not survive or shares no tet with the one it moves
/// to, a weight outside [0, 1], a position that is not finite, and an added or reshaped tet that is inverted or flat
/// (volume ≤ 1e-14 of its longest edge cubed).
Remap apply(TetMesh& mesh, const TopologyEdit& edit);

/// The tets that an edit would leave in place but give a new shape, ascending; without applying it.
std::vector<TetId> reshaped_tets(const TetMesh& mesh, const TopologyEdit& edit);

/// The vertices that an edit would orphan and touch, without applying it (old ids, ascending).
struct EditExtent {
  std::vector<VertexId> orphaned, touched;
};
EditExtent extent_of(const TetMesh& mesh, const TopologyEdit& edit);

}  // namespace calot
