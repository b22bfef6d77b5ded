// The compliance through edits of every kind: splits, moves, removals and changes of stiffness, against recomputation.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "calot/base/error.h"
#include "calot/compliance/sparse_factor.h"
#include "calot/mesh/parts.h"
#include "tests/support/accuracy.h"
#include "tests/support/edits.h"

namespace calot {
namespace {

struct Case {
  double time_step;
  Backend backend;
};

std::string name_of(const testing::TestParamInfo<Case>& tested) {
  return std::string(tested.param.backend == Backend::dense ? "dense" : "sparse") + "_" +
         std::to_string(static_cast<int>(tested.param.time_step * 1000)) + "ms";
}

const auto every_case = testing::Values(
    Case{0, Backend::dense}, Case{0.005, Backend::dense}, Case{0.02, Backend::dense}, Case{0.1, Backend::dense},
    Case{0, Backend::sparse}, Case{0.005, Backend::sparse}, Case{0.02, Backend::sparse}, Case{0.1, Backend::sparse});

/// A compliance and the model it follows.
struct Followed {
  Model model;
  Compliance compliance;
  std::vector<VertexId> face = {};  // vertices near the last edit

  explicit Followed(Model m, Backend backend) : model(std::move(m)), compliance(precompute(model, {backend})) {}

  /// @return whether it could be done; a static model must refuse to lose a part, and stays as it was
  bool edit(const TopologyEdit& what) {
    Model changed = model;
    const StiffnessChange change = changed.apply(what);
    if (!change.unsupported.empty()) {
      const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count());
      const Eigen::MatrixXd before = compliance.block(dofs, dofs);
      EXPECT_THROW(compliance.update(change), Unsupported);
      EXPECT_EQ(compliance.block(dofs, dofs), before);
      return false;
    }
    compliance.update(change);
    model = std::move(changed);
    face = test::cut_face(change);
    face.insert(face.end(), change.added.begin(), change.added.end());
    EXPECT_EQ(compliance.vertex_count(), model.mesh().vertex_count());
    return true;
  }

  /// Columns, the block answered at once, and the drift, against a recomputation.
  void expect_exact(Backend backend) const {
    const Compliance reference = precompute(model, {backend});
    std::vector<VertexId> near;
    for (std::size_t k = 0; k < face.size() && near.size() < 12; k += 1 + face.size() / 12) near.push_back(face[k]);
    const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count(), near);
    const double allowed = test::bound(reference);
    EXPECT_LE(test::worst_column(compliance, reference, dofs), allowed);
    const Eigen::MatrixXd block = compliance.block(dofs, dofs), exact = reference.columns(dofs);
    for (std::size_t j = 0; j < dofs.size(); ++j)
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(j);
        EXPECT_NEAR(block(r, c), exact(dofs[i].value, c), 10 * allowed * exact.col(c).cwiseAbs().maxCoeff() + 1e-300);
      }
    EXPECT_LE(compliance.probe(), 10 * allowed);
  }
};

class AnyEdit : public testing::TestWithParam<Case> {
 protected:
  [[nodiscard]] Followed biliary() const { return Followed(test::biliary_model(GetParam().time_step), backend()); }
  [[nodiscard]] Followed block() const {
    return Followed(
        test::make_model(test::box_mesh(5, 4, 4, {0.05, 0.04, 0.04}, test::CubeSplit::five), GetParam().time_step,
                         [](const Vec3& p) { return p.x() < 1e-9; }, {8e4, 0.45, 1060}),
        backend());
  }
  [[nodiscard]] Backend backend() const { return GetParam().backend; }
};

TEST_P(AnyEdit, ABisectedEdge) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Followed one = biliary();
    ASSERT_TRUE(one.edit(test::random_bisections(one.model.mesh(), seed * seed, seed)));
    one.expect_exact(backend());
    one.compliance.fold();
    EXPECT_EQ(one.compliance.pending_rank(), 0u);
    one.expect_exact(backend());
  }
}

TEST_P(AnyEdit, MovedVertices) {
  Followed one = block();
  ASSERT_TRUE(one.edit(test::random_moves(one.model.mesh(), 12, 4)));
  one.expect_exact(backend());
  ASSERT_TRUE(one.edit(test::random_moves(one.model.mesh(), 12, 5)));
  one.expect_exact(backend());
}

// The duct comes apart along faces; nothing is removed, and the severed part is a part of its own.
TEST_P(AnyEdit, APartSplitOff) {
  Followed one = biliary();
  std::vector<std::uint8_t> above(one.model.mesh().tet_count(), 0);
  for (const TetId t : test::tets_where(one.model.mesh(), [](const Vec3& c) { return c.x() > 0.0195; }))
    above[t.index()] = 1;
  const TopologyEdit split = test::separate(one.model.mesh(), above);
  ASSERT_GT(split.vertices.size(), 8u);
  if (!one.edit(split)) {
    EXPECT_EQ(GetParam().time_step, 0) << "only a static part can lose its support";
    one.expect_exact(backend());
    return;
  }
  EXPECT_EQ(face_connected_parts(one.model.mesh()).count(), 2u);
  one.expect_exact(backend());
  const TetMesh& mesh = one.model.mesh();
  VertexId left;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (!one.model.is_fixed(VertexId(v)) && mesh.positions[v].x() < 0.012) left = VertexId(v);
  const Displacements u = one.compliance.solve({{left, {0.1, 0.2, -0.3}}});
  EXPECT_GT(u[left.index()].norm(), 0);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.positions[v].x() > 0.0205) {
      EXPECT_EQ(u[v], Vec3(0, 0, 0));
    }
}

// Random edits of every kind in any order, folds begun and adopted at any moment.
TEST_P(AnyEdit, RandomSequencesWithFoldsAtAnyMoment) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Followed one = seed % 2 == 0 ? block() : biliary();
    test::Random random(seed * 77);
    for (int step = 0; step < 18; ++step) {
      one.edit(test::random_edit(one.model.mesh(), 1 + random.below(8), random.next()));
      if (random.below(4) == 0) one.compliance.start_fold();
      if (random.below(5) == 0) one.compliance.adopt_fold();
      if (random.below(9) == 0) one.compliance.fold();
      if (step % 6 == 5) one.expect_exact(backend());
      if (HasFailure()) return;
    }
    one.compliance.adopt_fold();
    one.expect_exact(backend());
    one.compliance.fold();
    one.expect_exact(backend());
    one.edit(test::random_edit(one.model.mesh(), 5, 5));
    one.compliance.refresh();
    EXPECT_EQ(one.compliance.pending_rank(), 0u);
    one.expect_exact(backend());
  }
}

// Heat softens and hardens tets; the shape stays.
TEST_P(AnyEdit, ScaledStiffness) {
  Followed one = biliary();
  test::Random random(3);
  for (int step = 0; step < 4; ++step) {
    const std::vector<TetId> tets = test::random_tets(one.model.mesh(), 30, random.next());
    std::vector<double> factors;
    for (std::size_t k = 0; k < tets.size(); ++k) factors.push_back(random.between(0.2, 6));
    one.compliance.update(one.model.scale_stiffness(tets, factors));
    if (step == 1) one.edit(test::random_bisections(one.model.mesh(), 5, 9));  // pieces inherit the factor
    if (step == 2) one.compliance.start_fold();
  }
  one.expect_exact(backend());
  one.compliance.adopt_fold();
  one.expect_exact(backend());
}

INSTANTIATE_TEST_SUITE_P(EveryStep, AnyEdit, every_case, name_of);

class Homes : public testing::TestWithParam<Backend> {};

// A crumb of a few tets answers from an inverse of its own; bisected until it is too large for that, it comes back.
TEST_P(Homes, AnIslandThatGrowsTooLargeIsAnsweredByTheBaseAgain) {
  Followed one(test::biliary_model(0.02), GetParam());
  const auto between = [](double low, double high) {
    return [=](const Vec3& c) { return c.x() > low && c.x() < high; };
  };
  std::vector<TetId> both = test::tets_where(one.model.mesh(), between(0.0145, 0.0205));
  const std::vector<TetId> right = test::tets_where(one.model.mesh(), between(0.0245, 0.0305));
  both.insert(both.end(), right.begin(), right.end());
  std::sort(both.begin(), both.end());
  ASSERT_TRUE(one.edit({both, {}, {}}));
  one.compliance.start_fold();
  test::Random random(8);
  std::size_t largest_crumb = 0;
  for (int step = 0; step < 60 && largest_crumb <= 80; ++step) {
    const TetMesh& mesh = one.model.mesh();
    const std::vector<TetId> crumb = test::tets_where(mesh, between(0.0205, 0.0245));
    std::vector<test::EdgeCut> edges;
    for (int k = 0; k < 4; ++k) {
      const Tet& tet = mesh.tet(crumb[random.below(crumb.size())]);
      edges.push_back({tet[0], tet[1 + random.below(3)], 0.5});
    }
    ASSERT_TRUE(one.edit(test::bisect_edges(mesh, edges)));
    if (step % 5 == 2) one.expect_exact(GetParam());
    if (step == 9) one.compliance.adopt_fold();
    if (step == 11) one.compliance.start_fold();
    for (const std::vector<VertexId>& part : face_connected_parts(one.model.mesh()).vertices)
      if (std::all_of(part.begin(), part.end(),
                      [&](VertexId v) { return std::abs(one.model.mesh().position(v).x() - 0.0225) < 0.0026; }))
        largest_crumb = std::max(largest_crumb, part.size());
  }
  EXPECT_GT(largest_crumb, 64u);
  one.expect_exact(GetParam());
  one.compliance.adopt_fold();
  one.expect_exact(GetParam());
  one.compliance.fold();
  one.expect_exact(GetParam());
}

// Pieces that an edit joins again: no blade does it, but the arithmetic must not care.
TEST_P(Homes, AnIslandThatIsJoinedAgain) {
  const Model whole = test::make_model(test::bar_mesh(8), 0.02, [](const Vec3& p) { return p.x() < 1e-9; });
  Followed one(whole, GetParam());
  std::vector<std::uint8_t> above(one.model.mesh().tet_count(), 0);
  for (const TetId t : test::tets_where(one.model.mesh(), [](const Vec3& c) { return c.x() > 0.0625; }))
    above[t.index()] = 1;
  const TopologyEdit split = test::separate(one.model.mesh(), above);
  ASSERT_EQ(split.vertices.size(), 9u);
  const std::size_t n = one.model.mesh().vertex_count();
  ASSERT_TRUE(one.edit(split));
  one.expect_exact(GetParam());
  // The copies are n … n + 8; their tets are made anew from the originals.
  TopologyEdit joined;
  for (std::size_t t = 0; t < one.model.mesh().tet_count(); ++t) {
    Tet tet = one.model.mesh().tets[t];
    if (std::none_of(tet.begin(), tet.end(), [&](VertexId v) { return v.index() >= n; })) continue;
    for (VertexId& v : tet)
      if (v.index() >= n) v = split.vertices[v.index() - n].from;
    joined.removed.emplace_back(t);
    joined.tets.push_back({tet, TetId(t)});
  }
  ASSERT_TRUE(one.edit(joined));
  EXPECT_EQ(one.model.mesh().vertex_count(), n);
  one.expect_exact(GetParam());
  const Compliance original = precompute(whole, {GetParam()});
  const std::vector<DofId> dofs = test::sample_dofs(n);
  EXPECT_LE(test::worst_column(one.compliance, original, dofs), test::bound(original));
  one.compliance.fold();
  one.expect_exact(GetParam());
}

// Many more edits than there were vertices: what they leave behind does not pile up, and answers stay exact.
TEST_P(Homes, LongSequencesStayExactAndSmall) {
  Followed one(test::make_model(test::box_mesh(3, 2, 2, {0.03, 0.02, 0.02}), 0.02,
                                [](const Vec3& p) { return p.x() < 1e-9; }, {8e4, 0.45, 1060}),
               GetParam());
  test::Random random(21);
  for (int step = 0; step < 400; ++step) {
    const std::size_t tets = one.model.mesh().tet_count();
    TopologyEdit edit;
    if (tets > 150)
      edit.removed = test::random_tets(one.model.mesh(), 12, random.next());
    else
      edit = test::random_bisections(one.model.mesh(), 3, random.next());
    one.edit(edit);
    if (step % 8 == 3) one.compliance.start_fold();
    if (step % 8 == 6) one.compliance.adopt_fold();
  }
  one.expect_exact(GetParam());
  one.compliance.fold();
  const std::size_t n = one.model.mesh().vertex_count();
  EXPECT_LT(one.compliance.bytes(), 3 * 9 * (n + 100) * (n + 100) * sizeof(double));
}

// The whole matrix, row by row, after splits: nothing pending, and everything pending.
TEST_P(Homes, TheWholeMatrixAfterSplits) {
  Followed one(test::make_model(test::bar_mesh(4), 0.02, [](const Vec3& p) { return p.x() < 1e-9; }), GetParam());
  ASSERT_TRUE(one.edit(test::random_bisections(one.model.mesh(), 6, 2)));
  ASSERT_TRUE(one.edit(test::random_edit(one.model.mesh(), 5, 12)));
  const Compliance reference = precompute(one.model, {GetParam()});
  const FullCompliance exact = reference.full();
  for (const bool folded : {false, true}) {
    if (folded) one.compliance.fold();
    const FullCompliance found = one.compliance.full();
    ASSERT_EQ(found.vertices, exact.vertices);
    double largest = 0, off = 0;
    for (std::size_t k = 0; k < exact.values.size(); ++k) {
      largest = std::max(largest, std::abs(exact.values[k]));
      off = std::max(off, std::abs(exact.values[k] - found.values[k]));
    }
    EXPECT_LT(off, 1e-9 * largest);
  }
  if (GetParam() == Backend::sparse) {
    const std::vector<VertexId> vertices = one.compliance.factor_vertices();
    std::size_t free = 0;
    for (std::size_t v = 0; v < one.model.mesh().vertex_count(); ++v)
      if (!one.model.is_fixed(VertexId(v))) {
        ASSERT_LT(free, vertices.size());
        EXPECT_EQ(vertices[free++], VertexId(v));
      }
    ASSERT_NE(one.compliance.factor(), nullptr);
    EXPECT_EQ(one.compliance.factor()->pattern().vertices(), free);
  }
}

// The same answers whenever the background is done, also where it analyses anew.
TEST_P(Homes, AnswersDoNotDependOnWhenTheBackgroundIsDone) {
  const auto run = [&](bool wait) {
    Followed one(test::biliary_model(0.02), GetParam());
    const std::vector<DofId> dofs = test::sample_dofs(300);
    std::vector<Eigen::MatrixXd> answers;
    for (std::uint64_t step = 1; step <= 8; ++step) {
      one.edit(test::random_bisections(one.model.mesh(), 4, step));
      if (step == 2) one.compliance.start_fold();
      while (wait && step == 3 && !one.compliance.fold_ready()) {
      }
      if (step == 6) one.compliance.adopt_fold();
      answers.push_back(one.compliance.block(dofs, dofs));
    }
    return answers;
  };
  EXPECT_EQ(run(false), run(true));
}

INSTANTIATE_TEST_SUITE_P(Both, Homes, testing::Values(Backend::dense, Backend::sparse),
                         [](const auto& tested) { return tested.param == Backend::dense ? "dense" : "sparse"; });

// Two tets that share a face come apart: each answers as itself alone, in closed form K⁻¹ of one tet.
TEST(ClosedForm, TwoTetsThatShareAFaceAndAreSplit) {
  for (const MassLumping lumping : {MassLumping::element, MassLumping::uniform}) {
    Dynamics dynamics;
    dynamics.mass_lumping = lumping;
    dynamics.time_step = 0.02;
    const TetMesh mesh = test::two_tets();
    Model model(mesh, {{1, {2e4, 0.4, 1000}}, {2, {5e4, 0.3, 1100}}}, std::vector<std::uint8_t>(mesh.vertex_count(), 0),
                dynamics);
    Compliance compliance = precompute(model);
    TopologyEdit edit;
    edit.removed = {TetId(1)};
    for (int v = 0; v < 3; ++v) edit.vertices.push_back({mesh.position(VertexId(v)), VertexId(v), VertexId(v), 0});
    edit.tets.push_back({{VertexId(5), VertexId(7), VertexId(6), VertexId(4)}, TetId(1)});
    const StiffnessChange change = model.apply(edit);
    compliance.update(change);
    const double whole_share = model.uniform_share();
    double total = 0;
    for (const double m : model.vertex_masses()) total += m;
    EXPECT_NEAR(total, lumping == MassLumping::uniform ? 5 * whole_share : (1000 + 1100) / 6.0, 1e-9);
    for (const TetId t : {TetId(0), TetId(1)}) {
      const Tet& tet = model.mesh().tet(t);
      const Material& material = model.material(t);
      const TetShape shape = tet_shape(model.mesh().position(tet[0]), model.mesh().position(tet[1]),
                                       model.mesh().position(tet[2]), model.mesh().position(tet[3]));
      Eigen::Matrix<double, 12, 12> alone = stiffness(shape, lame(material));
      for (int a = 0; a < 4; ++a) {
        // Uniform: the face's vertices give half of their share away, the two tips keep theirs.
        const bool tip = std::abs(model.mesh().position(tet[static_cast<std::size_t>(a)]).z()) > 0.5;
        const double mass =
            lumping == MassLumping::uniform ? whole_share * (tip ? 1 : 0.5) : material.density * shape.volume / 4;
        alone.diagonal().segment<3>(3 * a).array() += mass / (0.02 * 0.02);
      }
      const Eigen::Matrix<double, 12, 12> expected = alone.inverse();
      std::vector<DofId> dofs;
      for (const VertexId v : tet)
        for (int a = 0; a < 3; ++a) dofs.push_back(dof_of(v, a));
      const Eigen::MatrixXd found = compliance.block(dofs, dofs);
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
    }
  }
}

// Uniform shares through random edits: the mass stays at splits, and the compliance follows.
TEST(UniformMass, SplitsKeepItAndTheComplianceFollows) {
  Dynamics dynamics;
  dynamics.mass_lumping = MassLumping::uniform;
  Followed one(test::make_model(
                   test::box_mesh(4, 3, 3, {0.04, 0.03, 0.03}), 0.02, [](const Vec3& p) { return p.x() < 1e-9; },
                   {8e4, 0.45, 1060}, dynamics),
               Backend::dense);
  const auto total = [&] {
    double sum = 0;
    for (const double m : one.model.vertex_masses()) sum += m;
    return sum;
  };
  const double mass = total();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ASSERT_TRUE(one.edit(seed % 3 == 0 ? test::random_moves(one.model.mesh(), 4, seed)
                                       : test::random_bisections(one.model.mesh(), 5, seed)));
    EXPECT_NEAR(total(), mass, 1e-12 * mass);
  }
  for (const double m : one.model.vertex_masses()) EXPECT_GT(m, 0);
  one.expect_exact(Backend::dense);
  one.compliance.fold();
  one.expect_exact(Backend::dense);
}

// A split that lets a static part go is refused, and nothing has changed; the next edit finds everything as it was.
TEST(StaticSplit, ThatLetsAPartGoIsRefusedAndChangesNothing) {
  Followed one(test::make_model(test::bar_mesh(6), 0, [](const Vec3& p) { return p.x() < 1e-9; }), Backend::dense);
  ASSERT_TRUE(one.edit(test::random_bisections(one.model.mesh(), 3, 1)));
  std::vector<std::uint8_t> above(one.model.mesh().tet_count(), 0);
  for (const TetId t : test::tets_where(one.model.mesh(), [](const Vec3& c) { return c.x() > 0.05; }))
    above[t.index()] = 1;
  EXPECT_FALSE(one.edit(test::separate(one.model.mesh(), above)));
  one.expect_exact(Backend::dense);
  ASSERT_TRUE(one.edit(test::random_bisections(one.model.mesh(), 3, 2)));
  one.expect_exact(Backend::dense);
}

}  // namespace
}  // namespace calot
