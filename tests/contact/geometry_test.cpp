#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "calot/contact/box_tree.h"
#include "calot/contact/contact_surface.h"
#include "calot/contact/rigid_shape.h"
#include "calot/contact/simplex_distance.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

using namespace test;
using detail::Box;
using detail::BoxTree;
using detail::Closest;
using detail::closest_points;
using detail::Corners;

Vec3 random_point(Random& random) {
  return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
}

TEST(ClosestPoints, FulfilTheConditionsOfALeastDistance) {
  // Between convex bodies, points a and b are closest if and only if no corner lies further along the other's way.
  Random random(1);
  int crossing = 0;
  for (int n = 0; n < 30000; ++n) {
    const int count = n % 3 + 1;
    Corners a, b;
    for (Vec3& x : a) x = random_point(random);
    for (Vec3& x : b) x = random_point(random);
    if (n % 7 == 0) a[1] = a[0] + 1e-3 * (b[1] - b[0]);  // parallel to an edge
    if (n % 11 == 0) b[2] = 0.5 * (b[0] + b[1]);         // a triangle without area
    const Closest c = closest_points(a, count, b);
    ASSERT_NEAR(c.weights_a.sum(), 1, 1e-12);
    ASSERT_NEAR(c.weights_b.sum(), 1, 1e-12);
    ASSERT_GE(std::min(c.weights_a.minCoeff(), c.weights_b.minCoeff()), -1e-12);
    for (int k = count; k < 3; ++k) ASSERT_EQ(c.weights_a(k), 0);
    ASSERT_LT((detail::weighted(a, c.weights_a) - c.a).norm(), 1e-12);
    ASSERT_LT((detail::weighted(b, c.weights_b) - c.b).norm(), 1e-12);
    const Vec3 apart = c.b - c.a;
    if (c.distance == 0) {
      ++crossing;
      ASSERT_LT(apart.norm(), 1e-9) << n;
      continue;
    }
    ASSERT_NEAR(apart.norm(), c.distance, 1e-12);
    for (int k = 0; k < count; ++k) ASSERT_LT(apart.dot(a[k] - c.a), 1e-6) << n;
    for (int k = 0; k < 3; ++k) ASSERT_GT(apart.dot(b[k] - c.b), -1e-6) << n;
  }
  EXPECT_GT(crossing, 500);
}

TEST(ClosestPoints, KnownCases) {
  const Corners floor{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  EXPECT_DOUBLE_EQ(closest_points({Vec3(0.2, 0.2, 0.7)}, 1, floor).distance, 0.7);
  EXPECT_DOUBLE_EQ(closest_points({Vec3(-3, 0, 4)}, 1, floor).distance, 5);
  // A rod across an edge, past all corners.
  EXPECT_DOUBLE_EQ(closest_points({Vec3(0.5, -0.2, 1), Vec3(0.5, -0.2, -1)}, 2, floor).distance, 0.2);
  EXPECT_EQ(closest_points({Vec3(0.2, 0.2, 1), Vec3(0.2, 0.2, -1)}, 2, floor).distance, 0);
}

TEST(BoxTree, FindsWhatBruteForceFinds) {
  Random random(2);
  for (const std::size_t count : {0u, 1u, 5u, 300u}) {
    std::vector<Box> boxes(count), facing(count);
    std::vector<Vec3> normals(count);
    for (std::size_t i = 0; i < count; ++i) {
      boxes[i].add(random_point(random));
      boxes[i].widen(random.between(0, 0.1));
      normals[i] = random_point(random).normalized();
      facing[i].add(normals[i]);
    }
    BoxTree tree;
    tree.build(boxes);
    for (Box& box : boxes) box.widen(0.02);
    tree.refit(boxes, facing);
    for (int n = 0; n < 50; ++n) {
      Box query;
      query.add(random_point(random));
      query.widen(0.2);
      std::set<std::uint32_t> got, want;
      tree.each(query, [&](std::uint32_t i) { EXPECT_TRUE(got.insert(i).second); });
      for (std::uint32_t i = 0; i < count; ++i)
        if (boxes[i].meets(query)) want.insert(i);
      EXPECT_EQ(got, want);
    }
    std::set<std::pair<std::uint32_t, std::uint32_t>> got;
    BoxTree::pairs(tree, tree, -0.3, [&](std::uint32_t i, std::uint32_t j) {
      if (normals[i].dot(normals[j]) >= -0.3) return;
      EXPECT_TRUE(got.insert(std::minmax(i, j)).second);
    });
    std::set<std::pair<std::uint32_t, std::uint32_t>> want;
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t j = i + 1; j < count; ++j)
        if (boxes[i].meets(boxes[j]) && normals[i].dot(normals[j]) < -0.3) want.insert({i, j});
    EXPECT_EQ(got, want);
  }
}

TEST(ContactSurface, NearestPointAndSideOfABox) {
  const TetMesh mesh = box_mesh(4, 4, 4, {1, 1, 1});
  ContactSurface surface(mesh);
  surface.refit(mesh.positions, {}, 0);
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 p = 0.5 * (Vec3::Ones() + 1.6 * random_point(random));
    const Vec3 outside = (p - p.cwiseMax(0).cwiseMin(1));
    const double depth = std::min(p.minCoeff(), (Vec3::Ones() - p).minCoeff());
    const double want = outside.norm() > 0 ? outside.norm() : -depth;
    EXPECT_NEAR(surface.nearest(p).distance, want, 1e-12) << p.transpose();
  }
}

TEST(ContactSurface, FollowEqualsARebuild) {
  Random random(4);
  TetMesh mesh = biliary_mesh();
  ContactSurface surface(mesh);
  const Surface plain = boundary_surface(mesh);
  ASSERT_EQ(plain.triangles.size(), surface.triangles().size());
  for (std::size_t i = 0; i < plain.triangles.size(); ++i) {
    EXPECT_EQ(plain.tet_of_triangle[i], surface.triangles()[i].tet);
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(plain.vertex_of_mesh[plain.triangles[i][c]], surface.triangles()[i].vertices[c]);
  }
  for (int n = 0; n < 30; ++n) {
    TopologyEdit edit;
    edit.removed = random_tets(mesh, 1 + random.below(25), 100 + static_cast<std::uint64_t>(n));
    // Half of them come back: cut loose at a corner of their own, or divided by a new vertex at their middle.
    for (const TetId t : edit.removed) {
      const Tet tet = mesh.tets[t.index()];
      const VertexId fresh(mesh.vertex_count() + edit.vertices.size());
      if (random.unit() < 0.3) {
        edit.vertices.push_back({mesh.position(tet[0]), tet[0], tet[0], 0});
        edit.tets.push_back({{fresh, tet[1], tet[2], tet[3]}, t});
      } else if (random.unit() < 0.4) {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : tet) middle += 0.25 * mesh.position(v);
        edit.vertices.push_back({middle, tet[0], tet[1], 0.5});
        for (int c = 0; c < 4; ++c) {
          Tet piece = tet;
          piece[c] = fresh;
          edit.tets.push_back({piece, t});
        }
      }
    }
    const Remap remap = apply(mesh, edit);
    surface.follow(mesh, remap);
    const ContactSurface anew(mesh);
    ASSERT_EQ(surface.triangles(), anew.triangles()) << n;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const auto x = surface.around(VertexId(v)), y = anew.around(VertexId(v));
      ASSERT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end()));
    }
    surface.refit(mesh.positions, {}, 1e-3);
  }
}

TEST(Screw, MovesEvenlyAndEndsWhereItShould) {
  Random random(6);
  for (int n = 0; n < 500; ++n) {
    const double angle = n % 5 == 0 ? 1e-9 : random.between(0, 3.1);
    Pose from, to;
    from.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(1.3, random_point(random).normalized()));
    from.position = random_point(random);
    to.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, random_point(random).normalized())) * from.rotation;
    to.position = random_point(random);
    const Vec3 x = random_point(random);
    EXPECT_LT((pose_between(from, to, 0) * x - from * x).norm(), 1e-12);
    EXPECT_LT((pose_between(from, to, 1) * x - to * x).norm(), 1e-7);
    // Every quarter is the same motion as the one before, and the screw's speed is the path's length.
    const Pose step = pose_between(from, to, 0.25) * from.inverse();
    Vec3 at = from * x;
    double path = 0;
    for (int k = 0; k < 4; ++k) at = step * at;
    EXPECT_LT((at - to * x).norm(), 1e-7);
    for (int k = 0; k < 200; ++k)
      path += (pose_between(from, to, (k + 1) / 200.0) * x - pose_between(from, to, k / 200.0) * x).norm();
    const Screw screw = screw_between(from, to);
    EXPECT_NEAR(path, (screw.turn.cross(from * x - from.position) + screw.shift).norm(), 1e-3 * path);
  }
  // A quarter turn about an axis through (1, 0, 0) takes the origin to (1, −1, 0) on an arc.
  Pose from, to;
  to.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  to.position = {1, -1, 0};
  const double s = std::sqrt(0.5);
  EXPECT_LT((pose_between(from, to, 0.5).position - Vec3(1 - s, -s, 0)).norm(), 1e-12);
}

TEST(ContactFrame, IsRightHandedOrthonormal) {
  Random random(7);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 normal = n < 3 ? Vec3(Vec3::Unit(n)) : Vec3(random_point(random).normalized());
    const Eigen::Matrix3d frame = contact_frame(normal);
    EXPECT_LT((frame * frame.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);
    EXPECT_EQ(Vec3(frame.row(0).transpose()), normal);
  }
}

}  // namespace
}  // namespace calot
