// Inside this room only: the faces of a mesh in an order that brings shared ones together.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// Corners of face f of a tet, counter-clockwise seen from outside; face f lies opposite corner f.
inline constexpr std::array<std::array<int, 3>, 4> face_corners{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
/// Corners of the six edges of a tet.
inline constexpr std::array<std::array<int, 2>, 6> edge_corners{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// A face of a tet, keyed by its vertex numbers in ascending order.
struct TetFace {
  std::array<std::uint32_t, 3> key;
  std::uint32_t tet;
  std::uint32_t face;
};

/// All faces of the tets whose vertex numbers are in range, sorted by (key, tet, face).
std::vector<TetFace> sorted_faces(const TetMesh& mesh);

/// Disjoint sets over 0 … n − 1; the representative is always the smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n);
  std::uint32_t find(std::uint32_t i);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace calot::detail
