// Parting a mesh along faces: a cut without loss, and a tear.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "calot/mesh/topology_edit.h"

namespace calot {

/// Separates along faces. Each of their vertices is doubled, or more, so that every fan of tets that stay joined
/// through faces around it has one of its own; the largest fan keeps the old vertex. Where the tets around a vertex
/// stay joined past the faces, as at a crack's front, it stays single, so faces inside the tissue alone change nothing.
/// @param faces  vertices of each face in any order; faces on the boundary, or that no tet has, are passed over
/// @return tets are renumbered only: each added one stands for the removed one that is its parent
/// Throws InputError for a vertex that doesn't exist.
TopologyEdit separate(const TetMesh& mesh, const VertexTets& around, std::span<const std::array<VertexId, 3>> faces);

namespace detail {

using FaceKey = std::array<std::uint32_t, 3>;  ///< vertex numbers, ascending
FaceKey face_key(std::uint32_t a, std::uint32_t b, std::uint32_t c);

/// The same on bare numbers, for a patch of tets.
/// @param tets       corners; copies are written into it
/// @param blocked    faces to separate along, ascending
/// @param next_copy  the number of the first copy
/// @return what each copy is a copy of, in order of their numbers
/// The tets must hold all those around the blocked faces' vertices.
std::vector<std::uint32_t> separate_fans(std::vector<std::array<std::uint32_t, 4>>& tets,
                                         const std::vector<FaceKey>& blocked, std::uint32_t next_copy);

}  // namespace detail
}  // namespace calot
