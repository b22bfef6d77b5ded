// Triangle surfaces, and the boundary of a tetrahedral mesh.
#pragma once
#include <array>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

using Triangle = std::array<std::uint32_t, 3>;

/// A triangle surface; triangles wind counter-clockwise seen from outside.
struct Surface {
  std::vector<Vec3> positions;           ///< n [m]
  std::vector<Triangle> triangles;       ///< k
  std::vector<std::int32_t> regions;     ///< k, region of each triangle's tet; may be empty where unknown
  std::vector<VertexId> vertex_of_mesh;  ///< n, the mesh's vertex of each surface vertex; empty where there is no mesh
  std::vector<TetId> tet_of_triangle;    ///< k, the tet behind each triangle; empty where there is no mesh
};

/// The faces that one tet only has: the outer boundary, in order of (tet, face).
Surface boundary_surface(const TetMesh& mesh);

/// The boundary of the tets of one region (its outer faces and those it shares with other regions).
Surface region_surface(const TetMesh& mesh, std::int32_t region);

/// Area-weighted unit normals at the surface's vertices (zero where no triangle has area), for `positions` (n).
std::vector<Vec3> vertex_normals(const Surface& surface, const std::vector<Vec3>& positions);

/// Edges that don't have exactly two triangles, and vertices whose triangles don't form one fan.
struct ManifoldReport {
  std::size_t boundary_edges = 0, nonmanifold_edges = 0, nonmanifold_vertices = 0;
  [[nodiscard]] bool closed_manifold() const { return boundary_edges + nonmanifold_edges + nonmanifold_vertices == 0; }
};
ManifoldReport check_manifold(const Surface& surface);

}  // namespace calot
