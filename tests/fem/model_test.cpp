#include "calot/fem/model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "calot/base/error.h"
#include "tests/support/models.h"

namespace calot {
namespace {

using test::make_model;

const auto nothing_held = [](const Vec3&) { return false; };

/// The vertex of a site, in numbers after the change.
VertexId vertex_of_site(const StiffnessChange& change, std::uint32_t site) {
  return site < change.touched.size() ? change.remap.vertex_to_new[change.touched[site].index()]
                                      : change.added[site - change.touched.size()];
}

// Row by row: what the change says of Â' against a fresh assembly of the cut mesh, to the last bit, and what it says of
// Â' − Â against the matrices before and after. Every block that changed is there.
void expect_change_is_fresh(const StiffnessChange& change, const BlockMatrix& before, const Model& cut) {
  const BlockMatrix fresh = cut.step_stiffness();
  ASSERT_FALSE(change.entries.empty());
  std::set<std::pair<std::uint32_t, std::uint32_t>> told;
  const auto old_of = [&](VertexId v) { return change.remap.vertex_to_old[v.index()]; };
  const auto before_at = [&](VertexId row, VertexId column) -> Mat3 {
    if (!old_of(row).valid() || !old_of(column).valid()) return Mat3::Zero();
    const Mat3* block = before.find(old_of(row).index(), old_of(column).index());
    return block ? *block : Mat3::Zero();
  };
  for (const StiffnessChange::Entry& entry : change.entries) {
    const VertexId row = vertex_of_site(change, entry.row), column = vertex_of_site(change, entry.column);
    told.emplace(row.value, column.value);
    const Mat3* block = fresh.find(row.index(), column.index());
    if (block)
      EXPECT_EQ(*block, entry.block);
    else
      EXPECT_TRUE(entry.block.isZero(0));
    const Mat3 old_block = before_at(row, column);
    EXPECT_LT((entry.block - old_block - entry.change).norm(), 1e-11 * (old_block.norm() + entry.block.norm()));
  }
  for (std::uint32_t row = 0; row < fresh.rows(); ++row)
    for (std::uint32_t k = fresh.row_start[row]; k < fresh.row_start[row + 1]; ++k)
      if (!told.contains({row, fresh.column[k]})) {
        EXPECT_EQ(fresh.block[k], before_at(VertexId(row), VertexId(fresh.column[k]))) << row << ' ' << fresh.column[k];
      }
}

TEST(Model, StepStiffnessCombinesMassAndStiffness) {
  Dynamics d;
  d.rayleigh_mass = 0.7;
  d.rayleigh_stiffness = 0.003;
  const Model model = make_model(test::box_mesh(3, 2, 2, {0.03, 0.02, 0.02}), 0.01, nothing_held, {5e4, 0.4, 1100}, d);
  const BlockMatrix k = model.stiffness(), a = model.step_stiffness();
  const std::vector<double> mass = model.vertex_masses();
  const double h = 0.01;
  for (std::size_t row = 0; row < k.rows(); ++row)
    for (std::uint32_t e = k.row_start[row]; e < k.row_start[row + 1]; ++e) {
      Mat3 expected = (h * h + h * 0.003) / (h * h) * k.block[e];
      if (k.column[e] == row) expected.diagonal().array() += (1 + h * 0.7) * mass[row] / (h * h);
      EXPECT_LT((a.block[e] - expected).norm(), 1e-12 * expected.norm());
    }
}

TEST(Model, MassIsTheVolumeTimesTheDensityHoweverLumped) {
  for (const MassLumping lumping : {MassLumping::element, MassLumping::uniform}) {
    Dynamics d;
    d.mass_lumping = lumping;
    const Model model =
        make_model(test::box_mesh(3, 2, 2, {0.03, 0.02, 0.02}), 0.01, nothing_held, {5e4, 0.4, 1100}, d);
    double sum = 0;
    for (const double m : model.vertex_masses()) sum += m;
    EXPECT_NEAR(sum, 1100 * 0.03 * 0.02 * 0.02, 1e-12);
  }
}

// SOFA's UniformMass: totalMass / number of vertices; a cut takes vertices away, not mass from the others.
TEST(Model, UniformMassLeavesEachSurvivorItsShare) {
  TetMesh mesh = test::box_mesh(4, 2, 2, {0.04, 0.02, 0.02});
  Dynamics d;
  d.mass_lumping = MassLumping::uniform;
  Model model(mesh, {{1, {}}}, std::vector<std::uint8_t>(mesh.vertex_count(), 0), d, 0.45);
  EXPECT_DOUBLE_EQ(model.vertex_masses()[3], 0.45 / 45);
  TopologyEdit edit;
  edit.removed = test::tets_where(mesh, [](const Vec3& c) { return c.x() > 0.03; });
  const BlockMatrix before = model.step_stiffness();
  const StiffnessChange change = model.apply(edit);
  EXPECT_EQ(model.mesh().vertex_count(), 36u);
  EXPECT_DOUBLE_EQ(model.vertex_masses()[3], 0.45 / 45);
  EXPECT_TRUE(model.has_even_masses());
  expect_change_is_fresh(change, before, model);
}

TEST(Model, AnEditChangesTheStiffnessAsAFreshAssemblyWould) {
  Model model = test::biliary_model(0.02);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TopologyEdit edit;
    edit.removed = test::random_tets(model.mesh(), 40, seed);
    const BlockMatrix before = model.step_stiffness();
    const StiffnessChange change = model.apply(edit);
    expect_change_is_fresh(change, before, model);
  }
}

// A linear displacement field has constant stress: no force on any vertex inside.
TEST(Model, PatchTest) {
  TetMesh mesh = test::box_mesh(4, 4, 4, {0.04, 0.04, 0.04});
  test::Random random(3);
  const auto inside = [](const Vec3& p) { return (p.array() > 1e-9).all() && (p.array() < 0.04 - 1e-9).all(); };
  for (Vec3& p : mesh.positions)
    if (inside(p)) p += Vec3(random.between(-2e-3, 2e-3), random.between(-2e-3, 2e-3), random.between(-2e-3, 2e-3));
  const Model model = make_model(mesh, 0.0, nothing_held, {3e5, 0.45, 1000});
  const BlockMatrix k = model.stiffness();
  Mat3 gradient;
  gradient << 0.01, 0.002, -0.003, 0.004, -0.006, 0.001, 0.0, 0.005, 0.008;
  std::vector<double> u(3 * mesh.vertex_count()), f(u.size());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    Eigen::Map<Vec3>(u.data() + 3 * v) = gradient * mesh.positions[v] + Vec3(1e-3, 0, 2e-3);
  k.multiply(u, f);
  double largest = 0;
  for (const double value : f) largest = std::max(largest, std::abs(value));
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (inside(mesh.positions[v])) {
      EXPECT_LT(Eigen::Map<Vec3>(f.data() + 3 * v).norm(), 1e-11 * largest);
    }
}

TEST(Model, RefusesWhatHasNoMeaning) {
  const TetMesh mesh = test::box_mesh(1, 1, 1, {1, 1, 1});
  const std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Material& m :
       {Material{0, 0.3, 1000}, Material{-1, 0.3, 1000}, Material{nan, 0.3, 1000}, Material{1e6, 0.5, 1000},
        Material{1e6, -1, 1000}, Material{1e6, nan, 1000}, Material{1e6, 0.3, 0}, Material{1e6, 0.3, nan}})
    EXPECT_THROW(Model(mesh, {{1, m}}, fixed, {}), InputError);
  EXPECT_THROW(Model(mesh, {}, fixed, {}), InputError);
  EXPECT_THROW(Model(mesh, {{1, {}}}, {0, 1}, {}), InputError);
  EXPECT_THROW(Model(TetMesh{}, {{1, {}}}, {}, {}), InputError);
  EXPECT_THROW(Model(mesh, {{1, {}}}, fixed, {-0.01}), InputError);
  EXPECT_THROW(Model(mesh, {{1, {}}}, fixed, {0.01, nan}), InputError);
  EXPECT_THROW(Model(mesh, {{1, {}}}, fixed, {}, 2.0), InputError);  // total_mass without uniform lumping
}

TEST(Model, FingerprintKnowsWhatMatters) {
  const Model model = test::biliary_model(0.02);
  EXPECT_EQ(model.fingerprint(), Model(model).fingerprint());
  EXPECT_NE(model.fingerprint(), test::biliary_model(0.01).fingerprint());
  Model cut = model;
  cut.apply({test::random_tets(model.mesh(), 1, 5), {}, {}});
  EXPECT_NE(model.fingerprint(), cut.fingerprint());
}

}  // namespace
}  // namespace calot
