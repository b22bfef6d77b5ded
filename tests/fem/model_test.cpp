#include "calot/fem/model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "calot/base/error.h"
#include "tests/support/edits.h"
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

// Splits, moves and removals, both lumpings: the change is a fresh assembly's, to the last bit, with nothing left out.
TEST(Model, EditsOfEveryKindChangeTheStiffnessAsAFreshAssemblyWould) {
  for (const MassLumping lumping : {MassLumping::element, MassLumping::uniform})
    for (const double time_step : {0.0, 0.02}) {
      Dynamics d;
      d.mass_lumping = lumping;
      d.rayleigh_stiffness = 0.001;
      Model model = make_model(
          test::biliary_mesh(), time_step, [](const Vec3& p) { return p.x() < 0.011; }, {3e5, 0.45, 1000}, d);
      test::Random random(5);
      for (int step = 0; step < 12; ++step) {
        const BlockMatrix before = model.step_stiffness();
        const TopologyEdit edit = test::random_edit(model.mesh(), 1 + random.below(9), random.next());
        if (edit.empty()) continue;
        const StiffnessChange change = model.apply(edit);
        expect_change_is_fresh(change, before, model);
        EXPECT_EQ(change.added.size(), edit.vertices.size());
        EXPECT_EQ(model.stiffness_scale().size(), model.mesh().tet_count());
        EXPECT_EQ(model.vertex_masses().size(), model.mesh().vertex_count());
        if (HasFailure()) return;
      }
    }
}

TEST(Model, AnAddedVertexIsFixedWhenBothItComesFromAre) {
  const TetMesh mesh = test::two_tets();
  Model model(mesh, {{1, {}}, {2, {}}}, {1, 1, 0, 0, 0}, {});
  const StiffnessChange change = model.apply(test::bisect_edges(mesh, {{VertexId(0), VertexId(1), 0.5}}));
  EXPECT_EQ(change.added_fixed, (std::vector<std::uint8_t>{1}));
  EXPECT_EQ(model.fixed(), (std::vector<std::uint8_t>{1, 1, 0, 0, 0, 1}));
  EXPECT_EQ(model.apply(test::bisect_edges(model.mesh(), {{VertexId(0), VertexId(2), 0.5}})).added_fixed,
            (std::vector<std::uint8_t>{0}));
}

// By hand: a copy takes half, a vertex at 1/4 of an edge takes by its weights; what a lost vertex had goes to its
// copies.
TEST(Model, UniformSharesPassToAddedVertices) {
  const TetMesh mesh = test::two_tets();
  Dynamics d;
  d.mass_lumping = MassLumping::uniform;
  const Model whole(mesh, {{1, {}}, {2, {}}}, std::vector<std::uint8_t>(5, 0), d, 5.0);
  Model bisected = whole;
  bisected.apply(test::bisect_edges(mesh, {{VertexId(0), VertexId(3), 0.25}}));
  const std::vector<double> expected{1 / 1.75, 1, 1, 1 / 1.25, 1, 0.75 / 1.75 + 0.25 / 1.25};
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(bisected.vertex_masses()[v], expected[v], 1e-15);
  EXPECT_FALSE(bisected.has_even_masses());
  EXPECT_NE(bisected.fingerprint(), whole.fingerprint());

  Model replaced = whole;  // both tets get copies of vertex 0, which goes
  TopologyEdit edit;
  edit.removed = {TetId(0), TetId(1)};
  for (std::size_t t = 0; t < 2; ++t) {
    edit.vertices.push_back({mesh.positions[0], VertexId(0), VertexId(0), 0});
    Tet tet = mesh.tets[t];
    std::replace(tet.begin(), tet.end(), VertexId(0), VertexId(5 + t));
    edit.tets.push_back({tet, TetId(t)});
  }
  replaced.apply(edit);
  const std::vector<double> after{1, 1, 1, 1, 0.5, 0.5};
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(replaced.vertex_masses()[v], after[v], 1e-15);
}

TEST(Model, ScaledStiffnessIsThatOfAnotherMaterial) {
  const TetMesh mesh = test::two_tets();
  const std::vector<std::uint8_t> fixed(5, 0);
  Model model(mesh, {{1, {1e5, 0.4, 1000}}, {2, {1e5, 0.4, 1000}}}, fixed, {});
  const Model softer(mesh, {{1, {1e5, 0.4, 1000}}, {2, {2.5e4, 0.4, 1000}}}, fixed, {});
  const BlockMatrix before = model.step_stiffness(), expected = softer.step_stiffness();
  const std::string plain = model.fingerprint();
  const StiffnessChange change = model.scale_stiffness(std::vector{TetId(1)}, std::vector{0.25});
  EXPECT_EQ(change.touched.size(), 4u);
  expect_change_is_fresh(change, before, model);
  const BlockMatrix found = model.step_stiffness();
  for (std::size_t k = 0; k < found.block.size(); ++k)
    EXPECT_LT((found.block[k] - expected.block[k]).norm(), 1e-12 * expected.block[k].norm());
  EXPECT_NE(model.fingerprint(), plain);
  EXPECT_TRUE(model.scale_stiffness(std::vector{TetId(1)}, std::vector{0.25}).entries.empty()) << "nothing new";
  (void)model.scale_stiffness(std::vector{TetId(1)}, std::vector{1.0});
  EXPECT_EQ(model.fingerprint(), plain);
  (void)model.scale_stiffness(std::vector{TetId(0)}, std::vector{3.0});
  model.apply(test::bisect_edges(model.mesh(), {{VertexId(0), VertexId(3), 0.5}}));
  EXPECT_EQ(model.stiffness_scale(), (std::vector<double>{1, 3, 3}));
}

TEST(Model, RefusesBadFactorsAndMassesAndStaysAsItWas) {
  Model model = test::biliary_model(0.02);
  const std::string before = model.fingerprint();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](std::vector<TetId> tets, std::vector<double> factors) {
    EXPECT_THROW(model.scale_stiffness(tets, factors), InputError);
    EXPECT_EQ(model.fingerprint(), before);
  };
  refused({TetId(0)}, {});
  refused({TetId(0), TetId(model.mesh().tet_count())}, {2, 2});
  refused({TetId(1), TetId(0)}, {2, 2});
  refused({TetId(0), TetId(0)}, {2, 2});
  refused({TetId(0), TetId(1)}, {2, 0});
  refused({TetId(0), TetId(1)}, {2, nan});
  EXPECT_THROW(model.set_vertex_masses(std::vector<double>(model.mesh().vertex_count(), 1)), InputError);
  EXPECT_THROW(model.apply({{TetId(model.mesh().tet_count())}, {}, {}}), InputError);
  EXPECT_EQ(model.fingerprint(), before);
}

TEST(BlockMatrix, GrowsInPlace) {
  test::Random random(9);
  for (int round = 0; round < 20; ++round) {
    const std::size_t n = 1 + random.below(12), larger = n + random.below(4);
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> entries;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> fresh;
    BlockMatrix matrix;
    matrix.row_start.push_back(0);
    for (std::uint32_t row = 0; row < larger; ++row) {
      for (std::uint32_t column = 0; column < larger; ++column) {
        if (random.below(3) == 0 && row < n && column < n) {
          entries[{row, column}] = random.unit();
          matrix.column.push_back(column);
          matrix.block.push_back(Mat3::Constant(entries[{row, column}]));
        } else if (random.below(4) == 0) {
          fresh.emplace_back(row, column);
        }
      }
      if (row < n) matrix.row_start.push_back(static_cast<std::uint32_t>(matrix.column.size()));
    }
    matrix.grow(larger, fresh);
    ASSERT_EQ(matrix.rows(), larger);
    EXPECT_EQ(matrix.column.size(), entries.size() + fresh.size());
    for (const auto& place : fresh) entries[place] = 0;
    for (const auto& [place, value] : entries) {
      ASSERT_NE(matrix.find(place.first, place.second), nullptr);
      EXPECT_EQ(*matrix.find(place.first, place.second), Mat3::Constant(value));
    }
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
