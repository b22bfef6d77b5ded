#include "calot/sim/tear.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/error.h"
#include "calot/cut/separate.h"
#include "calot/fem/element.h"
#include "calot/mesh/parts.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

TissueProperties bears(double stretch) {
  TissueProperties p;
  p.ultimate_stretch = stretch;
  return p;
}

Eigen::Matrix3d random_matrix(test::Random& random) {
  Eigen::Matrix3d m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = random.between(-1, 1);
  return m;
}

TEST(Tearing, StretchIsTheRootOfTheLargestEigenvalueWhateverTheDeformation) {
  const TetMesh mesh = test::regular_tet(0.01);
  const VertexTets around = vertex_tets(mesh);
  Tearing tearing(mesh, {{1, bears(1e6)}});
  test::Random random(5);
  for (int k = 0; k < 2000; ++k) {
    Eigen::Matrix3d f = random_matrix(random);
    if (k % 4 == 1) {  // two equal large, two equal small, three equal
      const Eigen::Matrix3d q = Eigen::Quaterniond(Eigen::Vector4d(f.data())).normalized().toRotationMatrix();
      const double a = random.between(0.5, 2), b = k % 8 == 1 ? random.between(0.1, 3) : a;
      f = q * Eigen::Vector3d(a, a, b).asDiagonal() * q.transpose();
    }
    if (k % 4 == 2) f = Eigen::Matrix3d::Identity() + 1e-7 * f;
    std::vector<Vec3> now;
    for (const Vec3& x : mesh.positions) now.push_back(f * x + Vec3(1, 2, 3) * 0.1);
    const TearStep& step = tearing.step(mesh, around, now);
    const double expected = f.jacobiSvd().singularValues()[0];
    ASSERT_NEAR(tearing.stretch(TetId(0)), expected, (k % 4 == 1 ? 3e-8 : 1e-11) * std::max(1.0, expected)) << k;
    ASSERT_EQ(step.inverted.empty(), f.determinant() > 0) << k;
  }
}

TEST(Tearing, ReportsTheLargestStretchOfEachRegion) {
  const TetMesh mesh = test::bar_mesh(8);
  Tearing tearing(mesh, {{1, bears(1.5)}, {2, bears(1.2)}});
  std::vector<Vec3> now = mesh.positions;
  for (Vec3& x : now) x.x() += x.x() > 0.05 ? 0.1 * (x.x() - 0.05) : -0.2 * (x.x() - 0.05);
  const TearStep& step = tearing.step(mesh, vertex_tets(mesh), now);
  ASSERT_EQ(step.by_region.size(), 2u);
  EXPECT_NEAR(step.by_region[0].largest, 1.0, 1e-12);  // compressed: across it nothing happens
  EXPECT_NEAR(step.by_region[1].largest, 1.1, 1e-12);
  EXPECT_NEAR(step.by_region[1].utilisation, 0.5, 1e-11);
  EXPECT_NEAR(step.largest, 1.1, 1e-12);
  EXPECT_TRUE(step.faces.empty());
}

TEST(Tearing, TearsAfterTwoStepsAcrossTheStretchAndNoMoreThanAllowed) {
  const TetMesh mesh = test::bar_mesh(8);
  const VertexTets around = vertex_tets(mesh);
  TearOptions options;
  options.max_tears = 3;
  Tearing tearing(mesh, {{1, bears(1.3)}, {2, bears(1.3)}}, options);
  std::vector<Vec3> now = mesh.positions;
  for (Vec3& x : now) x.x() *= 1.4;
  EXPECT_TRUE(tearing.step(mesh, around, now).torn.empty());
  const TearStep& step = tearing.step(mesh, around, now);
  EXPECT_EQ(step.torn.size(), 3u);
  ASSERT_FALSE(step.faces.empty());
  std::set<std::array<VertexId, 3>> unique(step.faces.begin(), step.faces.end());
  EXPECT_EQ(unique.size(), step.faces.size());
  double across = 0;
  for (const auto& face : step.faces) {
    const Vec3 &a = mesh.position(face[0]), &b = mesh.position(face[1]), &c = mesh.position(face[2]);
    across += std::abs((b - a).cross(c - a).normalized().x()) / static_cast<double>(step.faces.size());
  }
  EXPECT_GT(across, 0.6);
  EXPECT_TRUE(tearing.step(mesh, around, mesh.positions).torn.empty());  // let go: nothing more
}

TEST(Tearing, AShortStretchIsForgiven) {
  const TetMesh mesh = test::bar_mesh(8);
  const VertexTets around = vertex_tets(mesh);
  Tearing tearing(mesh, {{1, bears(1.3)}, {2, bears(1.3)}});
  std::vector<Vec3> now = mesh.positions;
  for (Vec3& x : now) x.x() *= 1.4;
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(tearing.step(mesh, around, now).torn.empty());
    EXPECT_TRUE(tearing.step(mesh, around, mesh.positions).torn.empty());
  }
}

/// Where a mesh comes to rest, linearly, with vertices held at given places; others on loose parts are held weakly.
std::vector<Vec3> at_rest(const TetMesh& mesh, const std::vector<Vec3>& held_at, const std::vector<bool>& held) {
  std::vector<Eigen::Triplet<double>> entries;
  const std::size_t n = mesh.vertex_count();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * n));
  const Lame elasticity = lame({1e4, 0.3, 1000});
  for (const Tet& tet : mesh.tets) {
    const auto k =
        stiffness(tet_shape(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])),
                  elasticity);
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) {
        const auto row = static_cast<int>(3 * tet[i / 3].index()) + i % 3;
        entries.emplace_back(row, static_cast<int>(3 * tet[j / 3].index()) + j % 3, k(i, j));
      }
  }
  for (std::size_t v = 0; v < n; ++v)
    for (int a = 0; a < 3; ++a) {
      const int d = static_cast<int>(3 * v) + a;
      entries.emplace_back(d, d, held[v] ? 1e7 : 1e-6);
      if (held[v]) right[d] = 1e7 * (held_at[v][a] - mesh.positions[v][a]);
    }
  Eigen::SparseMatrix<double> matrix(right.size(), right.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  std::vector<Vec3> now = mesh.positions;
  for (std::size_t v = 0; v < n; ++v) now[v] += u.segment<3>(static_cast<Eigen::Index>(3 * v));
  return now;
}

TEST(Tearing, ABarPulledTooFarComesApartWhereItIsWeakAndIsRelieved) {
  TetMesh mesh = test::bar_mesh(10, 0.05, 0.01);
  Tearing tearing(mesh, {{1, bears(2)}, {2, bears(1.3)}});
  const double volume = 0.05 * 0.01 * 0.01;
  std::size_t tears = 0, steps = 0;
  TearStep last;
  for (; steps < 200; ++steps) {
    std::vector<Vec3> held_at = mesh.positions;
    std::vector<bool> held(mesh.vertex_count());
    for (std::size_t v = 0; v < held.size(); ++v) {
      const double x = mesh.positions[v].x();
      held[v] = x < 1e-9 || x > 0.05 - 1e-9;
      if (x > 0.025) held_at[v].x() += 0.02;
    }
    const std::vector<Vec3> now = at_rest(mesh, held_at, held);
    const VertexTets around = vertex_tets(mesh);
    last = tearing.step(mesh, around, now);
    tears += last.torn.size();
    if (last.largest < 1.01) break;
    if (last.faces.empty()) continue;
    const TopologyEdit edit = separate(mesh, around, last.faces);
    if (edit.empty()) continue;
    tearing.follow(apply(mesh, edit), mesh);
  }
  EXPECT_LT(steps, 200u);
  EXPECT_GT(tears, 2u);
  EXPECT_LT(last.largest, 1.01);
  const Parts parts = face_connected_parts(mesh);
  ASSERT_GE(parts.count(), 2u);
  double left = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    left += signed_volume(mesh, TetId(t));
    EXPECT_TRUE(mesh.regions[t] != 1 || parts.of_tet[t] == parts.of_tet[0]) << "the strong half stays whole";
  }
  EXPECT_NEAR(left, volume, 1e-12 * volume);
}

TEST(Tearing, FollowsAnEditAndCopies) {
  TetMesh mesh = test::bar_mesh(8);
  Tearing tearing(mesh, {{1, bears(1.3)}, {2, bears(1.3)}});
  std::vector<Vec3> now = mesh.positions;
  for (Vec3& x : now) x.x() *= 1.4;
  tearing.step(mesh, vertex_tets(mesh), now);
  TopologyEdit edit;
  edit.removed = {TetId(0), TetId(7), TetId(20)};
  tearing.follow(apply(mesh, edit), mesh);
  now = mesh.positions;
  for (Vec3& x : now) x.x() *= 1.4;
  Tearing copy = tearing;
  const VertexTets around = vertex_tets(mesh);
  const TearStep one = tearing.step(mesh, around, now), two = copy.step(mesh, around, now);
  EXPECT_FALSE(one.torn.empty());  // the step before the edit counts
  EXPECT_EQ(one.faces, two.faces);
  std::string a, b;
  tearing.append_state(a);
  copy.append_state(b);
  EXPECT_EQ(a, b);
}

TEST(Tearing, MeasuresAfterEditsWhatOneMadeAnewMeasures) {
  TetMesh mesh = test::bar_mesh(12);
  const std::map<std::int32_t, TissueProperties> tissues{{1, bears(1.3)}, {2, bears(1.6)}};
  Tearing tearing(mesh, tissues);
  test::Random random(3);
  for (int round = 0; round < 20; ++round) {
    TopologyEdit edit;
    if (round % 2 == 0) {
      edit.removed = test::random_tets(mesh, 4, random.next());
    } else {
      std::vector<std::array<VertexId, 3>> faces;
      for (const Tet& tet : mesh.tets)
        if (random.unit() < 0.3) faces.push_back({tet[0], tet[1], tet[2]});
      edit = separate(mesh, vertex_tets(mesh), faces);
    }
    tearing.follow(apply(mesh, edit), mesh);
    std::vector<Vec3> now = mesh.positions;
    for (Vec3& x : now) x += 0.002 * Vec3(random.unit(), random.unit(), random.unit());
    Tearing anew(mesh, tissues);
    const VertexTets around = vertex_tets(mesh);
    const TearStep &one = tearing.step(mesh, around, now), &two = anew.step(mesh, around, now);
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
      ASSERT_EQ(tearing.stretch(TetId(t)), anew.stretch(TetId(t))) << t;
    EXPECT_EQ(one.inverted, two.inverted);
  }
}

TEST(Tearing, RefusesBadFigures) {
  const TetMesh mesh = test::bar_mesh(4);
  EXPECT_THROW(Tearing(mesh, {{1, bears(1.3)}}), InputError);
  EXPECT_THROW(Tearing(mesh, {{1, bears(1.0)}, {2, bears(1.3)}}), InputError);
  TearOptions options;
  options.steps_to_tear = 0;
  EXPECT_THROW(Tearing(mesh, {{1, bears(1.3)}, {2, bears(1.3)}}, options), InputError);
}

}  // namespace
}  // namespace calot
