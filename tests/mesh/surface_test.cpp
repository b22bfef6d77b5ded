// Boundaries, normals, manifoldness.
#include "calot/mesh/surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "calot/mesh/quality.h"
#include "calot/mesh/topology_edit.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

/// Volume inside a closed surface, by the divergence theorem; positive when it winds outwards.
double enclosed_volume(const Surface& surface) {
  double sum = 0;
  for (const Triangle& t : surface.triangles)
    sum += surface.positions[t[0]].dot(surface.positions[t[1]].cross(surface.positions[t[2]])) / 6;
  return sum;
}

TEST(SurfaceOfMesh, ClosedOutwardManifold) {
  const std::vector<TetMesh> meshes{box_mesh(3, 4, 5, {1, 2, 3}),
                                    box_mesh(3, 4, 5, {1, 2, 3}, CubeSplit::five),
                                    bar_mesh(7),
                                    biliary_mesh(1),
                                    biliary_mesh(2),
                                    regular_tet(),
                                    two_tets()};
  for (const TetMesh& mesh : meshes) {
    const Surface surface = boundary_surface(mesh);
    EXPECT_TRUE(check_manifold(surface).closed_manifold());
    const double volume = quality(mesh).volume;
    EXPECT_NEAR(enclosed_volume(surface), volume, 1e-12 * volume);
    // Euler: V − E + F = 2 with E = 3F/2.
    EXPECT_EQ(2 * surface.positions.size(), surface.triangles.size() + 4);
  }
}

TEST(SurfaceOfMesh, SaysWhereItComesFrom) {
  const TetMesh mesh = biliary_mesh();
  const Surface surface = boundary_surface(mesh);
  ASSERT_EQ(surface.tet_of_triangle.size(), surface.triangles.size());
  ASSERT_EQ(surface.regions.size(), surface.triangles.size());
  EXPECT_TRUE(std::is_sorted(surface.tet_of_triangle.begin(), surface.tet_of_triangle.end()));
  EXPECT_TRUE(std::is_sorted(surface.vertex_of_mesh.begin(), surface.vertex_of_mesh.end()));
  for (std::size_t k = 0; k < surface.triangles.size(); ++k) {
    const Tet& tet = mesh.tet(surface.tet_of_triangle[k]);
    EXPECT_EQ(surface.regions[k], mesh.regions[surface.tet_of_triangle[k].index()]);
    for (const std::uint32_t v : surface.triangles[k])
      EXPECT_NE(std::find(tet.begin(), tet.end(), surface.vertex_of_mesh[v]), tet.end());
  }
  for (std::size_t v = 0; v < surface.positions.size(); ++v)
    EXPECT_EQ(surface.positions[v], mesh.position(surface.vertex_of_mesh[v]));
}

TEST(SurfaceOfMesh, RegionSurfacesCloseAndAddUp) {
  const TetMesh mesh = biliary_mesh();
  double sum = 0;
  for (const std::int32_t region : {2, 3, 4}) {
    const Surface surface = region_surface(mesh, region);
    EXPECT_TRUE(check_manifold(surface).closed_manifold());
    EXPECT_NEAR(enclosed_volume(surface), quality(mesh, region).volume, 1e-15);
    sum += enclosed_volume(surface);
  }
  EXPECT_NEAR(sum, quality(mesh).volume, 1e-15);
  EXPECT_TRUE(region_surface(mesh, 99).triangles.empty());
}

TEST(SurfaceOfMesh, HingesAreNotManifold) {
  const ManifoldReport edge = check_manifold(boundary_surface(two_tets_on_an_edge()));
  EXPECT_EQ(edge.nonmanifold_edges, 1u);
  EXPECT_EQ(edge.boundary_edges, 0u);
  const ManifoldReport vertex = check_manifold(boundary_surface(two_tets_on_a_vertex()));
  EXPECT_EQ(vertex.nonmanifold_edges, 0u);
  EXPECT_EQ(vertex.nonmanifold_vertices, 1u);
}

TEST(Manifold, AnOpenSheetHasABoundary) {
  Surface sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const ManifoldReport report = check_manifold(sheet);
  EXPECT_EQ(report.boundary_edges, 4u);
  EXPECT_EQ(report.nonmanifold_edges, 0u);
  EXPECT_EQ(report.nonmanifold_vertices, 0u);
  EXPECT_FALSE(report.closed_manifold());
}

TEST(Normals, PointOutwardsAndHaveLengthOne) {
  const TetMesh mesh = box_mesh(4, 4, 4, {2, 2, 2});
  Surface surface = boundary_surface(mesh);
  surface.positions.emplace_back(7, 7, 7);  // a vertex without triangles
  const std::vector<Vec3> normals = vertex_normals(surface, surface.positions);
  for (std::size_t v = 0; v + 1 < normals.size(); ++v) {
    EXPECT_NEAR(normals[v].norm(), 1, 1e-14);
    EXPECT_GT(normals[v].dot(surface.positions[v] - Vec3(1, 1, 1)), 0);
  }
  EXPECT_EQ(normals.back(), Vec3(0, 0, 0));
  const VertexId face_centre(2 + 5 * 2);  // (2, 2, 0): on the bottom
  const auto at = std::find(surface.vertex_of_mesh.begin(), surface.vertex_of_mesh.end(), face_centre);
  EXPECT_NEAR((normals[std::size_t(at - surface.vertex_of_mesh.begin())] - Vec3(0, 0, -1)).norm(), 0, 1e-15);
}

TEST(SurfaceOfMesh, AfterACutItStillCloses) {
  TetMesh mesh = biliary_mesh(2);
  apply(mesh, {tets_where(mesh, [](const Vec3& p) { return p.x() > 0.017 && p.x() < 0.02; }), {}, {}});
  EXPECT_EQ(check_manifold(boundary_surface(mesh)).boundary_edges, 0u);
}

}  // namespace
