// The paper's compliance: a full matrix over all vertices, and its Algorithms 1 and 2.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// The whole compliance C [m/N], row-major, 3n×3n over all n vertices; rows and columns of fixed vertices are zero.
struct FullCompliance {
  std::size_t vertices = 0;    ///< n
  std::vector<double> values;  ///< 9n²
  [[nodiscard]] std::size_t size() const { return 3 * vertices; }
  [[nodiscard]] double* row(std::size_t r) { return values.data() + r * size(); }
  [[nodiscard]] const double* row(std::size_t r) const { return values.data() + r * size(); }
};

/// Algorithm 1 of the paper: deletes the rows and columns of vertices, in place; the order of the others stays.
/// @param deleted  vertex numbers, ascending, unique, < n
void paper_delete_vertices(FullCompliance& compliance, std::span<const VertexId> deleted);

/// Algorithm 2 of the paper: sets to zero the 3×3 blocks of vertex pairs in different parts.
/// @param part  n, part of each vertex
void paper_zero_between_parts(FullCompliance& compliance, std::span<const std::uint32_t> part);

/// Both, as after a cut: `orphaned` in numbers before, `mesh` after it; parts are its face-connected parts (a hinge
/// vertex counts to the first part that has it).
void paper_update(FullCompliance& compliance, std::span<const VertexId> orphaned, const TetMesh& mesh);

}  // namespace calot
