// Small generated meshes for the tests of every room. All are sound (validate() is empty) and in metres.
#pragma once
#include <functional>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::test {

/// How a cube becomes tets: six around its diagonal, or five (alternating, so that neighbours fit).
enum class CubeSplit { six, five };

/// nx × ny × nz cubes filling [0, size]; region 1 ("box"). Vertex (i, j, k) is number i + (nx+1)(j + (ny+1) k).
TetMesh box_mesh(int nx, int ny, int nz, const Vec3& size, CubeSplit split = CubeSplit::six);

/// As box_mesh, but only the cells where region_of(i, j, k) > 0, with that region; vertices keep their order.
TetMesh cell_mesh(int nx, int ny, int nz, const Vec3& size, const std::function<int(int, int, int)>& region_of,
                  CubeSplit split = CubeSplit::six);

/// A bar along x: cells × 2 × 2 cubes, length × side × side; region 1 ("near") for x < length/2, region 2 ("far")
/// beyond.
TetMesh bar_mesh(int cells, double length = 0.1, double side = 0.02);

/// Something like a biliary tree, wavering and of uneven thickness: regions 2 ("gallbladder"), 3 ("cystic duct"), 4
/// ("common bile duct", a column along z). 208·fineness³ cubes of about 5 mm / fineness: 389 vertices and 1248 tets at
/// fineness 1, 2321 and 9984 at 2 (the size of the paper's mesh). The duct runs along x from x = 10 mm to x = 30 mm;
/// the common bile duct ends at z = 0 and z = 60 mm (about; it wavers by under 1 mm).
TetMesh biliary_mesh(int fineness = 1);

/// One tet with all edges of this length; region 1.
TetMesh regular_tet(double edge = 1.0);

/// Two tets sharing the face 0 1 2; region 1 and 2. Vertices 3 above and 4 below.
TetMesh two_tets();
/// Two tets sharing the edge 0 1 only; regions 1 and 2.
TetMesh two_tets_on_an_edge();
/// Two tets sharing vertex 0 only; regions 1 and 2.
TetMesh two_tets_on_a_vertex();

/// The tets whose centroid satisfies `inside`, ascending.
std::vector<TetId> tets_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& inside);

/// `count` different tets drawn with a fixed generator, ascending; all of them if there are fewer.
std::vector<TetId> random_tets(const TetMesh& mesh, std::size_t count, std::uint64_t seed);

/// A reproducible number in [0, 1): the same on every platform, unlike std::uniform_real_distribution.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  double unit();
  double between(double low, double high) { return low + (high - low) * unit(); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }

 private:
  std::uint64_t state_;
};

}  // namespace calot::test
