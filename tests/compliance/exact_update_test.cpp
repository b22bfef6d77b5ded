// The exact update against recomputation: every kind of cut, both homes, every step length.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "calot/base/error.h"
#include "calot/compliance/correction.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

using test::biliary_model;

struct Case {
  double time_step;
  Backend backend;
};

class ExactUpdate : public testing::TestWithParam<Case> {
 protected:
  [[nodiscard]] Model model() const { return biliary_model(GetParam().time_step); }
  [[nodiscard]] Compliance compute(const Model& m) const { return precompute(m, {GetParam().backend}); }

  // Cuts `tets` away from both and compares: whole columns, and the block that is answered at once.
  void cut_and_compare(Model& m, Compliance& compliance, std::vector<TetId> tets) const {
    const StiffnessChange change = m.apply({std::move(tets), {}, {}});
    if (!change.unsupported.empty()) {
      EXPECT_THROW(compliance.update(change), Unsupported);
      return;
    }
    compliance.update(change);
    const Compliance reference = compute(m);
    std::vector<VertexId> face = test::cut_face(change);
    if (face.size() > 15) face.resize(15);
    const std::vector<DofId> dofs = test::sample_dofs(m.mesh().vertex_count(), face);
    const double allowed = test::bound(reference);
    EXPECT_LE(test::worst_column(compliance, reference, dofs), allowed);
    const Eigen::MatrixXd block = compliance.block(dofs, dofs), exact = reference.columns(dofs);
    for (std::size_t j = 0; j < dofs.size(); ++j)
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(j);
        // Not refined: DESIGN allows what the condition number does.
        EXPECT_NEAR(block(r, c), exact(dofs[i].value, c), 10 * allowed * exact.col(c).cwiseAbs().maxCoeff() + 1e-300);
      }
  }
};

TEST_P(ExactUpdate, RandomTets) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Model m = model();
    Compliance compliance = compute(m);
    cut_and_compare(m, compliance, test::random_tets(m.mesh(), 5 * seed * seed, seed));
  }
}

TEST_P(ExactUpdate, ThroughTheDuctLeavingAPartOfItsOwn) {
  Model m = model();
  Compliance compliance = compute(m);
  cut_and_compare(m, compliance,
                  test::tets_where(m.mesh(), [](const Vec3& c) { return c.x() > 0.0145 && c.x() < 0.0205; }));
}

TEST_P(ExactUpdate, OrphaningVertices) {
  Model m = model();
  Compliance compliance = compute(m);
  const std::vector<TetId> tets =
      test::tets_where(m.mesh(), [](const Vec3& c) { return c.x() > 0.012 && c.x() < 0.028; });
  ASSERT_FALSE(extent_of(m.mesh(), {tets, {}, {}}).orphaned.empty());
  cut_and_compare(m, compliance, tets);
}

TEST_P(ExactUpdate, TouchingFixedVertices) {
  Model m = model();
  Compliance compliance = compute(m);
  std::vector<TetId> tets;
  for (std::size_t t = 0; t < m.mesh().tet_count() && tets.size() < 10; t += 3)
    if (std::any_of(m.mesh().tets[t].begin(), m.mesh().tets[t].end(), [&](VertexId v) { return m.is_fixed(v); }))
      tets.push_back(TetId(t));
  ASSERT_EQ(tets.size(), 10u);
  cut_and_compare(m, compliance, tets);
}

TEST_P(ExactUpdate, LeavingASingleTet) {
  Model m = model();
  Compliance compliance = compute(m);
  std::vector<TetId> tets(m.mesh().tet_count() - 1);
  for (std::size_t t = 0; t < tets.size(); ++t) tets[t] = TetId(t + 1);
  cut_and_compare(m, compliance, tets);
}

TEST_P(ExactUpdate, CuttingNothingAndEverything) {
  Model m = model();
  Compliance compliance = compute(m);
  const std::vector<DofId> dofs = test::sample_dofs(m.mesh().vertex_count());
  const Eigen::MatrixXd before = compliance.block(dofs, dofs);
  EXPECT_EQ(compliance.update(m.apply({})).rank, 0u);
  EXPECT_EQ(compliance.block(dofs, dofs), before);
  std::vector<TetId> all(m.mesh().tet_count());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = TetId(t);
  compliance.update(m.apply({all, {}, {}}));
  EXPECT_EQ(compliance.vertex_count(), 0u);
  EXPECT_TRUE(compliance.solve({}).empty());
}

// Many cuts one after another, some folded in between, against one recomputation at the end.
TEST_P(ExactUpdate, ManyCutsOneAfterAnother) {
  Model m = model();
  Compliance compliance = compute(m);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const StiffnessChange change = m.apply({test::random_tets(m.mesh(), 6, seed), {}, {}});
    ASSERT_EQ(change.unsupported, "");
    compliance.update(change);
    if (seed == 5) compliance.start_fold();
    if (seed == 8) compliance.adopt_fold();
    if (seed == 10) compliance.fold();
  }
  const Compliance reference = compute(m);
  EXPECT_LE(test::worst_column(compliance, reference, test::sample_dofs(m.mesh().vertex_count())),
            test::bound(reference));
  EXPECT_LE(compliance.probe(), test::bound(reference));
}

INSTANTIATE_TEST_SUITE_P(EveryStep, ExactUpdate,
                         testing::Values(Case{0, Backend::dense}, Case{0.005, Backend::dense},
                                         Case{0.02, Backend::dense}, Case{0.1, Backend::dense},
                                         Case{1.0, Backend::dense}, Case{0, Backend::sparse},
                                         Case{0.02, Backend::sparse}, Case{1.0, Backend::sparse}),
                         [](const auto& tested) {
                           return std::string(tested.param.backend == Backend::dense ? "dense" : "sparse") + "_" +
                                  std::to_string(static_cast<int>(tested.param.time_step * 1000)) + "ms";
                         });

// The formula alone, on a small matrix that isn't a mesh: compare with inverting what is left.
class Formula : public testing::Test {
 protected:
  static constexpr Eigen::Index n = 24, d = 4, k = 9;
  Formula() {
    test::Random random(11);
    Eigen::MatrixXd a(n, n), b(k, 5);
    for (double& value : a.reshaped()) value = random.between(-1, 1);
    for (double& value : b.reshaped()) value = random.between(-1, 1);
    change = -b * b.transpose();
    stiffness = a * a.transpose() + 3 * Eigen::MatrixXd::Identity(n, n);
    stiffness.block(d, d, k, k) -= change;
  }
  [[nodiscard]] DenseBase base() const {
    const Eigen::MatrixXd compliance = stiffness.inverse();
    Buffer matrix(static_cast<std::size_t>(n * n));
    std::copy_n(compliance.data(), n * n, matrix.data());
    return DenseBase(std::move(matrix), static_cast<std::size_t>(n));
  }
  [[nodiscard]] static std::vector<std::uint32_t> rows(Eigen::Index first, Eigen::Index last) {
    std::vector<std::uint32_t> result;
    for (Eigen::Index r = first; r < last; ++r) result.push_back(static_cast<std::uint32_t>(r));
    return result;
  }
  Eigen::MatrixXd stiffness, change;
};

TEST_F(Formula, EqualsTheInverseOfWhatIsLeft) {
  DenseBase dense = base();
  Correction correction(n);
  correction.add(dense, {rows(0, d + k), d, change});
  const double eigenvalue = correction.factor().smallest_eigenvalue;
  EXPECT_GT(eigenvalue, 0);
  EXPECT_LE(eigenvalue, 1);
  Eigen::MatrixXd left = stiffness.bottomRightCorner(n - d, n - d);
  left.topLeftCorner(k, k) += change;
  const Eigen::MatrixXd expected = left.inverse();
  const Eigen::MatrixXd block = correction.block(dense, rows(d, n), rows(d, n));
  EXPECT_LT((block - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LT(correction.block(dense, rows(0, d), rows(0, n)).norm(), 1e-12);
  const Eigen::MatrixXd applied = correction.apply(dense, Eigen::MatrixXd::Identity(n, n));
  EXPECT_LT((applied.bottomRightCorner(n - d, n - d) - expected).norm(), 1e-12 * expected.norm());
}

// Split tets make the change indefinite: nothing in the formula minds.
TEST_F(Formula, AnIndefiniteChangeIsExactToo) {
  DenseBase dense = base();
  Correction correction(n);
  Eigen::MatrixXd both = change;
  both.diagonal().array() += 0.5;
  correction.add(dense, {rows(d, d + k), 0, 0.5 * both});
  correction.add(dense, {rows(d, d + k), 0, 0.5 * both});
  ASSERT_TRUE(correction.factor().definite);
  Eigen::MatrixXd left = stiffness;
  left.block(d, d, k, k) += both;
  EXPECT_LT((correction.block(dense, rows(0, n), rows(0, n)) - left.inverse()).norm(), 1e-12 * left.inverse().norm());
}

// The eigenvalue is the smallest of S' against S0: here known, since the change is a multiple of the stiffness itself.
TEST_F(Formula, ReportsTheDigitsItCosts) {
  DenseBase dense = base();
  Correction correction(n);
  correction.add(dense, {rows(0, n), 0, -(1 - 1e-5) * stiffness});
  EXPECT_NEAR(correction.factor().smallest_eigenvalue, 1e-5, 1e-7);
}

TEST_F(Formula, SaysWhenNothingWouldBeLeft) {
  DenseBase dense = base();
  Correction correction(n);
  correction.add(dense, {rows(0, n), 0, -1.1 * stiffness});
  EXPECT_FALSE(correction.factor().definite);
}

// Cholesky succeeds on many hinged parts; the support test must not.
TEST(Support, StaticHingeIsRefusedWithItsName) {
  for (const TetMesh& mesh : {test::two_tets_on_a_vertex(), test::two_tets_on_an_edge()}) {
    TetMesh joined = mesh;
    std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
    for (const VertexId v : mesh.tets[0]) fixed[v.index()] = 1;
    EXPECT_THROW(precompute(Model(joined, {{1, {}}, {2, {}}}, fixed, {0.0})), InputError);
  }
}

TEST(Support, CutThatLeavesAHingeIsRefusedAndChangesNothing) {
  // Two cubes joined by a face; removing all tets of the second cube but the ones at one edge leaves a hinge.
  TetMesh mesh = test::box_mesh(2, 1, 1, {2, 1, 1});
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = mesh.positions[v].x() < 0.5;
  const Model whole(mesh, {{1, {}}}, fixed, {0.0});
  Compliance compliance = precompute(whole);
  const Displacements before = compliance.solve({{VertexId(2), {1, 2, 3}}});
  std::size_t refused = 0;
  for (std::size_t kept = 0; kept < mesh.tet_count(); ++kept) {
    TopologyEdit edit;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
      const Tet& tet = mesh.tets[t];
      const bool second = std::any_of(tet.begin(), tet.end(), [&](VertexId v) { return mesh.position(v).x() > 1.5; });
      if (second && t != kept) edit.removed.push_back(TetId(t));
    }
    Model cut = whole;
    const StiffnessChange change = cut.apply(edit);
    if (change.unsupported.empty()) continue;
    ++refused;
    EXPECT_THROW(compliance.update(change), Unsupported);
    EXPECT_EQ(compliance.solve({{VertexId(2), {1, 2, 3}}}), before);
  }
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace calot
