// What is sent to the graphics card: normals, packed; indices after a cut only.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "calot/view/passes/tissue_drawn.h"
#include "calot/view/surface_stream.h"
#include "tests/view/renderer_picture.h"

namespace calot {
namespace {

Vec3f unpacked(const std::array<std::int16_t, 4>& n) {
  return Vec3f(n[0], n[1], n[2]) / 32767.0F;
}

TEST(RendererSurface, NormalsAreThoseOfTheFacesAroundAndMeetAcrossLooks) {
  Snapshot snapshot = test::moment_of(test::gallbladder_scene());
  for (Vec3f& p : snapshot.positions) p = Vec3f(p.x(), p.y() + 3 * p.x() * p.x(), p.z());
  detail::SurfaceStream stream;
  stream.set_skin(snapshot.skin);
  ASSERT_EQ(stream.vertex_count(), snapshot.positions.size());
  std::vector<detail::StreamVertex> out(stream.vertex_count());
  stream.pack(snapshot.positions, snapshot.conditions, out.data());
  std::map<std::uint32_t, Eigen::Vector3d> wanted;  // by vertex of the mesh
  for (const auto& [a, b, c] : snapshot.skin.triangles) {
    const auto at = [&](std::uint32_t v) { return Eigen::Vector3d(snapshot.positions[v].cast<double>()); };
    const Eigen::Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a));
    for (const std::uint32_t v : {a, b, c})
      wanted.try_emplace(snapshot.skin.vertices[v].vertex, Eigen::Vector3d::Zero()).first->second += normal;
  }
  std::size_t shared = 0;
  std::map<std::uint32_t, TissueLook> looks;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const SkinVertex& v = snapshot.skin.vertices[i];
    EXPECT_LT((unpacked(out[i].normal).cast<double>() - wanted[v.vertex].normalized()).norm(), 2e-4);
    EXPECT_EQ(out[i].position[0], snapshot.positions[i].x());
    const auto [other, fresh] = looks.try_emplace(v.vertex, v.look);
    shared += !fresh && other->second != v.look ? 1 : 0;
  }
  EXPECT_GT(shared, 4U);  // duct and gallbladder meet
}

TEST(RendererSurface, ConditionsAreRoundedAndClamped) {
  Snapshot snapshot = test::moment_of(test::slab_scene("liver"));
  snapshot.conditions[3] = {0.5F, 1.7F, -1.0F, 1.0F};
  detail::SurfaceStream stream;
  stream.set_skin(snapshot.skin);
  std::vector<detail::StreamVertex> out(stream.vertex_count());
  stream.pack(snapshot.positions, snapshot.conditions, out.data());
  EXPECT_EQ(out[3].condition, (std::array<std::uint8_t, 4>{128, 255, 0, 255}));
}

TEST(RendererSurface, IndicesAreSentAgainAfterACutOnly) {
  OffscreenContext& context = test::shared_context();
  context.make_current();
  context.log().clear();
  const Scene scene = test::slab_scene("liver");
  Snapshot snapshot = test::moment_of(scene);
  detail::TissueDrawn tissue;
  std::vector<detail::Drawable> drawables;
  for (int k = 0; k < 3; ++k) {
    for (Vec3f& p : snapshot.positions) p.z() += 1e-3F;
    tissue.upload(snapshot);
  }
  tissue.add_to(drawables);
  EXPECT_EQ(tissue.index_uploads(), 1U);
  ASSERT_EQ(drawables.size(), 1U);
  EXPECT_EQ(static_cast<std::size_t>(drawables[0].count), 3 * snapshot.skin.triangles.size());

  const Snapshot after = test::moment_after_cut(scene, [](const Vec3& x) { return std::abs(x.x()) < 4e-3; });
  ASSERT_NE(after.skin.version, snapshot.skin.version);
  tissue.upload(after);
  tissue.upload(after);
  EXPECT_EQ(tissue.index_uploads(), 2U);
  drawables.clear();
  tissue.add_to(drawables);
  ASSERT_EQ(drawables.size(), 2U);
  EXPECT_FALSE(drawables[0].cut);
  EXPECT_TRUE(drawables[1].cut);
  EXPECT_EQ(static_cast<std::size_t>(drawables[0].count + drawables[1].count), 3 * after.skin.triangles.size());
  EXPECT_TRUE(context.log().silent());
}

}  // namespace
}  // namespace calot
