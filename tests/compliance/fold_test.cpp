// Background folds: what is answered never depends on when the background is done.
#include <gtest/gtest.h>

#include <algorithm>

#include "calot/mesh/parts.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

class Fold : public testing::TestWithParam<Backend> {
 protected:
  // The answer is that of a recomputation, before the fold and after it, which leaves nothing pending.
  static void expect_right_before_and_after_folding(Compliance& compliance, const Model& model) {
    const Compliance reference = precompute(model, {GetParam()});
    const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count());
    EXPECT_LE(test::worst_column(compliance, reference, dofs), test::bound(reference));
    compliance.fold();
    EXPECT_EQ(compliance.pending_rank(), 0u);
    EXPECT_LE(test::worst_column(compliance, reference, dofs), test::bound(reference));
  }
};

TEST_P(Fold, KeepsTheAnswerAndEndsTheCorrection) {
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {GetParam()});
  compliance.update(model.apply({test::random_tets(model.mesh(), 60, 3), {}, {}}));
  const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count());
  const Eigen::MatrixXd lazy = compliance.columns(dofs);
  EXPECT_GT(compliance.pending_rank(), 0u);
  compliance.fold();
  EXPECT_EQ(compliance.pending_rank(), 0u);
  const Eigen::MatrixXd folded = compliance.columns(dofs);
  EXPECT_LT((lazy - folded).cwiseAbs().maxCoeff(), 1e-9 * lazy.cwiseAbs().maxCoeff());
  EXPECT_LT(compliance.probe(), 1e-9);
}

TEST_P(Fold, CutsDuringAFoldAreKept) {
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {GetParam()});
  compliance.update(model.apply({test::random_tets(model.mesh(), 30, 1), {}, {}}));
  compliance.start_fold();
  compliance.update(model.apply({test::random_tets(model.mesh(), 30, 2), {}, {}}));
  compliance.update(model.apply({test::random_tets(model.mesh(), 30, 3), {}, {}}));
  compliance.adopt_fold();
  EXPECT_GT(compliance.pending_rank(), 0u);
  const Compliance reference = precompute(model, {GetParam()});
  EXPECT_LE(test::worst_column(compliance, reference, test::sample_dofs(model.mesh().vertex_count())),
            test::bound(reference));
}

// The same steps, with a pause before the adoption or without: the same bits.
TEST_P(Fold, AnswersDoNotDependOnWhenTheBackgroundIsDone) {
  const auto run = [&](bool wait) {
    Model model = test::biliary_model(0.02);
    Compliance compliance = precompute(model, {GetParam()});
    const std::vector<DofId> dofs = test::sample_dofs(300);
    std::vector<Eigen::MatrixXd> answers;
    for (std::uint64_t step = 1; step <= 8; ++step) {
      compliance.update(model.apply({test::random_tets(model.mesh(), 8, step), {}, {}}));
      if (step == 2) compliance.start_fold();
      while (wait && step == 3 && !compliance.fold_ready()) {
      }
      if (step == 6) compliance.adopt_fold();
      answers.push_back(compliance.block(dofs, dofs));
    }
    return answers;
  };
  EXPECT_EQ(run(false), run(true));
}

TEST_P(Fold, ASeveredPartDoesNotMoveToTheLastBit) {
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {GetParam()});
  const StiffnessChange change = model.apply(
      {test::tets_where(model.mesh(), [](const Vec3& c) { return c.x() > 0.0145 && c.x() < 0.0205; }), {}, {}});
  compliance.update(change);
  ASSERT_GE(face_connected_parts(model.mesh()).count(), 2u);
  for (const bool folded : {false, true}) {
    if (folded) compliance.fold();
    VertexId left = VertexId::none(), right = VertexId::none();
    for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v) {
      if (model.is_fixed(VertexId(v))) continue;
      if (model.mesh().positions[v].x() < 0.012) left = VertexId(v);
      if (model.mesh().positions[v].x() > 0.026) right = VertexId(v);
    }
    const Displacements u = compliance.solve({{left, {0.1, 0.2, -0.3}}});
    EXPECT_GT(u[left.index()].norm(), 0);
    for (std::size_t v = 0; v < u.size(); ++v)
      if (model.mesh().positions[v].x() > 0.021) {
        EXPECT_EQ(u[v], Vec3(0, 0, 0));
      }
    const DofId a = dof_of(left, 0), b = dof_of(right, 0);
    EXPECT_EQ(compliance.block(std::vector{a}, std::vector{b})(0, 0), 0);
  }
}

TEST_P(Fold, RefreshStartsAfresh) {
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {GetParam()});
  compliance.update(model.apply({test::random_tets(model.mesh(), 60, 9), {}, {}}));
  compliance.refresh();
  EXPECT_EQ(compliance.pending_rank(), 0u);
  EXPECT_LT(compliance.probe(), 1e-10);
}

// A cut that frees half of the organ at a step so long that its mass hardly holds it: a correction would keep few
// digits, so a fresh factor answers until the fold comes.
TEST_P(Fold, AnUpdateThatWouldKeepFewDigitsIsFactoredAnew) {
  Model model = test::biliary_model(1e4);
  Compliance compliance = precompute(model, {GetParam()});
  const StiffnessChange change = model.apply(
      {test::tets_where(model.mesh(), [](const Vec3& c) { return c.x() > 0.0145 && c.x() < 0.0205; }), {}, {}});
  const UpdateReport report = compliance.update(change);
  EXPECT_TRUE(report.refreshed) << report.smallest_eigenvalue;
  EXPECT_EQ(compliance.pending_rank() > 0, GetParam() == Backend::dense);
  expect_right_before_and_after_folding(compliance, model);
}

// Cutting a crumb that was freed before leaves no correction, but the factor that is written must know of it.
TEST_P(Fold, ACutInsideAFreedCrumbIsFoldedToo) {
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {GetParam()});
  const auto beside = [](double low, double high) {
    return [=](const Vec3& c) { return c.x() > low && c.x() < high; };
  };
  std::vector<TetId> both = test::tets_where(model.mesh(), beside(0.0145, 0.0205));
  const std::vector<TetId> right = test::tets_where(model.mesh(), beside(0.0245, 0.0305));
  both.insert(both.end(), right.begin(), right.end());
  std::sort(both.begin(), both.end());
  compliance.update(model.apply({both, {}, {}}));
  compliance.fold();
  const std::vector<TetId> crumb = test::tets_where(model.mesh(), beside(0.0205, 0.0245));
  ASSERT_GT(crumb.size(), 4u);
  compliance.update(model.apply({{crumb[1]}, {}, {}}));
  EXPECT_GT(compliance.pending_rank(), 0u);
  expect_right_before_and_after_folding(compliance, model);
}

INSTANTIATE_TEST_SUITE_P(BothHomes, Fold, testing::Values(Backend::dense, Backend::sparse),
                         [](const auto& tested) { return tested.param == Backend::dense ? "dense" : "sparse"; });

}  // namespace
}  // namespace calot
