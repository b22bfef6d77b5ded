#include "tests/support/meshes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::test {
namespace {

// Corners of a cube: bit 0 is x, bit 1 is y, bit 2 is z.
constexpr std::array<std::array<int, 4>, 6> six_tets{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
constexpr std::array<std::array<int, 4>, 5> five_tets{
    {{0, 1, 2, 4}, {1, 3, 2, 7}, {1, 4, 5, 7}, {2, 6, 4, 7}, {1, 2, 4, 7}}};

/// Drops vertices that no tet uses.
TetMesh compact(TetMesh mesh) {
  std::vector<VertexId> number(mesh.vertex_count());
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet) number[v.index()] = VertexId(0);
  std::vector<Vec3> positions;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (!number[v].valid()) continue;
    number[v] = VertexId(positions.size());
    positions.push_back(mesh.positions[v]);
  }
  for (Tet& tet : mesh.tets)
    for (VertexId& v : tet) v = number[v.index()];
  mesh.positions = std::move(positions);
  return mesh;
}

void add_tet(TetMesh& mesh, const std::array<VertexId, 8>& cube, const std::array<int, 4>& corners, bool mirrored,
             int region) {
  // A mirrored cube turns each tet inside out; exchanging two corners turns it back.
  const int flip = mirrored ? 1 : 0;
  Tet tet{cube[corners[0] ^ flip], cube[corners[1] ^ flip], cube[corners[2] ^ flip], cube[corners[3] ^ flip]};
  if (mirrored) std::swap(tet[2], tet[3]);
  mesh.tets.push_back(tet);
  mesh.regions.push_back(region);
}

TetMesh tets_of(std::vector<Vec3> positions, std::vector<Tet> tets) {
  TetMesh mesh;
  mesh.positions = std::move(positions);
  mesh.tets = std::move(tets);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.regions.push_back(static_cast<std::int32_t>(t + 1));
  return mesh;
}

Tet tet(int a, int b, int c, int d) {
  return {VertexId(a), VertexId(b), VertexId(c), VertexId(d)};
}

}  // namespace

TetMesh cell_mesh(int nx, int ny, int nz, const Vec3& size, const std::function<int(int, int, int)>& region_of,
                  CubeSplit split) {
  TetMesh mesh;
  const auto number = [&](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.positions.emplace_back(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int region = region_of(i, j, k);
        if (region <= 0) continue;
        std::array<VertexId, 8> cube;
        for (int c = 0; c < 8; ++c) cube[c] = VertexId(number(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
        if (split == CubeSplit::six)
          for (const auto& corners : six_tets) add_tet(mesh, cube, corners, false, region);
        else
          for (const auto& corners : five_tets) add_tet(mesh, cube, corners, (i + j + k) % 2 == 1, region);
      }
  return compact(std::move(mesh));
}

TetMesh box_mesh(int nx, int ny, int nz, const Vec3& size, CubeSplit split) {
  TetMesh mesh = cell_mesh(
      nx, ny, nz, size, [](int, int, int) { return 1; }, split);
  mesh.region_names = {{1, "box"}};
  return mesh;
}

TetMesh bar_mesh(int cells, double length, double side) {
  TetMesh mesh = cell_mesh(cells, 2, 2, {length, side, side}, [&](int i, int, int) { return 2 * i < cells ? 1 : 2; });
  mesh.region_names = {{1, "near"}, {2, "far"}};
  return mesh;
}

TetMesh biliary_mesh(int fineness) {
  const int f = fineness;
  const auto within = [](int value, int low, int high) { return low <= value && value < high; };
  // Cells of 5 mm / f: the common bile duct fills x 0 … 2, y 2 … 4, all z; the cystic duct x 2 … 6, y 2 … 4, z 5 … 7;
  // the gallbladder x 6 … 10, y 0 … 6, z 3 … 9.
  const auto region_of = [&](int i, int j, int k) {
    if (i < 2 * f) return within(j, 2 * f, 4 * f) ? 4 : 0;
    if (i < 6 * f) return within(j, 2 * f, 4 * f) && within(k, 5 * f, 7 * f) ? 3 : 0;
    return within(k, 3 * f, 9 * f) ? 2 : 0;
  };
  TetMesh mesh = cell_mesh(10 * f, 6 * f, 12 * f, {0.05, 0.03, 0.06}, region_of);
  mesh.region_names = {{2, "gallbladder"}, {3, "cystic duct"}, {4, "common bile duct"}};
  for (Vec3& p : mesh.positions) {
    // The bulk of the gallbladder swells and rises; the ducts waver, so that no two cells are the same.
    const double along = std::clamp((p.x() - 0.03) / 0.02, 0.0, 1.0), from_axis_y = p.y() - 0.015,
                 from_axis_z = p.z() - 0.03;
    const double swell = 1 + 0.25 * std::sin(std::numbers::pi * along) * along;
    p.y() = 0.015 + swell * from_axis_y + 0.0008 * std::sin(180 * p.x() + 40 * p.z());
    p.z() = 0.03 + swell * from_axis_z + 0.010 * along * along + 0.0006 * std::sin(200 * p.x());
  }
  return mesh;
}

TetMesh regular_tet(double edge) {
  const double h = edge / (2 * std::numbers::sqrt2);  // half the edge of the cube around it
  TetMesh mesh = tets_of({{h, h, h}, {-h, h, -h}, {h, -h, -h}, {-h, -h, h}}, {tet(0, 1, 2, 3)});
  if (signed_volume(mesh, TetId(0)) < 0) std::swap(mesh.tets[0][2], mesh.tets[0][3]);
  return mesh;
}

TetMesh two_tets() {
  return tets_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 1}, {0.25, 0.25, -1}},
                 {tet(0, 1, 2, 3), tet(0, 2, 1, 4)});
}

TetMesh two_tets_on_an_edge() {
  return tets_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                 {tet(0, 1, 2, 3), tet(0, 1, 4, 5)});
}

TetMesh two_tets_on_a_vertex() {
  return tets_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                 {tet(0, 1, 2, 3), tet(0, 5, 4, 6)});
}

std::vector<TetId> tets_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& inside) {
  std::vector<TetId> found;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Vec3 sum = Vec3::Zero();
    for (const VertexId v : mesh.tets[t]) sum += mesh.position(v);
    if (inside(sum / 4)) found.emplace_back(t);
  }
  return found;
}

std::vector<TetId> random_tets(const TetMesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<TetId> all(mesh.tet_count());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = TetId(t);
  Random random(seed);
  count = std::min(count, all.size());
  for (std::size_t i = 0; i < count; ++i) std::swap(all[i], all[i + random.below(all.size() - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

// SplitMix64 [Steele2014]: three lines, good enough for tests.
std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::unit() {
  return static_cast<double>(next() >> 11) * 0x1.0p-53;
}

}  // namespace calot::test
