// Inside this room only: the tets around a sweep, numbered for themselves, so that a split costs what it touches.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "calot/cut/swept_plane.h"

namespace calot::detail {

/// Rows of numbers: row i is items[start[i]] … items[start[i + 1] − 1].
struct Rows {
  std::vector<std::uint32_t> start, items;
  [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t i) const {
    return {items.data() + start[i], start[i + 1] - start[i]};
  }
};

/// An edge that the blade crossed.
struct CrossedEdge {
  std::uint32_t a, b;  ///< patch vertices, strictly on different sides
  double share;        ///< where on the way from a to b
};

struct SplitPatch {
  static constexpr std::uint32_t none = 0xffffffffu;

  std::vector<VertexId> vertex;  ///< of the mesh, in order; the first `core` have all their tets in the patch
  std::size_t core = 0;
  std::vector<Vec3> rest, now;           ///< [m]
  std::vector<double> height;            ///< over the blade's plane in `now` [m]
  std::vector<std::int8_t> side;         ///< of the plane; 0 also where rounding could decide
  std::vector<std::uint8_t> front, lip;  ///< as in the stroke so far
  std::vector<std::uint8_t> fixed;

  std::vector<TetId> tet;  ///< of the mesh, ascending
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::int32_t> region;
  std::vector<std::uint8_t> allowed;  ///< in the region that is cut
  Rows star;                          ///< tets of each vertex

  std::vector<CrossedEdge> edges;
  std::vector<std::array<std::uint32_t, 6>> edges_of_tet;  ///< as edge_corners; `none` where not crossed
  Rows ring, edges_of_vertex;                              ///< tets of each edge; crossed edges of each vertex
  bool deformed = false;                                   ///< `now` differs from `rest`
  double smallest_region = 0;                              ///< volume [m³]
  double most_flatness = 0;                                ///< as asked
  double flatness = 0;  ///< how far off the plane the cut may lie: as asked, but little beside the edges [m]
};

/// The tets that the sweep comes near, and all those around their vertices. No tets if it misses the region.
SplitPatch gather_patch(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current,
                        const SweptPlane& blade, const SplitOptions& options);

}  // namespace calot::detail
