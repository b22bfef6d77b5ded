#include "calot/sim/warped_compliance.h"

#include <gtest/gtest.h>

#include "calot/compliance/compliance.h"
#include "calot/cut/split.h"
#include "calot/mesh/parts.h"
#include "calot/sim/element_changes.h"
#include "tests/support/edits.h"
#include "tests/support/models.h"

namespace calot {
namespace {

using test::Random;

BaseRequest request_of(const Model& model) {
  return {model,
          std::vector<Eigen::Quaterniond>(model.mesh().tet_count(), Eigen::Quaterniond::Identity()),
          {},
          {},
          nullptr};
}

std::vector<Eigen::Quaterniond> no_turn(const Model& model) {
  return std::vector<Eigen::Quaterniond>(model.mesh().vertex_count(), Eigen::Quaterniond::Identity());
}

WarpedCompliance ready(const BaseRequest& request) {
  WarpedCompliance compliance(request);
  compliance.set_base(make_base(request));
  compliance.settle();
  compliance.turn(vertex_rotations(vertex_tets(request.model.mesh()), request.rotations));
  return compliance;
}

std::vector<Vec3> random_forces(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> f(count);
  for (Vec3& v : f) v = Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  return f;
}

double difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0, size = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    worst = std::max(worst, (a[v] - b[v]).norm());
    size = std::max(size, b[v].norm());
  }
  return worst / size;
}

std::vector<Vec3> solve_exactly(const Model& model, const std::vector<Vec3>& f) {
  const Compliance compliance = precompute(model, {.backend = Backend::sparse});
  Eigen::MatrixXd forces(3 * static_cast<Eigen::Index>(f.size()), 1);
  for (std::size_t v = 0; v < f.size(); ++v) forces.block<3, 1>(3 * static_cast<Eigen::Index>(v), 0) = f[v];
  const Eigen::MatrixXd u = compliance.apply(forces);
  std::vector<Vec3> x(f.size());
  for (std::size_t v = 0; v < f.size(); ++v) x[v] = u.block<3, 1>(3 * static_cast<Eigen::Index>(v), 0);
  return x;
}

std::vector<Vec3> answer(WarpedCompliance& compliance, const std::vector<Vec3>& f) {
  std::vector<Vec3> x(f.size());
  compliance.apply(f, x);
  return x;
}

void edit(Model& model, const TopologyEdit& topology, std::vector<WarpedCompliance*> followers) {
  const ChangedTets changed = changed_tets(topology, vertex_tets(model.mesh()));
  std::vector<ElementChange> elements = leaving(model, changed);
  const StiffnessChange change = model.apply(topology);
  add_entering(model, change.remap, changed, elements);
  for (WarpedCompliance* follower : followers) follower->follow(elements, change.remap);
}

TEST(WarpedCompliance, AnswersAsTheExactComplianceAtRest) {
  const Model model = test::biliary_model(0.01);
  WarpedCompliance compliance = ready(request_of(model));
  const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), 1);
  EXPECT_LT(difference(answer(compliance, f), solve_exactly(model, f)), 1e-5);
}

TEST(WarpedCompliance, StaysExactThroughRemovals) {
  Model model = test::biliary_model(0.01);
  WarpedCompliance compliance = ready(request_of(model));
  for (std::uint64_t round = 0; round < 6; ++round) {
    edit(model, {test::random_tets(model.mesh(), 12, round + 3), {}, {}, {}}, {&compliance});
    compliance.settle();
    compliance.turn(no_turn(model));
    const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), round);
    EXPECT_LT(difference(answer(compliance, f), solve_exactly(model, f)), 1e-4) << round;
  }
}

TEST(WarpedCompliance, StaysExactThroughEditsOfEveryKind) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Model model = test::biliary_model(0.01);
    WarpedCompliance compliance = ready(request_of(model));
    for (std::uint64_t round = 0; round < 5; ++round) {
      edit(model, test::random_edit(model.mesh(), 6, 100 * seed + round), {&compliance});
      compliance.settle();
      compliance.turn(no_turn(model));
      const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), round);
      EXPECT_LT(difference(answer(compliance, f), solve_exactly(model, f)), 1e-3) << seed << " " << round;
    }
  }
}

// The part that comes off is held by nothing but its mass: the hardest case for single precision. It stays a good
// preconditioner: symmetric, definite and near enough.
TEST(WarpedCompliance, StaysDefiniteWhenAPartComesOff) {
  Model model =
      test::make_model(test::box_mesh(12, 3, 1, Vec3(0.04, 0.008, 0.003)), 1.0 / 60,
                       [](const Vec3& x) { return x.x() < 1e-9; }, {1e6, 0.4, 1000}, {.rayleigh_stiffness = 0.01});
  WarpedCompliance compliance = ready(request_of(model));
  Stroke stroke;
  std::size_t parts = 1;
  for (int k = 0; k < 12; ++k) {
    const double y = -0.0005 + 0.001 * k, before = -0.0006 + 0.001 * (k - 1);
    const Vec3 a(0.0203, before, -0.001), b(0.0203, y, -0.001), c(0.0203, y, 0.004), d(0.0203, before, 0.004);
    SplitOptions options;
    options.stroke = &stroke;
    const SplitEdit cut =
        split(model.mesh(), vertex_tets(model.mesh()), model.mesh().positions, {{{a, b, c}, {a, c, d}}}, options);
    if (cut.empty()) {
      stroke = cut.report.stroke;
      continue;
    }
    const ChangedTets changed = changed_tets(cut, vertex_tets(model.mesh()));
    std::vector<ElementChange> elements = leaving(model, changed);
    const StiffnessChange change = model.apply(cut);
    add_entering(model, change.remap, changed, elements);
    compliance.follow(elements, change.remap);
    stroke = follow(cut.report.stroke, change.remap);
    parts = face_connected_parts(model.mesh()).count();
    compliance.settle();
    compliance.turn(no_turn(model));
    const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), 3), g = random_forces(f.size(), 4);
    const std::vector<Vec3> x = answer(compliance, f), y2 = answer(compliance, g);
    double fy = 0, gx = 0, fx = 0;
    for (std::size_t v = 0; v < f.size(); ++v) {
      fy += f[v].dot(y2[v]);
      gx += g[v].dot(x[v]);
      fx += f[v].dot(x[v]);
    }
    EXPECT_LT(difference(x, solve_exactly(model, f)), 1e-5) << k;
    EXPECT_NEAR(fy, gx, 1e-5 * fx) << k;
    EXPECT_GT(fx, 0) << k;
  }
  EXPECT_EQ(parts, 2u);
}

TEST(WarpedCompliance, EditsBeforeTheBaseIsThereAreTakenInWhenItComes) {
  Model model = test::biliary_model(0.01);
  const BaseRequest request = request_of(model);
  WarpedCompliance late(request);
  for (std::uint64_t round = 0; round < 4; ++round)
    edit(model, {test::random_tets(model.mesh(), 12, round + 3), {}, {}, {}}, {&late});
  late.set_base(make_base(request));
  late.settle();
  late.turn(no_turn(model));
  const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), 5);
  EXPECT_LT(difference(answer(late, f), solve_exactly(model, f)), 1e-4);
}

TEST(WarpedCompliance, TurnsWithTheTissue) {
  const Model model = test::biliary_model(0.01);
  WarpedCompliance compliance = ready(request_of(model));
  const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), 2);
  const std::vector<Vec3> straight = answer(compliance, f);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.0, Vec3(1, 1, 0).normalized()));
  compliance.turn(std::vector<Eigen::Quaterniond>(f.size(), turn));
  std::vector<Vec3> turned = f;
  for (Vec3& v : turned) v = turn * v;
  std::vector<Vec3> result = answer(compliance, turned);
  for (Vec3& v : result) v = turn.conjugate() * v;
  EXPECT_LT(difference(result, straight), 1e-5);
}

TEST(WarpedCompliance, TakesInSpringsThatComeAndGo) {
  const Model model = test::biliary_model(0.01);
  BaseRequest request = request_of(model);
  WarpedCompliance plain = ready(request);
  std::vector<Spring> springs;
  for (std::uint32_t v = 20; v < 26; ++v) {
    Spring s;
    s.vertex = VertexId(v);
    if (v % 2 == 0) s.other = VertexId(v + 60);
    s.stiffness = 500 * Mat3::Identity();
    springs.push_back(s);
  }
  const std::vector<Vec3> f = random_forces(model.mesh().vertex_count(), 3);
  const std::vector<Vec3> without = answer(plain, f);
  request.springs = springs;
  WarpedCompliance with = ready(request);
  plain.set_springs(springs);
  plain.settle();
  EXPECT_LT(difference(answer(plain, f), answer(with, f)), 2e-5);
  plain.set_springs({});
  plain.settle();
  EXPECT_LT(difference(answer(plain, f), without), 2e-5);
  with.set_springs({});
  with.settle();
  EXPECT_LT(difference(answer(with, f), without), 2e-5);
}

ContactRows contact_at(const Tet& tet, Random& random) {
  ContactRows rows;
  rows.count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    rows.vertices[i] = tet[i];
    rows.weights[i] = i == 0 ? 0.5 : 0.25;
  }
  rows.frame =
      Eigen::Quaterniond(random.unit(), random.unit(), random.unit(), random.unit()).normalized().toRotationMatrix();
  return rows;
}

// W against solves of the edited model, each block as a share of the two contacts' own compliance.
double worst_block(const Model& model, const std::vector<ContactRows>& contacts, const Eigen::MatrixXd& w) {
  double worst = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      std::vector<Vec3> f(model.mesh().vertex_count(), Vec3::Zero());
      for (std::size_t i = 0; i < 3; ++i)
        f[contacts[k].vertices[i].index()] += contacts[k].weights[i] * contacts[k].frame.col(c);
      const std::vector<Vec3> u = solve_exactly(model, f);
      for (std::size_t m = 0; m < contacts.size(); ++m) {
        Vec3 moved = Vec3::Zero();
        for (std::size_t i = 0; i < 3; ++i)
          moved += contacts[m].weights[i] * contacts[m].frame.transpose() * u[contacts[m].vertices[i].index()];
        const Eigen::Index column = 3 * static_cast<Eigen::Index>(k) + c, row = 3 * static_cast<Eigen::Index>(m);
        const double scale = std::sqrt(w(column, column) * w.diagonal().segment<3>(row).maxCoeff());
        worst = std::max(worst, (w.block<3, 1>(row, column) - moved).norm() / scale);
      }
    }
  return worst;
}

TEST(WarpedCompliance, DelassusOperatorIsJCJt) {
  Model model = test::biliary_model(0.01);
  WarpedCompliance compliance = ready(request_of(model));
  edit(model, {test::random_tets(model.mesh(), 12, 4), {}, {}, {}}, {&compliance});
  compliance.settle();
  compliance.turn(no_turn(model));
  Random random(4);
  std::vector<ContactRows> contacts;
  for (int k = 0; k < 13; ++k)
    contacts.push_back(contact_at(model.mesh().tets[random.below(model.mesh().tet_count())], random));
  const Eigen::MatrixXd w = compliance.delassus(contacts);
  EXPECT_LT(worst_block(model, contacts, w), 3e-5);
}

// A bar loses a slice: its end hangs on nothing but its mass, and a scrap of one tet flies free. What contacts feel
// there comes out of the correction by cancellation, and would be noise in single precision.
TEST(WarpedCompliance, DelassusOperatorHoldsWhenPartsComeOff) {
  Model model = test::make_model(test::box_mesh(14, 3, 3, Vec3(0.07, 0.015, 0.015)), 1.0 / 60,
                                 [](const Vec3& x) { return x.x() < 1e-9; });
  WarpedCompliance compliance = ready(request_of(model));
  const TetMesh& mesh = model.mesh();
  std::vector<TetId> slice, around_scrap;
  const VertexTets around = vertex_tets(mesh);
  TetId scrap;
  const auto middle = [&](std::size_t t) {
    double x = 0;
    for (const VertexId v : mesh.tets[t]) x += mesh.position(v).x() / 4;
    return x;
  };
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (middle(t) > 0.03 && middle(t) < 0.035) slice.push_back(TetId(t));
    if (middle(t) > 0.065) scrap = TetId(t);
  }
  for (const VertexId v : mesh.tet(scrap))
    for (std::uint32_t k = around.start[v.index()]; k < around.start[v.index() + 1]; ++k)
      if (around.tets[k] != scrap) slice.push_back(around.tets[k]);
  std::sort(slice.begin(), slice.end());
  slice.erase(std::unique(slice.begin(), slice.end()), slice.end());
  edit(model, {slice, {}, {}, {}}, {&compliance});
  ASSERT_EQ(face_connected_parts(model.mesh()).tets.size(), 3u);
  compliance.settle();
  compliance.turn(no_turn(model));
  Random random(6);
  std::vector<ContactRows> contacts;
  for (int k = 0; k < 12; ++k)
    contacts.push_back(contact_at(model.mesh().tets[random.below(model.mesh().tet_count())], random));
  for (std::size_t t = model.mesh().tet_count(); t-- > 0;)
    if (middle(t) > 0.065 && contacts.size() < 14) contacts.push_back(contact_at(model.mesh().tets[t], random));
  EXPECT_LT(worst_block(model, contacts, compliance.delassus(contacts)), 1e-4);
}

}  // namespace
}  // namespace calot
