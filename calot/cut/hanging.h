// Inside this room only: crumbs that a cut leaves hanging.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calot/mesh/topology_edit.h"

namespace calot::detail {

/// The tets that removing `removed` (ascending) leaves hanging, in numbers of the mesh before, ascending. They are
/// whole face-connected pieces, each of which
///  - was broken off by this removal and is not the largest piece of what it was broken off,
///  - and is a single tet, or a crumb that only vertices or edges hold: every tet of it borders the removed ones, and a
///    larger piece lies on the same side of every blade.
/// @param side_of_vertex  for each blade, the side (−1, 0, 1) of each vertex
std::vector<std::vector<TetId>> hanging_pieces(const TetMesh& mesh, const std::vector<TetId>& removed,
                                               const std::vector<std::vector<std::int8_t>>& side_of_vertex);

/// A sentence on the pieces that stay hinged on each other by a vertex or an edge after `removed` are gone; empty when
/// none.
std::string describe_hinges(const TetMesh& mesh, const std::vector<TetId>& removed);

}  // namespace calot::detail
