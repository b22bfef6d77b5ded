// Regions by name and number; tets around vertices; units.
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

using Regions = std::vector<std::int32_t>;

TEST(Regions, ByStarNumberAndName) {
  const TetMesh mesh = biliary_mesh();
  EXPECT_EQ(regions_matching(mesh, "*", "x"), (Regions{2, 3, 4}));
  EXPECT_EQ(regions_matching(mesh, "3", "x"), Regions{3});
  EXPECT_EQ(regions_matching(mesh, "common bile duct", "x"), Regions{4});
}

TEST(Regions, SeveralRegionsOfOneName) {
  TetMesh mesh = biliary_mesh();
  mesh.region_names = {{2, "organ"}, {4, "organ"}};
  EXPECT_EQ(regions_matching(mesh, "organ", "x"), (Regions{2, 4}));
}

TEST(Regions, UnknownOnesAreListed) {
  const TetMesh mesh = biliary_mesh();
  const std::string message = message_of([&] { regions_matching(mesh, "liver", "model.toml:7"); });
  EXPECT_EQ(message,
            "model.toml:7: no region \"liver\" in the mesh; use one of: 2 (gallbladder), 3 (cystic duct), 4 (common "
            "bile duct)");
  for (const char* name : {"5", "", "Gallbladder", "3 ", "-3"})
    EXPECT_THROW(regions_matching(mesh, name, "x"), InputError);
}

TEST(VertexTets, EveryCornerOnce) {
  const TetMesh mesh = biliary_mesh();
  const VertexTets around = vertex_tets(mesh);
  ASSERT_EQ(around.start.size(), mesh.vertex_count() + 1);
  ASSERT_EQ(around.tets.size(), 4 * mesh.tet_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (std::uint32_t i = around.start[v]; i < around.start[v + 1]; ++i) {
      const Tet& tet = mesh.tet(around.tets[i]);
      EXPECT_NE(std::find(tet.begin(), tet.end(), VertexId(v)), tet.end());
      EXPECT_TRUE(i == around.start[v] || around.tets[i - 1] < around.tets[i]);
    }
}

TEST(Units, MetresPerUnit) {
  EXPECT_EQ(metres_per("m", "x"), 1.0);
  EXPECT_EQ(metres_per("cm", "x"), 1e-2);
  EXPECT_EQ(metres_per("mm", "x"), 1e-3);
  EXPECT_EQ(message_of([] { metres_per("inch", "model.toml:2"); }),
            "model.toml:2: unknown length unit \"inch\"; use \"m\", \"cm\" or \"mm\"");
}

}  // namespace
