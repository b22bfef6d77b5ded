// Generated edits of every kind, for tests that follow a mesh through them. All leave the mesh sound.
#pragma once
#include "calot/mesh/topology_edit.h"
#include "tests/support/meshes.h"

namespace calot::test {

/// Bisects edges: the tets around each become two, with a vertex on the edge at `weight`. Edges whose tets another one
/// has taken are left out.
struct EdgeCut {
  VertexId a, b;
  double weight;
};
TopologyEdit bisect_edges(const TetMesh& mesh, const std::vector<EdgeCut>& edges);

/// The same for up to `count` edges drawn at random.
TopologyEdit random_bisections(const TetMesh& mesh, std::size_t count, std::uint64_t seed);

/// Takes the tets where `above` is true off the others along the faces between them: vertices of those faces get a copy
/// wherever the tets around them fall apart into groups that share no other face. Few faces part nothing but the mesh
/// inside (a slit).
/// @param above  m flags
/// @param cut    whether a face between the two kinds, given by its three vertices, comes apart; all if empty
TopologyEdit separate(const TetMesh& mesh, const std::vector<std::uint8_t>& above,
                      const std::function<bool(const std::array<VertexId, 3>&)>& cut = {});

/// Moves up to `count` vertices a little along an edge, where no tet turns inside out.
TopologyEdit random_moves(const TetMesh& mesh, std::size_t count, std::uint64_t seed);

/// One of the above, or a removal, drawn at random; about `count` of its kind.
TopologyEdit random_edit(const TetMesh& mesh, std::size_t count, std::uint64_t seed);

}  // namespace calot::test
