#include "calot/compliance/inverse.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "calot/base/error.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

Eigen::MatrixXd dense_of(const BlockMatrix& matrix) {
  const auto n = static_cast<Eigen::Index>(3 * matrix.rows());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t row = 0; row < matrix.rows(); ++row)
    for (std::uint32_t k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
      dense.block<3, 3>(static_cast<Eigen::Index>(3 * row), 3 * Eigen::Index{matrix.column[k]}) = matrix.block[k];
  return dense;
}

// Â C = I over the free degrees of freedom, zero rows and columns at the fixed ones, and C exactly symmetric.
TEST(Inverse, StiffnessTimesComplianceIsIdentity) {
  for (const double h : {0.0, 0.02}) {
    const Model model = test::biliary_model(h);
    const FullCompliance full = precompute(model).full();
    const auto n = static_cast<Eigen::Index>(full.size());
    const Eigen::MatrixXd c = Eigen::Map<const Eigen::MatrixXd>(full.values.data(), n, n);
    EXPECT_EQ(c, c.transpose());
    const Eigen::MatrixXd product = dense_of(model.step_stiffness()) * c;
    for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
      for (std::size_t u = 0; u < model.mesh().vertex_count(); ++u) {
        const auto r = static_cast<Eigen::Index>(3 * v), s = static_cast<Eigen::Index>(3 * u);
        if (model.is_fixed(VertexId(v)) || model.is_fixed(VertexId(u))) {
          EXPECT_TRUE((c.block<3, 3>(r, s).isZero(0)));
          continue;
        }
        const Mat3 expected = v == u ? Mat3(Mat3::Identity()) : Mat3(Mat3::Zero());
        EXPECT_LT((product.block<3, 3>(r, s) - expected).norm(), 1e-8);
      }
  }
}

// Eigen's dense Cholesky knows nothing of supernodes.
TEST(Inverse, AgreesWithADenseInverse) {
  const Model model = test::make_model(test::bar_mesh(6), 0.01, [](const Vec3& p) { return p.x() < 1e-9; });
  const FullCompliance full = precompute(model).full();
  const auto n = static_cast<Eigen::Index>(full.size());
  Eigen::MatrixXd a = dense_of(model.step_stiffness());
  for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
    if (model.is_fixed(VertexId(v))) {
      const auto r = static_cast<Eigen::Index>(3 * v);
      a.middleRows<3>(r).setZero();
      a.middleCols<3>(r).setZero();
      a.block<3, 3>(r, r).setIdentity();
    }
  Eigen::MatrixXd expected = a.llt().solve(Eigen::MatrixXd::Identity(n, n));
  for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
    if (model.is_fixed(VertexId(v)))
      expected.block<3, 3>(static_cast<Eigen::Index>(3 * v), static_cast<Eigen::Index>(3 * v)).setZero();
  const Eigen::Map<const Eigen::MatrixXd> c(full.values.data(), n, n);
  EXPECT_LT((c - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff());
}

TEST(Inverse, SparseAndDenseHomesAgree) {
  for (const double h : {0.0, 0.02}) {
    const Model model = test::biliary_model(h);
    const Compliance dense = precompute(model, {Backend::dense}), sparse = precompute(model, {Backend::sparse});
    EXPECT_GT(sparse.factor_nonzeros(), 0u);
    const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count());
    EXPECT_LT(test::worst_column(dense, sparse, dofs), 1e-10);
    const Eigen::MatrixXd a = dense.block(dofs, dofs), b = sparse.block(dofs, dofs);
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-9 * a.cwiseAbs().maxCoeff());
  }
}

// A front large enough to be shared out in tiles: a solid block, whose separators are wide.
TEST(Inverse, LargeFrontsSolveToo) {
  const Model model =
      test::make_model(test::box_mesh(18, 18, 18, {0.1, 0.1, 0.1}), 0.02, [](const Vec3& p) { return p.z() < 1e-9; });
  const Compliance sparse = precompute(model, {Backend::sparse});
  EXPECT_LT(sparse.probe(), 1e-10);
  EXPECT_GE(precompute_memory(model, {Backend::sparse}), sparse.bytes());
}

TEST(Condition, IsThatOfTheMatrix) {
  const Model model = test::make_model(test::bar_mesh(5), 0.01, [](const Vec3&) { return false; });
  const Eigen::MatrixXd a = dense_of(model.step_stiffness());
  const double exact = a.cwiseAbs().colwise().sum().maxCoeff() * a.inverse().cwiseAbs().colwise().sum().maxCoeff();
  const double estimate = precompute(model).condition();
  EXPECT_LE(estimate, 1.001 * exact);  // An estimate from below …
  EXPECT_GE(estimate, 0.3 * exact);    // … that is seldom off by more than three.
}

TEST(Solve, RefusesVerticesThatAreNotThere) {
  const Model model = test::make_model(test::bar_mesh(3), 0.01, [](const Vec3&) { return false; });
  const Compliance compliance = precompute(model);
  EXPECT_THROW((void)compliance.solve({{VertexId(100000), {1, 0, 0}}}), InputError);
  EXPECT_THROW((void)compliance.columns(std::vector<DofId>{DofId(1000000)}), InputError);
}

TEST(Solve, ForcesOnFixedVerticesDoNothing) {
  const Model model = test::make_model(test::bar_mesh(3), 0.0, [](const Vec3& p) { return p.x() < 1e-9; });
  for (const Vec3& u : precompute(model).solve({{VertexId(0), {1, 2, 3}}})) EXPECT_EQ(u, Vec3(0, 0, 0));
}

TEST(Memory, IsCountedBeforeItIsTaken) {
  const Model model = test::biliary_model(0.02);
  const std::uint64_t said = precompute_memory(model, {Backend::dense});
  const Compliance compliance = precompute(model);
  EXPECT_GE(said, compliance.bytes());
  EXPECT_LE(static_cast<double>(said), 2.2 * static_cast<double>(compliance.bytes()));
}

TEST(Progress, StopsCleanlyOnRequest) {
  const Model model = test::biliary_model(0.02);
  int reports = 0;
  Progress* self = nullptr;
  Progress progress([&](const ProgressState&) {
    if (++reports == 5) self->request_stop();
  });
  self = &progress;
  EXPECT_THROW((void)precompute(model, {}, &progress), Interrupted);
}

}  // namespace
}  // namespace calot
