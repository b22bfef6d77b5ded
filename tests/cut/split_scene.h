// Meshes to cut, and what must hold after every split.
#pragma once
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "calot/cut/split.h"
#include "calot/mesh/improve.h"
#include "calot/mesh/quality.h"
#include "tests/support/meshes.h"

namespace calot::test {

inline Vec3 random_direction(Random& random) {
  for (;;) {
    const Vec3 v(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}

/// A box whose inner vertices are shaken, then improved: no two tets alike, dihedrals ≥ 12°.
inline TetMesh shaken_box(int nx, int ny, int nz, const Vec3& size, std::uint64_t seed) {
  TetMesh mesh = box_mesh(nx, ny, nz, size, CubeSplit::five);
  Random random(seed);
  for (Vec3& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) {
      const double shift = 0.22 * size.x() / nx * random.between(-1, 1);
      if (p[axis] > 1e-9 && p[axis] < size[axis] - 1e-9) p[axis] += shift;
    }
  improve(mesh, {});
  return mesh;
}

/// A round bar along x like a duct: regions 1 ("near") and 2 ("far") meet in the middle.
inline TetMesh round_bar(int cells, int across, double length, double radius, bool two_regions = false) {
  TetMesh mesh = cell_mesh(
      cells, across, across, {length, 2, 2}, [&](int i, int, int) { return two_regions && 2 * i >= cells ? 2 : 1; },
      CubeSplit::five);
  mesh.region_names = {{1, "near"}};
  if (two_regions) mesh.region_names[2] = "far";
  for (Vec3& p : mesh.positions) {  // square → disc
    const double y = p.y() - 1, z = p.z() - 1;
    p.y() = radius * y * std::sqrt(1 - z * z / 2);
    p.z() = radius * z * std::sqrt(1 - y * y / 2);
  }
  improve(mesh, {});
  return mesh;
}

inline std::map<std::int32_t, double> region_volumes(const TetMesh& mesh) {
  std::map<std::int32_t, double> volumes;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) volumes[mesh.regions[t]] += signed_volume(mesh, TetId(t));
  return volumes;
}

/// A mesh that is cut step by step, with where its vertices are now.
struct CutScene {
  TetMesh mesh;
  std::vector<Vec3> now;
  Stroke stroke;
  std::map<std::int32_t, double> volumes;
  double smallest = 180, farthest = 0;
  std::size_t separated = 0;

  explicit CutScene(TetMesh m) : mesh(std::move(m)), now(mesh.positions), volumes(region_volumes(mesh)) {}
  void deform(const std::function<Vec3(const Vec3&)>& map) {
    for (std::size_t v = 0; v < now.size(); ++v) now[v] = map(mesh.positions[v]);
  }
  SplitReport cut(const Sweep& sweep, SplitOptions options = {}) {
    options.stroke = &stroke;
    const SplitEdit edit = split(mesh, vertex_tets(mesh), now, sweep, options);
    take(edit);
    stroke = follow(edit.report.stroke, last);
    return edit.report;
  }
  SplitReport cut(const Blade& blade, const SplitOptions& options = {}) {
    const SplitEdit edit = split(mesh, blade, options);
    take(edit);
    return edit.report;
  }
  /// Applies the edit and checks what must always hold.
  void take(const SplitEdit& edit) {
    const std::vector<Vec3> before = now;
    const std::size_t tets_before = mesh.tet_count();
    const double left = edit.report.volume_change;
    const double volume_before = total();
    last = apply(mesh, edit);
    now.assign(mesh.vertex_count(), Vec3::Zero());
    for (std::size_t v = 0; v < now.size(); ++v)
      if (last.vertex_to_old[v].valid()) now[v] = before[last.vertex_to_old[v].index()];
    const auto between = [&](VertexId a, VertexId b, double w) {
      return Vec3(before[a.index()] + w * (before[b.index()] - before[a.index()]));
    };
    for (const MovedVertex& m : edit.moved)
      now[last.vertex_to_new[m.vertex.index()].index()] = between(m.vertex, m.to, m.weight);
    for (std::size_t k = 0; k < edit.vertices.size(); ++k)
      now[last.added_vertices[k].index()] =
          between(edit.vertices[k].from, edit.vertices[k].to, edit.vertices[k].weight);
    const MeshProblems problems = validate(mesh);
    EXPECT_FALSE(problems.fatal()) << problems.describe();
    EXPECT_TRUE(problems.unused.empty());
    EXPECT_EQ(mesh.tet_count(), tets_before - edit.removed.size() + edit.tets.size());
    EXPECT_NEAR(total() - volume_before, left, 1e-12 * volume_before);
    for (const auto& [region, volume] : region_volumes(mesh)) EXPECT_NEAR(volume / volumes[region], 1, 1e-3);
    smallest = std::min(smallest, edit.report.angle_after);
    farthest = std::max(farthest, edit.report.largest_distance);
    separated += edit.report.separated;
  }
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const auto& [region, volume] : region_volumes(mesh)) sum += volume;
    return sum;
  }
  Remap last;
};

/// The patch that an edge sweeps from (a, b) to (c, d).
inline Sweep strip(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {{{a, b, d}, {a, d, c}}};
}

}  // namespace calot::test
