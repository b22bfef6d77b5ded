// The one mesh that everything shares, and the one way to change it.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "calot/base/ids.h"

namespace calot {

using Vec3 = Eigen::Vector3d;
using Tet = std::array<VertexId, 4>;

/// A tetrahedral mesh with a region number on every tetrahedron. A plain value; copy it freely.
struct TetMesh {
  std::vector<Vec3> positions;                       ///< n, rest positions [m]
  std::vector<Tet> tets;                             ///< m, positively oriented: det(b−a, c−a, d−a) > 0
  std::vector<std::int32_t> regions;                 ///< m, region of each tet
  std::map<std::int32_t, std::string> region_names;  ///< names of regions, where known

  [[nodiscard]] std::size_t vertex_count() const { return positions.size(); }
  [[nodiscard]] std::size_t tet_count() const { return tets.size(); }
  [[nodiscard]] const Vec3& position(VertexId v) const { return positions[v.index()]; }
  [[nodiscard]] const Tet& tet(TetId t) const { return tets[t.index()]; }
};

/// Signed volume [m³] of a tet; positive when (b−a, c−a, d−a) is right-handed.
double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
double signed_volume(const TetMesh& mesh, TetId tet);

/// The regions a name or number stands for: "*" is all, "3" a number, anything else a name (exact match). Throws
/// InputError, listing the mesh's regions, when there is none.
std::vector<std::int32_t> regions_matching(const TetMesh& mesh, const std::string& name, const std::string& where);

/// For each vertex, the tets that use it, ascending. Compressed rows: of vertex v, tets[start[v]] … tets[start[v+1]−1].
struct VertexTets {
  std::vector<std::uint32_t> start;  ///< n + 1
  std::vector<TetId> tets;           ///< 4m
};
VertexTets vertex_tets(const TetMesh& mesh);

}  // namespace calot
