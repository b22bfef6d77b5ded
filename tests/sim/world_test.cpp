#include "calot/sim/world.h"

#include <gtest/gtest.h>

#include "calot/base/parallel.h"
#include "calot/compliance/compliance.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "tests/support/models.h"

namespace calot {
namespace {

WorldSetup setup_of(Model model) {
  std::map<std::int32_t, TissueProperties> properties = tissue_properties(model.mesh());
  WorldSetup setup{std::move(model), std::move(properties), {}, {}, {}, {}};
  setup.options.fluids = false;
  return setup;
}

Model soft_box(int cells, const Vec3& size, double young, const std::function<bool(const Vec3&)>& held,
               double step = 1.0 / 60) {
  Dynamics dynamics;
  dynamics.rayleigh_stiffness = 0.01;
  return test::make_model(test::box_mesh(cells, cells, cells, size), step, held, {young, 0.4, 1000}, dynamics);
}

double speed(const World& world) {
  double most = 0;
  for (const Vec3& v : world.state().velocities) most = std::max(most, v.norm());
  return most;
}

TEST(World, SettlesWhereSolveSaysItDoes) {
  // Stiff enough that the linear answer is the true one to a part in ten thousand.
  Model model = soft_box(4, Vec3(0.02, 0.02, 0.04), 2e6, [](const Vec3& x) { return x.z() < 1e-9; });
  const Model at_rest(model.mesh(), model.materials(), model.fixed(), {.time_step = 0});
  const Compliance compliance = precompute(at_rest);
  const std::vector<double> masses = model.vertex_masses();
  std::vector<PointForce> weight;
  for (std::size_t v = 0; v < masses.size(); ++v) weight.push_back({VertexId(v), Vec3(0, -9.81, 0) * masses[v]});
  const Displacements expected = compliance.solve(weight);
  WorldSetup setup = setup_of(std::move(model));
  setup.options.gravity = Vec3(0, -9.81, 0);
  setup.options.solver = {1e-9, 60};
  World world(std::move(setup));
  for (int k = 0; k < 600; ++k) world.step({});
  EXPECT_LT(speed(world), 1e-7);
  double worst = 0, size = 0;
  for (std::size_t v = 0; v < masses.size(); ++v) {
    const Vec3 u = world.state().positions[v] - world.model().mesh().positions[v];
    worst = std::max(worst, (u - expected[v]).norm());
    size = std::max(size, u.norm());
  }
  EXPECT_GT(size, 1e-6);
  EXPECT_LT(worst, 1e-3 * size);
}

TEST(World, FreeTissueFalls) {
  WorldSetup setup = setup_of(soft_box(2, Vec3(0.02, 0.02, 0.02), 1e4, [](const Vec3&) { return false; }));
  World world(std::move(setup));
  const int steps = 12;
  for (int k = 0; k < steps; ++k) world.step({});
  // Implicit Euler: v_n = n h g, and the sum of its steps; no force inside, no drag.
  const double h = 1.0 / 60, fallen = 9.81 * h * h * steps * (steps + 1) / 2;
  for (std::size_t v = 0; v < world.state().positions.size(); ++v) {
    const Vec3 u = world.state().positions[v] - world.model().mesh().positions[v];
    EXPECT_NEAR(u.z(), -fallen, 1e-4 * fallen);
    EXPECT_NEAR(world.state().velocities[v].z(), -9.81 * h * steps, 1e-4);
  }
}

TEST(World, GravityMovesWhatIsNotCarriedOnly) {
  TetMesh mesh = test::box_mesh(4, 2, 2, Vec3(0.04, 0.02, 0.02));
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.position(mesh.tets[t][0]).x() + mesh.position(mesh.tets[t][3]).x() > 0.0399) mesh.regions[t] = 2;
  const std::vector<std::uint8_t> free(mesh.vertex_count(), 0);
  const Material soft{1e4, 0.4, 1000};
  WorldSetup setup = setup_of(Model(mesh, {{1, soft}, {2, soft}}, free, {.time_step = 1.0 / 60}));
  setup.options.carried = {2};
  Spring hair;  // holds it, and hardly pulls: what nothing holds would feel all its weight
  hair.vertex = VertexId(0);
  hair.anchor = mesh.positions[0];
  hair.stiffness = 1e-9 * Mat3::Identity();
  setup.ligaments = {hair};
  double carried = 0, whole = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    (mesh.regions[t] == 2 ? carried : whole) += signed_volume(mesh, TetId(t));
  whole += carried;
  World world(std::move(setup));
  const double energy = world.energy();
  world.step({});
  // The momentum of all is what gravity gave to the rest.
  Vec3 momentum = Vec3::Zero();
  const std::vector<double> masses = world.model().vertex_masses();
  for (std::size_t v = 0; v < masses.size(); ++v) momentum += masses[v] * world.state().velocities[v];
  EXPECT_GT(carried, 0.3 * whole);
  EXPECT_NEAR(momentum.z(), -9.81 / 60 * 1000 * (whole - carried), 1e-4 * momentum.norm());
  EXPECT_LE(world.energy(), energy);
}

TEST(World, EnergyDoesNotGrowWithoutWork) {
  WorldSetup setup = setup_of(soft_box(3, Vec3(0.02, 0.02, 0.06), 5e3, [](const Vec3& x) { return x.z() < 1e-9; }));
  setup.options.tearing = false;
  setup.options.gravity = Vec3(0, -9.81, 0);
  World world(std::move(setup));
  double energy = world.energy();
  const double scale = std::abs(energy) + 1e-6;
  for (int k = 0; k < 120; ++k) {
    world.step({});
    const double now = world.energy();
    EXPECT_LT(now, energy + 1e-4 * scale) << k;
    energy = now;
  }
}

InstrumentSetup instrument(InstrumentKind kind, const Vec3& at, const Vec3& towards, double opening) {
  InstrumentSetup setup;
  setup.name = std::string(name_of(kind));
  setup.geometry = instrument_geometry(kind);
  setup.start.pose.position = at;
  setup.start.pose.rotation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), towards);
  setup.start.opening = opening;
  return setup;
}

std::vector<std::optional<InstrumentInput>> inputs_of(const std::vector<InstrumentInput>& given) {
  return {given.begin(), given.end()};
}

TEST(World, ABluntToolPushesTissueAndNeverPassesThroughIt) {
  WorldSetup setup = setup_of(soft_box(6, Vec3(0.04, 0.04, 0.02), 8e3, [](const Vec3& x) { return x.z() < 1e-9; }));
  setup.options.gravity.setZero();
  setup.instruments.push_back(instrument(InstrumentKind::suction, Vec3(0.02, 0.02, 0.03), -Vec3::UnitZ(), 0));
  InstrumentInput input = setup.instruments[0].start;
  World world(std::move(setup));
  for (int k = 0; k < 60; ++k) {
    input.pose.position.z() -= 2.5e-4;
    const StepReport& report = world.step(inputs_of({input}));
    EXPECT_TRUE(report.friction.converged) << k << " residual " << report.friction.residual;
    EXPECT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
    EXPECT_TRUE(report.response.converged) << k << " " << report.response.residual;
    EXPECT_FALSE(report.ran_away);
  }
  EXPECT_GT(world.contacts().size(), 0u);
  // Pressed from above: the tool is pushed back up.
  EXPECT_GT(world.instruments()[0].force.z(), 0.05);
  double lowest = 1;
  for (const TissueContact& contact : world.contacts()) lowest = std::min(lowest, contact.gap);
  EXPECT_GT(lowest, -5e-4);
}

TEST(World, ScissorsPartASlabAndAFreePartFalls) {
  WorldSetup setup = setup_of(test::make_model(test::box_mesh(12, 3, 1, Vec3(0.04, 0.008, 0.003)), 1.0 / 60,
                                               [](const Vec3& x) { return x.x() < 1e-9; }, {1e6, 0.4, 1000},
                                               {.rayleigh_stiffness = 0.01}));
  setup.options.gravity = Vec3(0, 0, -9.81);
  setup.options.tearing = false;
  // Blades in the plane x = 0.02, from +y, closing on the slab.
  const InstrumentGeometry geometry = instrument_geometry(InstrumentKind::scissors);
  InstrumentSetup scissors =
      instrument(InstrumentKind::scissors, Vec3(0.0203, 0.0145, 0.0015), -Vec3::UnitY(), geometry.max_opening);
  // x of the instrument is the pivot's axis: blades open in the plane of y and z of the instrument.
  Mat3 axes;
  axes.col(0) = Vec3::UnitX();
  axes.col(2) = -Vec3::UnitY();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  scissors.start.pose.rotation = Eigen::Quaterniond(axes);
  setup.instruments.push_back(scissors);
  InstrumentInput input = scissors.start;
  World world(std::move(setup));
  const double volume = quality(world.model().mesh()).volume;
  std::size_t cuts = 0;
  for (int k = 0; k < 40; ++k) {
    input.opening = std::max(0.0, geometry.max_opening * (1 - k / 30.0));
    const StepReport& report = world.step(inputs_of({input}));
    EXPECT_FALSE(report.ran_away) << k;
    EXPECT_TRUE(report.free_motion.converged)
        << k << " " << report.free_motion.residual << " it " << report.free_motion.iterations;
    EXPECT_EQ(report.inverted, 0u) << k;
    for (const WorldEvent& event : world.events()) cuts += event.kind == EventKind::cut;
  }
  EXPECT_GE(cuts, 2u);
  const Parts parts = face_connected_parts(world.model().mesh());
  EXPECT_EQ(parts.count(), 2u);
  EXPECT_NEAR(quality(world.model().mesh()).volume, volume, 1e-3 * volume);
  EXPECT_FALSE(validate(world.model().mesh()).fatal()) << validate(world.model().mesh()).describe();
  for (int k = 0; k < 20; ++k) world.step(inputs_of({input}));
  double lowest = 0;
  for (const Vec3& x : world.state().positions) lowest = std::min(lowest, x.z());
  EXPECT_LT(lowest, -0.05);
}

TEST(World, SameBytesOnAnyNumberOfThreads) {
  std::vector<std::string> hashes;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    WorldSetup setup = setup_of(soft_box(6, Vec3(0.04, 0.04, 0.02), 8e3, [](const Vec3& x) { return x.z() < 1e-9; }));
    setup.instruments.push_back(instrument(InstrumentKind::suction, Vec3(0.02, 0.02, 0.03), -Vec3::UnitZ(), 0));
    InstrumentInput input = setup.instruments[0].start;
    World world(std::move(setup));
    for (int k = 0; k < 40; ++k) {
      input.pose.position.z() -= 3e-4;
      world.step(inputs_of({input}));
    }
    hashes.push_back(world.state_hash());
  }
  set_thread_count(2);
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

}  // namespace
}  // namespace calot
