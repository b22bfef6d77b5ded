// Which faces of the skin an edit laid bare, through edits of every kind.
#include <gtest/gtest.h>

#include "calot/mesh/surface_parameters.h"
#include "calot/view/snapshot_maker.h"
#include "tests/support/edits.h"

namespace calot {
namespace {

/// Flags of the boundary's faces by another way: the one of textures, which looks at places instead of numbers.
class Follower {
 public:
  explicit Follower(TetMesh mesh)
      : mesh_(std::move(mesh)),
        skin_(mesh_, ContactSurface(mesh_).triangles()),
        textured_(textured_surface(mesh_, 0, 4)) {}

  void edit(const TopologyEdit& edit) {
    StiffnessChange change;
    change.remap = apply(mesh_, edit);
    textured_ = after_edit(textured_, mesh_, change.remap, 0, 4);
    pending_.push_back(std::move(change));
  }
  void end_step() {
    skin_.follow(pending_, mesh_);
    pending_.clear();
  }
  /// Faces whose flags differ, and how many are flagged.
  std::pair<std::size_t, std::size_t> compare() const {
    std::size_t different = 0, cut = 0, k = 0;
    const ContactSurface surface(mesh_);
    for (const ContactTriangle& t : surface.triangles()) {
      EXPECT_EQ(textured_.surface.tet_of_triangle[k], t.tet);
      const bool is_cut = !skin_.is_skin(t.tet, t.face);
      different += is_cut != (textured_.exposed[k++] != 0) ? 1 : 0;
      cut += is_cut ? 1 : 0;
    }
    return {different, cut};
  }
  [[nodiscard]] const TetMesh& mesh() const { return mesh_; }

 private:
  TetMesh mesh_;
  SkinFaces skin_;
  TexturedSurface textured_;
  std::vector<StiffnessChange> pending_;
};

TEST(SnapshotSkin, AWholeMeshHasNoCutFaces) {
  const Follower follower(test::biliary_mesh(1));
  EXPECT_EQ(follower.compare(), std::pair(std::size_t{0}, std::size_t{0}));
}

TEST(SnapshotSkin, RemovedTetsLayTheirNeighboursFacesBare) {
  Follower follower(test::box_mesh(4, 4, 4, Vec3(0.04, 0.04, 0.04)));
  TopologyEdit edit;
  for (std::size_t t = 0; t < follower.mesh().tet_count(); ++t) {
    double x = 0;
    for (const VertexId v : follower.mesh().tets[t]) x += follower.mesh().position(v).x() / 4;
    if (x > 0.01 && x < 0.02) edit.removed.emplace_back(t);
  }
  follower.edit(edit);
  follower.end_step();
  EXPECT_EQ(follower.compare(), std::pair(std::size_t{0}, std::size_t{64}));  // two planes of 4 × 4 squares
}

TEST(SnapshotSkin, ASplitLaysBothSidesBare) {
  Follower follower(test::box_mesh(4, 2, 2, Vec3(0.04, 0.02, 0.02)));
  std::vector<std::uint8_t> above(follower.mesh().tet_count());
  for (std::size_t t = 0; t < above.size(); ++t) {
    double x = 0;
    for (const VertexId v : follower.mesh().tets[t]) x += follower.mesh().position(v).x() / 4;
    above[t] = x > 0.02;
  }
  follower.edit(test::separate(follower.mesh(), above));
  follower.end_step();
  EXPECT_EQ(follower.compare(), std::pair(std::size_t{0}, std::size_t{16}));
}

class SnapshotSkinRandom : public testing::TestWithParam<std::uint64_t> {};

/// Vertices that slide change the outline, which the other way sees by places; everything else must agree.
TEST_P(SnapshotSkinRandom, ManyEditsInOneStepOrEachInItsOwn) {
  Follower one_by_one(test::biliary_mesh(1)), together(test::biliary_mesh(1));
  std::size_t cut = 0;
  for (std::uint64_t step = 0; step < 4; ++step) {
    for (std::uint64_t k = 0; k < 3; ++k) {
      const TopologyEdit edit = (k == 2) ? test::random_bisections(one_by_one.mesh(), 12, GetParam() * 37 + 5 * step)
                                         : test::random_edit(one_by_one.mesh(), 9, GetParam() * 101 + 7 * step + k);
      one_by_one.edit(edit);
      one_by_one.end_step();
      together.edit(edit);
    }
    together.end_step();
    EXPECT_EQ(one_by_one.compare().second, together.compare().second);
    EXPECT_EQ(one_by_one.compare().first, 0U);
    cut = together.compare().second;
  }
  EXPECT_GT(cut, 0U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SnapshotSkinRandom, testing::Range<std::uint64_t>(1, 9));

}  // namespace
}  // namespace calot
