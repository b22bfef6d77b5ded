// Repairs of fresh meshes, on meshes made wrong by hand.
#include <gtest/gtest.h>

#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
#include "calot/patient/mesh_repair.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

TEST(MeshRepair, leaves_a_sound_mesh_alone) {
  TetMesh mesh = test::bar_mesh(6);
  const std::size_t tets = mesh.tet_count();
  EXPECT_TRUE(repair_regions(mesh, 2).empty());
  EXPECT_EQ(mesh.tet_count(), tets);
}

TEST(MeshRepair, gives_a_stray_tet_to_its_neighbour) {
  TetMesh mesh = test::bar_mesh(6);
  mesh.regions.front() = 2;  // one tet of the far region at the near end
  EXPECT_EQ(repair_regions(mesh, 2).size(), 1u);
  EXPECT_EQ(mesh.regions.front(), 1);
}

TEST(MeshRepair, parts_what_touches_along_an_edge_or_at_a_vertex) {
  for (const bool edge : {true, false}) {
    // Two blocks that share one edge or one vertex of the raster.
    TetMesh mesh = test::cell_mesh(4, 4, 4, {0.04, 0.04, 0.04}, [&](int i, int j, int k) {
      if (i < 2 && j < 2 && (edge || k < 2)) return 1;
      return i >= 2 && j >= 2 && (edge || k >= 2) ? 2 : 0;
    });
    EXPECT_FALSE(check_manifold(boundary_surface(mesh)).closed_manifold());
    EXPECT_FALSE(repair_regions(mesh, 2).empty());
    EXPECT_TRUE(check_manifold(boundary_surface(mesh)).closed_manifold());
    EXPECT_TRUE(validate(mesh).describe().empty());
    EXPECT_EQ(face_connected_parts(mesh).count(), 2u);
  }
}

}  // namespace
}  // namespace calot
