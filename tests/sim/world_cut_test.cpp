// Cuts in the world: parts that know nothing of each other, a compliance that follows exactly, and rotation.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <numbers>

#include "calot/cut/split.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "tests/sim/world_scenes.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

constexpr double mm = 1e-3, h = 1.0 / 60;

bool same_bits(const Vec3& a, const Vec3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}

/// A beam along x, 60 mm, held at both ends, at rest; a blunt tool stands over its far half.
WorldSetup beam(bool far_end_held) {
  WorldSetup setup = test::world_setup(
      test::make_model(test::box_mesh(15, 3, 2, Vec3(60 * mm, 9 * mm, 6 * mm)), h,
                       [&](const Vec3& x) { return x.x() < 1e-9 || (far_end_held && x.x() > 60 * mm - 1e-9); },
                       {20e3, 0.4, 1000}, {.rayleigh_stiffness = 0.01}));
  setup.instruments.push_back(
      test::instrument(InstrumentKind::suction, Vec3(45 * mm, 4.5 * mm, 12 * mm), -Vec3::UnitZ(), Vec3::UnitX(), 0));
  return setup;
}

/// The vertices of the part that holds the place x, and of the others.
std::pair<std::vector<VertexId>, std::vector<VertexId>> sides(const World& world, double x) {
  const TetMesh& mesh = world.model().mesh();
  const Parts parts = face_connected_parts(mesh);
  std::pair<std::vector<VertexId>, std::vector<VertexId>> result;
  for (const std::vector<VertexId>& part : parts.vertices) {
    double low = 1, high = 0;
    for (const VertexId v : part) {
      low = std::min(low, mesh.position(v).x());
      high = std::max(high, mesh.position(v).x());
    }
    std::vector<VertexId>& side = low <= x && x <= high ? result.first : result.second;
    side.insert(side.end(), part.begin(), part.end());
  }
  return result;
}

class WorldCutWays : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SplitOrRemove, WorldCutWays, testing::Bool());

TEST_P(WorldCutWays, APartDoesNotFeelToTheLastBitThatTheOtherIsPushed) {
  // The same twice: with a tool that pushes the far part, and with one that stays away.
  const auto make = [&] {
    WorldSetup setup = beam(true);
    // The lips of a split touch: they would feel each other by right.
    setup.options.contact.self_contact = !GetParam();
    return setup;
  };
  World pushed(make()), left(make());
  InstrumentInput input = pushed.instruments()[0].setup().start;
  const InstrumentInput away = input;
  for (World* world : {&pushed, &left}) {
    for (int k = 0; k < 3; ++k) world->step(test::Inputs{away});
    const Plane plane{Vec3(25.3 * mm, 0, 0), Vec3::UnitX()};
    if (GetParam())
      world->edit(split(world->model().mesh(), plane), EventKind::cut, "split");
    else
      world->edit(cut(world->model().mesh(), plane), EventKind::cut, "removed");
  }
  ASSERT_EQ(face_connected_parts(pushed.model().mesh()).count(), 2u);
  const auto [far, near] = sides(pushed, 50 * mm);
  ASSERT_GT(near.size(), 40u);
  const std::vector<Vec3> before = pushed.state().positions;
  double deepest = 0, most = 0;
  for (int k = 0; k < 60; ++k) {  // past several refreshes of the compliance
    if (k < 30) input.pose.position.z() -= 0.3 * mm;
    ASSERT_FALSE(pushed.step(test::Inputs{input}).ran_away);
    left.step(test::Inputs{away});
    for (const VertexId v : near) {
      const Vec3 &a = pushed.state().positions[v.index()], &b = left.state().positions[v.index()];
      ASSERT_TRUE(same_bits(a, b)) << "step " << k << " vertex " << v.value << " by " << (a - b).norm();
      ASSERT_TRUE(same_bits(pushed.state().velocities[v.index()], left.state().velocities[v.index()])) << k;
      most = std::max(most, (a - before[v.index()]).norm());
    }
    for (const VertexId v : far)
      deepest = std::max(deepest, before[v.index()].z() - pushed.state().positions[v.index()].z());
  }
  EXPECT_GT(deepest, 2 * mm);
  EXPECT_LT(most, 1e-15);  // at rest, rounding aside
}

TEST_P(WorldCutWays, ASeveredPartMovesAsABodyOfItsOwn) {
  WorldSetup setup = beam(true);
  setup.options.contact.self_contact = false;
  setup.options.solver = {1e-10, 60};
  setup.options.friction.tolerance = 1e-9;
  const WorldOptions options = setup.options;
  InstrumentInput input = setup.instruments[0].start;
  const InstrumentSetup tool = setup.instruments[0];
  World world(std::move(setup));
  const Plane plane{Vec3(25.3 * mm, 0, 0), Vec3::UnitX()};
  const TopologyEdit edit =
      GetParam() ? TopologyEdit(split(world.model().mesh(), plane)) : TopologyEdit(cut(world.model().mesh(), plane));
  world.edit(edit, EventKind::cut, "apart");
  const std::vector<VertexId> part = sides(world, 50 * mm).first;

  // The same part alone, made from scratch.
  const TetMesh& whole = world.model().mesh();
  std::vector<VertexId> number(whole.vertex_count());
  TetMesh mesh;
  std::vector<std::uint8_t> fixed;
  for (const VertexId v : part) {
    number[v.index()] = VertexId(mesh.positions.size());
    mesh.positions.push_back(whole.position(v));
    fixed.push_back(world.model().is_fixed(v) ? 1 : 0);
  }
  for (std::size_t t = 0; t < whole.tet_count(); ++t) {
    Tet tet = whole.tets[t];
    if (!number[tet[0].index()].valid()) continue;
    for (VertexId& v : tet) v = number[v.index()];
    mesh.tets.push_back(tet);
    mesh.regions.push_back(whole.regions[t]);
  }
  mesh.region_names = whole.region_names;
  WorldSetup alone_setup =
      test::world_setup(Model(std::move(mesh), world.model().materials(), std::move(fixed), world.model().dynamics()));
  alone_setup.options = options;
  alone_setup.instruments.push_back(tool);
  World alone(std::move(alone_setup));

  double moved = 0, apart = 0;
  for (int k = 0; k < 50; ++k) {
    if (k < 30) input.pose.position.z() -= 0.3 * mm;
    world.step(test::Inputs{input});
    alone.step(test::Inputs{input});
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Vec3& here = world.state().positions[part[i].index()];
      apart = std::max(apart, (here - alone.state().positions[i]).norm());
      moved = std::max(moved, (here - whole.position(part[i])).norm());
    }
  }
  EXPECT_GT(moved, 2 * mm);
  EXPECT_LT(apart, 1e-6 * moved) << moved;
}

TEST(WorldCut, SixtyGradualSplitsLeaveTheComplianceAsIfComputedAnew) {
  WorldSetup setup = test::world_setup(
      test::make_model(test::box_mesh(8, 6, 3, Vec3(40 * mm, 30 * mm, 12 * mm)), h,
                       [](const Vec3& x) { return x.z() < 1e-9 && (x.x() < 8 * mm || x.x() > 32 * mm); },
                       {20e3, 0.45, 1000}, {.rayleigh_stiffness = 0.005}));
  setup.options.gravity = Vec3(0, 0, -9.81);
  World world(std::move(setup));
  Compliance compliance = precompute(world.model());
  const double volume = quality(world.model().mesh()).volume;
  std::size_t edits = 0, most = 0, opened = 0;
  double worst_residual = 0;
  std::vector<VertexId> face;
  // Slits, each opened little by little: a strip of the blade a step.
  for (int slit = 0; slit < 8; ++slit) {
    Stroke stroke;
    const double x = (2.7 + 4.9 * slit) * mm;
    for (int k = 0; k < 18; ++k) {
      const double y = (-1 + 1.6 * k) * mm, to = y + 1.6 * mm;
      const Vec3 a(x, y - 0.1 * mm, -5 * mm), b(x, to, -5 * mm), c(x, to, 20 * mm), d(x, y - 0.1 * mm, 20 * mm);
      // Where the blade is in the tissue as it hangs: gravity moves it by less than a millimetre.
      SplitOptions options;
      options.stroke = &stroke;
      options.fixed = world.model().fixed();
      const SplitEdit cut = split(world.model().mesh(), vertex_tets(world.model().mesh()), world.state().positions,
                                  {{{a, b, c}, {a, c, d}}}, options);
      if (!cut.empty()) {
        const StiffnessChange* change = world.edit(cut, EventKind::cut, "a little further");
        ASSERT_NE(change, nullptr);
        stroke = follow(cut.report.stroke, change->remap);
        opened += cut.report.separated;
        face = test::cut_face(*change);
        ++edits;
      } else {
        stroke = cut.report.stroke;
      }
      const StepReport& report = world.step({});
      for (const StiffnessChange& each : world.changes()) ASSERT_NO_THROW(compliance.update(each));
      ASSERT_TRUE(report.free_motion.converged) << slit << " " << k << " " << report.free_motion.residual;
      ASSERT_FALSE(report.ran_away) << slit << " " << k;
      most = std::max(most, static_cast<std::size_t>(report.free_motion.iterations));
      worst_residual = std::max(worst_residual, report.free_motion.residual);
    }
  }
  EXPECT_GE(edits, 60u);
  EXPECT_GT(opened, 60u);
  EXPECT_LE(most, 15u);
  const Compliance anew = precompute(world.model());
  const auto dofs = test::sample_dofs(world.model().mesh().vertex_count(), face);
  EXPECT_LT(test::worst_column(compliance, anew, dofs), test::bound(anew));
  EXPECT_NEAR(quality(world.model().mesh()).volume, volume, 1e-3 * volume);
  EXPECT_FALSE(validate(world.model().mesh()).fatal()) << validate(world.model().mesh()).describe();
}

TEST(WorldCut, ScissorsReportEveryChangeToTheCompliance) {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(10, 5, 2, Vec3(30 * mm, 12 * mm, 3 * mm)), h,
                                                        [](const Vec3& x) { return x.x() < 1e-9; }, {300e3, 0.4, 1000},
                                                        {.rayleigh_stiffness = 0.005}));
  setup.options.gravity = Vec3(0, 0, -9.81);
  setup.instruments.push_back(test::instrument(InstrumentKind::scissors, Vec3(16.3 * mm, 17 * mm, 1.5 * mm),
                                               -Vec3::UnitY(), Vec3::UnitX(), 0.8));
  InstrumentInput input = setup.instruments[0].start;
  World world(std::move(setup));
  Compliance compliance = precompute(world.model());
  std::size_t edits = 0, most = 0;
  for (int k = 0; k < 80; ++k) {
    input.opening = 0.8 * (1 - (k + 1) / 80.0);
    const StepReport& report = world.step(test::Inputs{input});
    ASSERT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
    most = std::max(most, static_cast<std::size_t>(report.free_motion.iterations));
    for (const StiffnessChange& change : world.changes()) {
      compliance.update(change);
      ++edits;
    }
  }
  EXPECT_GE(edits, 5u);
  EXPECT_LE(most, 15u);
  const Compliance anew = precompute(world.model());
  EXPECT_LT(test::worst_column(compliance, anew, test::sample_dofs(world.model().mesh().vertex_count())),
            test::bound(anew));
}

/// Corotational elastic forces by singular values, tet by tet: nothing of the simulation's own code.
std::vector<Vec3> elastic_forces(const Model& model, std::span<const Vec3> x) {
  const TetMesh& mesh = model.mesh();
  std::vector<Vec3> forces(mesh.vertex_count(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    Mat3 rest, now;
    for (int c = 0; c < 3; ++c) {
      rest.col(c) = mesh.position(tet[static_cast<std::size_t>(c) + 1]) - mesh.position(tet[0]);
      now.col(c) = x[tet[static_cast<std::size_t>(c) + 1].index()] - x[tet[0].index()];
    }
    const Mat3 f = now * rest.inverse();
    const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 r = svd.matrixU() * svd.matrixV().transpose();
    const Mat3 s = r.transpose() * f, strain = 0.5 * (s + s.transpose()) - Mat3::Identity();
    const Lame lame = model.lame_of(TetId(t));
    const Mat3 stress = r * (lame.lambda * strain.trace() * Mat3::Identity() + 2 * lame.mu * strain);
    const Mat3 corner = -rest.determinant() / 6 * stress * rest.inverse().transpose();
    for (int c = 0; c < 3; ++c) {
      forces[tet[static_cast<std::size_t>(c) + 1].index()] += corner.col(c);
      forces[tet[0].index()] -= corner.col(c);
    }
  }
  return forces;
}

TEST(WorldRotation, AFreeBodyTurnedByNinetyDegreesIsFreeOfStressAgain) {
  Model model = test::make_model(test::box_mesh(4, 3, 3, Vec3(20 * mm, 10 * mm, 10 * mm)), h,
                                 [](const Vec3&) { return false; }, {20e3, 0.4, 1000}, {.rayleigh_stiffness = 0.01});
  WorldSetup setup = test::world_setup(std::move(model));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 2, 3).normalized()));
  const std::vector<Vec3> rest = setup.model.mesh().positions;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    Spring spring;
    spring.vertex = VertexId(v);
    spring.anchor = turn * rest[v];
    spring.stiffness = 0.4 * Mat3::Identity();
    spring.damping = 0.2;
    setup.ligaments.push_back(spring);
  }
  World world(std::move(setup));
  for (int k = 0; k < 400; ++k) {
    const StepReport& report = world.step({});
    ASSERT_FALSE(report.ran_away) << k;
    ASSERT_TRUE(report.free_motion.converged) << k;
  }
  double off = 0;
  for (std::size_t v = 0; v < rest.size(); ++v)
    off = std::max(off, (world.state().positions[v] - turn * rest[v]).norm());
  EXPECT_LT(off, 1e-6);
  EXPECT_LT(world.energy(), 1e-9);
  const std::vector<Vec3> forces = elastic_forces(world.model(), world.state().positions);
  for (const Vec3& f : forces) EXPECT_LT(f.norm(), 1e-5);
}

TEST(WorldRotation, ABeamTwistedByNinetyDegreesEndsInEquilibrium) {
  Model model =
      test::make_model(test::box_mesh(10, 3, 3, Vec3(40 * mm, 10 * mm, 10 * mm)), h,
                       [](const Vec3& x) { return x.x() < 1e-9; }, {20e3, 0.4, 1000}, {.rayleigh_stiffness = 0.02});
  WorldSetup setup = test::world_setup(std::move(model));
  setup.options.gravity = Vec3(0, 0, -9.81);
  setup.options.solver = {1e-8, 60};
  const std::vector<Vec3> rest = setup.model.mesh().positions;
  const Vec3 centre(40 * mm, 5 * mm, 5 * mm);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  std::vector<Spring> springs;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (rest[v].x() < 40 * mm - 1e-9) continue;
    Spring spring;
    spring.vertex = VertexId(v);
    spring.anchor = centre + turn * (rest[v] - centre);
    spring.stiffness = 20 * Mat3::Identity();
    spring.damping = 0.05;
    springs.push_back(spring);
  }
  setup.ligaments = springs;
  World world(std::move(setup));
  double largest = 0;
  for (int k = 0; k < 300; ++k) {
    const StepReport& report = world.step({});
    ASSERT_FALSE(report.ran_away) << k;
    ASSERT_EQ(report.inverted, 0u) << k;
    ASSERT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
    largest = std::max(largest, report.nonlinear_residual);
  }
  EXPECT_LT(test::fastest(world), 1e-6);
  EXPECT_LT(world.report().nonlinear_residual, 1e-6);
  // Every free vertex: elastic force + weight + spring = 0, of the order of the springs' forces (0.1 N).
  std::vector<Vec3> missing = elastic_forces(world.model(), world.state().positions);
  double twist = 0, scale = 0;
  for (std::size_t v = 0; v < missing.size(); ++v)
    missing[v] += world.model().vertex_masses()[v] * world.options().gravity;
  for (const Spring& spring : springs) {
    const Vec3 pull = spring.stiffness * (spring.anchor - world.state().positions[spring.vertex.index()]);
    missing[spring.vertex.index()] += pull;
    scale = std::max(scale, pull.norm());
    const Vec3 a = rest[spring.vertex.index()] - centre, b = world.state().positions[spring.vertex.index()] - centre;
    twist += std::atan2(a.y() * b.z() - a.z() * b.y(), a.y() * b.y() + a.z() * b.z());
  }
  EXPECT_GT(scale, 1e-3);
  for (std::size_t v = 0; v < missing.size(); ++v)
    if (!world.model().is_fixed(VertexId(v))) {
      EXPECT_LT(missing[v].norm(), 1e-3 * scale) << v;
    }
  EXPECT_GT(twist / static_cast<double>(springs.size()), 1.2);
  RecordProperty("largest_nonlinear_residual", std::to_string(largest));
}

TEST(WorldRotation, AGrasperTwistsATubeByNinetyDegreesAndHoldsItThere) {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(2, 2, 12, Vec3(6 * mm, 4 * mm, 36 * mm)), h,
                                                        [](const Vec3& x) { return x.z() < 1e-9; }, {200e3, 0.4, 1000},
                                                        {.rayleigh_stiffness = 0.02}));
  // From above, its jaws around the top 12 mm; they open along y.
  setup.instruments.push_back(test::instrument(InstrumentKind::bowel_grasper, Vec3(3 * mm, 2 * mm, 46 * mm),
                                               -Vec3::UnitZ(), Vec3::UnitX(), 0.6));
  setup.instruments[0].start.grip = 4;
  InstrumentInput input = setup.instruments[0].start;
  World world(std::move(setup));
  for (int k = 0; k < 50; ++k) {
    input.opening = std::max(0.0, 0.6 - 0.03 * (k + 1));
    world.step(test::Inputs{input});
  }
  ASSERT_TRUE(world.instruments()[0].grasp->holding());
  const Eigen::Quaterniond start = input.pose.rotation;
  double energy = world.energy(), most_gained = 0;
  for (int k = 0; k < 180; ++k) {
    const double angle = std::min(1.0, (k + 1) / 90.0) * std::numbers::pi / 2;
    input.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ())) * start;
    const StepReport& report = world.step(test::Inputs{input});
    ASSERT_FALSE(report.ran_away) << k;
    EXPECT_TRUE(report.free_motion.converged) << k << " " << report.free_motion.residual;
    if (k < 90) continue;
    // Nobody moves any more: no work is done, and energy only falls.
    most_gained = std::max(most_gained, k > 100 ? world.energy() - energy : 0);
    energy = world.energy();
  }
  EXPECT_LT(most_gained, 1e-3 * energy);
  ASSERT_TRUE(world.instruments()[0].grasp->holding());
  EXPECT_LT(test::fastest(world), 1e-6);
  EXPECT_LT(world.report().nonlinear_residual, 1e-6);
  double twist = 0, number = 0;
  for (std::size_t v = 0; v < world.state().positions.size(); ++v) {
    const Vec3 middle(3 * mm, 2 * mm, 0);
    const Vec3 a = world.model().mesh().positions[v] - middle, b = world.state().positions[v] - middle;
    if (a.z() < 36 * mm - 1e-9 || std::hypot(a.x(), a.y()) < mm) continue;
    twist += std::atan2(a.x() * b.y() - a.y() * b.x(), a.x() * b.x() + a.y() * b.y());
    ++number;
  }
  EXPECT_GT(twist / number, 1.2);
}

}  // namespace
}  // namespace calot
