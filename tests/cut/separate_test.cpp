#include "calot/cut/separate.h"

#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

using Faces = std::vector<std::array<VertexId, 3>>;

/// The faces of a mesh that lie in a plane x = place.
Faces faces_at(const TetMesh& mesh, double place) {
  Faces faces;
  for (const Tet& tet : mesh.tets)
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<VertexId, 3> face;
      std::size_t count = 0;
      for (std::size_t c = 0; c < 4; ++c)
        if (c != skip && mesh.position(tet[c]).x() == place) face[count < 3 ? count : 2] = tet[c], ++count;
      if (count == 3) faces.push_back(face);
    }
  return faces;
}

TEST(Separate, TwoTetsOnAFacePart) {
  TetMesh mesh = two_tets();
  const TopologyEdit edit = separate(mesh, vertex_tets(mesh), Faces{{VertexId(2), VertexId(0), VertexId(1)}});
  EXPECT_EQ(edit.vertices.size(), 3u);
  EXPECT_EQ(edit.removed.size(), 1u);
  EXPECT_EQ(edit.removed[0], TetId(1));  // the first fan keeps the vertices
  for (const AddedVertex& v : edit.vertices) EXPECT_EQ(v.from, v.to);
  apply(mesh, edit);
  EXPECT_FALSE(validate(mesh).fatal());
  EXPECT_EQ(vertex_connected_groups(mesh).back(), 1u);
}

TEST(Separate, HingesGoWithTheFacesOnThem) {
  TetMesh mesh = two_tets_on_an_edge();
  const TopologyEdit edit = separate(mesh, vertex_tets(mesh), Faces{{VertexId(0), VertexId(1), VertexId(2)}});
  apply(mesh, edit);
  EXPECT_EQ(mesh.vertex_count(), 8u);
  EXPECT_TRUE(hinges(mesh, face_connected_parts(mesh)).empty());
}

TEST(Separate, AFaceInsideChangesNothing) {
  const TetMesh mesh = box_mesh(4, 4, 4, {1, 1, 1});
  const VertexTets around = vertex_tets(mesh);
  const VertexId centre(2 + 5 * (2 + 5 * 2));
  for (const TetId t : std::span(around.tets).subspan(around.start[centre.index()], 6)) {
    const Tet& tet = mesh.tet(t);
    EXPECT_TRUE(separate(mesh, around, Faces{{tet[0], tet[1], tet[2]}}).empty());
  }
}

TEST(Separate, AWholeSectionLeavesTwoParts) {
  TetMesh mesh = box_mesh(4, 3, 3, {4, 3, 3});
  const TopologyEdit edit = separate(mesh, vertex_tets(mesh), faces_at(mesh, 2));
  EXPECT_EQ(edit.vertices.size(), 16u);
  apply(mesh, edit);
  const Parts parts = face_connected_parts(mesh);
  EXPECT_EQ(parts.count(), 2u);
  EXPECT_TRUE(hinges(mesh, parts).empty());
}

TEST(Separate, ACracksFrontStaysSingle) {
  TetMesh mesh = box_mesh(4, 4, 2, {4, 4, 2});
  Faces faces = faces_at(mesh, 2);
  std::erase_if(faces, [&](const auto& face) {  // only the half y ≤ 2
    return std::any_of(face.begin(), face.end(), [&](VertexId v) { return mesh.position(v).y() > 2; });
  });
  const TopologyEdit edit = separate(mesh, vertex_tets(mesh), faces);
  EXPECT_EQ(edit.vertices.size(), 2u * 3);  // y = 0 and 1; y = 2 is the front
  for (const AddedVertex& v : edit.vertices) EXPECT_LT(v.position.y(), 2);
  apply(mesh, edit);
  EXPECT_EQ(face_connected_parts(mesh).count(), 1u);
}

TEST(Separate, RefusesVerticesThatDontExist) {
  const TetMesh mesh = regular_tet();
  EXPECT_THROW(separate(mesh, vertex_tets(mesh), Faces{{VertexId(0), VertexId(1), VertexId(4)}}), InputError);
  EXPECT_TRUE(separate(mesh, vertex_tets(mesh), Faces{{VertexId(0), VertexId(1), VertexId(2)}}).empty());
  EXPECT_TRUE(separate(mesh, vertex_tets(mesh), {}).empty());
}

}  // namespace
}  // namespace calot::test
