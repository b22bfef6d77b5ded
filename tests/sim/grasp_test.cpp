#include "calot/sim/grasp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/sim/instrument_tissue.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

/// A rigid block that only moves, never turns: one mass, sum of springs, by hand. It lies between the jaws of a bowel
/// grasper at the origin, 8 × 3 × 6 mm, from z = 12 to 18 mm.
struct RigidBlock {
  explicit RigidBlock(double mass_kg = 0.002, double step_s = 0.01) : mass(mass_kg), step(step_s) {
    const TetMesh mesh = test::box_mesh(4, 2, 4, {8 * mm, 3 * mm, 6 * mm});
    for (const Vec3& x : mesh.positions) positions.push_back(x + Vec3(-4 * mm, -1.5 * mm, 12 * mm));
    rest = positions;
    velocities.assign(positions.size(), Vec3::Zero());
    triangles = test::LinearTissue::boundary_surface_of(mesh);
  }

  void advance(Grasp& grasp, const Vec3& force, double ground = 0) {
    const std::vector<Vec3> x = positions, v = velocities;
    solve(grasp, force, ground);
    if (!trial || !grasp.correct(positions)) return;
    positions = x;
    velocities = v;
    solve(grasp, force, ground);
  }

  void solve(const Grasp& grasp, const Vec3& force, double ground) {
    std::vector<Spring> springs;
    grasp.springs(springs);
    Mat3 a = (mass / (step * step) + ground) * Mat3::Identity();
    Vec3 b = mass / step * velocities[0] + force - ground * (positions[0] - rest[0]);
    for (const Spring& s : springs) {
      a += s.stiffness;
      b += s.stiffness * (s.anchor - positions[s.vertex.index()]);
    }
    const Vec3 d = a.llt().solve(b);
    for (Vec3& x : positions) x += d;
    for (Vec3& v : velocities) v = d / step;
  }

  [[nodiscard]] GraspStep at(const Pose& from, const Pose& to, double opening, double grip) const {
    return {step, from, to, opening, grip, {triangles, positions}, velocities, rest, trial};
  }

  double mass, step;
  bool trial = true;
  std::vector<Vec3> positions, velocities, rest;
  std::vector<std::array<VertexId, 3>> triangles;
};

const InstrumentGeometry& grasper() {
  static const InstrumentGeometry g = instrument_geometry(InstrumentKind::bowel_grasper);
  return g;
}

/// Closes on the block and waits until the grip is there.
Grasp closed_on(RigidBlock& block, double grip, int steps = 80) {
  Grasp grasp(grasper(), 0.6);
  for (int k = 0; k < steps; ++k) {
    grasp.update(block.at({}, {}, std::max(0.0, 0.6 - 0.05 * (k + 1)), grip));
    block.advance(grasp, Vec3::Zero());
    grasp.after_step(block.positions);
  }
  return grasp;
}

TEST(Grasp, StopsAtTheTissueAndPressesWithTheGrip) {
  RigidBlock block;
  const Grasp grasp = closed_on(block, 3.0);
  ASSERT_TRUE(grasp.holding());
  // The faces touch the near edges first, at z = 12 mm: tan(φ/2) = 1.5/12; then they press in there: 3 N on at least a
  // third of what is held, at 20 kN/m for all of it.
  const double touch = 2 * std::atan(1.5 / 12.0), pressed = 3.0 / 20000;
  EXPECT_LT(grasp.opening(), touch - 2 * pressed / (18 * mm));
  EXPECT_GT(grasp.opening(), touch - 2 * 3 * pressed / (12 * mm));
  EXPECT_NEAR(grasp.report().a.normal, 3.0, 0.03);
  EXPECT_NEAR(grasp.report().b.normal, 3.0, 0.03);
  EXPECT_NEAR(grasp.report().hold_limit, 5.0, 0.06);
  EXPECT_LT(block.positions[0].y() - block.rest[0].y(), 1e-6);  // symmetric: nothing pushes it aside
}

TEST(Grasp, ThreeNewtonHoldAgainstFiveAndNoMore) {
  for (const double pull : {4.8, 5.3, 12.0}) {
    RigidBlock block;
    Grasp grasp = closed_on(block, 3.0);
    const Vec3 start = block.positions[0];
    double most = 0;
    for (int k = 0; k < 300 && grasp.holding(); ++k) {
      // Slowly more, as a spring balance would: inertia stays out of it.
      grasp.update(block.at({}, {}, 0, 3.0));
      block.advance(grasp, {std::min(pull, pull * k / 100), 0, 0});
      grasp.after_step(block.positions);
      most = std::max(most, grasp.report().pull.norm());
    }
    EXPECT_LT(most, 5.0 * 1.02);
    if (pull < 5) {
      ASSERT_TRUE(grasp.holding());
      EXPECT_NEAR(most, pull, 0.02);
      EXPECT_LT((block.positions[0] - start).norm(), 2 * 4.8 / 3000);
    } else {
      EXPECT_FALSE(grasp.holding());  // slipped out to the side
      EXPECT_GT(block.positions[0].x() - start.x(), (2.5 + 4) * mm);
    }
  }
}

TEST(Grasp, ASlipperyPullGoesOutPastTheTips) {
  RigidBlock block;
  Grasp grasp = closed_on(block, 3.0);
  const double start = block.positions[0].z();
  double most = 0;
  for (int k = 0; k < 300 && grasp.holding(); ++k) {
    grasp.update(block.at({}, {}, 0, 3.0));
    block.advance(grasp, {0, 0, std::min(5.3, 0.053 * k)});
    grasp.after_step(block.positions);
    most = std::max(most, grasp.report().pull.z());
  }
  EXPECT_FALSE(grasp.holding());
  EXPECT_GT(block.positions[0].z() - start, (24 - 18) * mm);
  EXPECT_LT(most, 5.0);  // the faces stand at an angle and push outwards, against friction
}

TEST(Grasp, PullsWithItsStiffnessWhileItHolds) {
  RigidBlock block;
  Grasp grasp = closed_on(block, 6.8);
  const Vec3 start = block.positions[0];
  for (int k = 0; k < 400; ++k) {
    grasp.update(block.at({}, {}, 0, 6.8));
    block.advance(grasp, {2.0, 0, 0});
    grasp.after_step(block.positions);
  }
  EXPECT_NEAR(block.positions[0].x() - start.x(), 2.0 / 3000, 2.0 / 3000 * 0.01);
  EXPECT_NEAR((grasp.report().pull - Vec3(2, 0, 0)).norm(), 0, 0.01);
  // Each jaw carries half of it, and keeps the wedge of its own from pushing the block out: N sin(φ/2) = T_z cos(φ/2).
  const double carried = std::hypot(1.0, 6.8 * std::tan(grasp.opening() / 2));
  EXPECT_NEAR(grasp.report().a.tangential, carried, 0.02);
  EXPECT_NEAR(grasp.report().b.tangential, carried, 0.02);
  EXPECT_LT(grasp.report().slip, 1e-12);
}

class GraspPasses : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Passes, GraspPasses, testing::Bool());

TEST_P(GraspPasses, NeverPullsHarderThanFrictionHoweverFastTheTool) {
  RigidBlock block;
  block.trial = GetParam();
  Grasp grasp = closed_on(block, 3.0);
  Pose pose;
  double most = 0, slipped = 0;
  for (int k = 0; k < 40; ++k) {
    Pose next = pose;
    next.position.x() -= 0.5 * block.step;  // 0.5 m/s, the block is tied to the ground
    grasp.update(block.at(pose, next, 0, 3.0));
    block.advance(grasp, Vec3::Zero(), 1e5);
    grasp.after_step(block.positions);
    most = std::max(most, grasp.report().pull.norm());
    slipped = std::max(slipped, grasp.report().slipped);
    pose = next;
  }
  EXPECT_LE(most, 5.0 * 1.03);
  EXPECT_GT(most, 4.0);
  EXPECT_GT(slipped, 1.5 * mm);
  EXPECT_FALSE(grasp.holding());
}

TEST_P(GraspPasses, AFreeBlockFollowsAFastToolWithoutSlipping) {
  RigidBlock block;
  block.trial = GetParam();
  Grasp grasp = closed_on(block, 6.8);
  Pose pose;
  const Vec3 start = block.positions[0];
  for (int k = 0; k < 20; ++k) {
    Pose next = pose;
    next.position.x() += 0.3 * block.step;
    grasp.update(block.at(pose, next, 0, 6.8));
    block.advance(grasp, Vec3::Zero());
    grasp.after_step(block.positions);
    pose = next;
  }
  ASSERT_TRUE(grasp.holding());
  EXPECT_LT(grasp.report().slipped, 0.05 * mm);
  EXPECT_NEAR(block.positions[0].x() - start.x(), 60 * mm, 1 * mm);
}

TEST(Grasp, CannotLeaveAlongTheFacesNormal) {
  RigidBlock block;
  Grasp grasp = closed_on(block, 3.0);
  const Vec3 start = block.positions[0];
  for (int k = 0; k < 200; ++k) {
    grasp.update(block.at({}, {}, 0, 3.0));
    block.advance(grasp, {0, 4.0, 0});
    grasp.after_step(block.positions);
  }
  ASSERT_TRUE(grasp.holding());
  EXPECT_LT((block.positions[0] - start).norm(), 0.6 * mm);
  EXPECT_NEAR(grasp.report().pull.y(), 4.0, 0.1);
}

TEST(Grasp, OpeningJawsLetGo) {
  RigidBlock block;
  Grasp grasp = closed_on(block, 6.8);
  int steps = 0;
  for (double opening = grasp.opening(); grasp.holding() && steps < 50; ++steps) {
    opening += 0.01;
    grasp.update(block.at({}, {}, opening, 6.8));
    block.advance(grasp, Vec3::Zero());
    grasp.after_step(block.positions);
  }
  EXPECT_FALSE(grasp.holding());
  EXPECT_LT(steps, 12);  // 6.8 N are 0.34 mm, about 0.05 rad
  EXPECT_LT((block.velocities[0]).norm(), 0.02);
}

TEST(Grasp, HoldsNothingWhenItOpensOrThereIsNothing) {
  RigidBlock block;
  Grasp opening(grasper(), 0.05);
  opening.update(block.at({}, {}, 0.4, 6.8));
  EXPECT_FALSE(opening.holding());
  EXPECT_EQ(opening.opening(), 0.4);
  Grasp away(grasper(), 0.6);
  const Pose aside{Eigen::Quaterniond::Identity(), {0.05, 0, 0}};
  for (const double wanted : {0.3, 0.1, 0.0}) away.update(block.at(aside, aside, wanted, 6.8));
  EXPECT_FALSE(away.holding());
  EXPECT_EQ(away.opening(), 0.0);
}

TEST(Grasp, TakesTissueThatLiesOffTheMiddle) {
  RigidBlock block;
  for (Vec3& x : block.positions) x.y() += 1 * mm;
  block.rest = block.positions;
  const Grasp grasp = closed_on(block, 3.0);
  ASSERT_TRUE(grasp.holding());
  EXPECT_NEAR(grasp.report().grip, 3.0, 0.05);
}

TEST(Grasp, BruisesWhereTheGripIsTooHard) {
  RigidBlock block;
  EXPECT_TRUE(closed_on(block, 6.8).bruises().empty());
  const Grasp crush = closed_on(block, 18.0);
  ASSERT_FALSE(crush.bruises().empty());
  double force = 0, area = 0;
  for (const Bruise& bruise : crush.bruises()) {
    force += bruise.force;
    area += bruise.area;
    EXPECT_EQ(bruise.duration, block.step);
  }
  EXPECT_NEAR(force, 2 * 18.0, 0.5);  // of both jaws
  // The block's two faces, 5 mm of width and 6 mm of length each, and a tenth of what is seen edge-on.
  EXPECT_NEAR(area, 2 * 5 * 6 * mm * mm, 0.25 * 2 * 5 * 6 * mm * mm);
}

TEST(Grasp, WrenchFallsByItsStiffness) {
  RigidBlock block;
  Grasp grasp = closed_on(block, 6.8);
  const auto wrench_at = [&](const Vector6& twist) {
    Grasp moved = grasp;
    const Vec3 turn = twist.tail<3>();
    const Pose to{
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? turn.normalized() : Vec3::UnitX())),
        twist.head<3>()};
    moved.update(block.at({}, to, 0, 6.8));
    moved.after_step(block.positions);
    return moved.wrench();
  };
  grasp.update(block.at({}, {}, 0, 6.8));
  grasp.after_step(block.positions);
  const Matrix6 stiffness = grasp.stiffness();
  const Vector6 base = wrench_at(Vector6::Zero());
  const double size = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const Vector6 plus = wrench_at(size * Vector6::Unit(k)), minus = wrench_at(-size * Vector6::Unit(k));
    const Vector6 change = -(plus - minus) / (2 * size);
    // What the present forces add by turning with the jaw isn't in it: N·rad⁻¹ of the grip, small beside the stiffness.
    EXPECT_LT((change - stiffness.col(k)).norm(), 0.03 * stiffness.col(k).norm() + 1e-3)
        << k << ' ' << base.transpose();
  }
}

/// Doubles the vertices of the middle plane x = length/2 of a box, so that its halves part there.
TopologyEdit parted_in_the_middle(const TetMesh& mesh, double middle) {
  TopologyEdit edit;
  std::map<VertexId, VertexId> copies;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (std::abs(mesh.positions[v].x() - middle) < 1e-9) {
      copies[VertexId(v)] = VertexId(mesh.vertex_count() + edit.vertices.size());
      edit.vertices.push_back({mesh.positions[v], VertexId(v), VertexId(v), 0});
    }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Tet tet = mesh.tets[t];
    bool beyond = false, on = false;
    for (VertexId& v : tet) {
      beyond |= mesh.position(v).x() > middle + 1e-9;
      if (const auto copy = copies.find(v); copy != copies.end()) {
        on = true;
        v = copy->second;
      }
    }
    if (!beyond || !on) continue;
    edit.removed.emplace_back(t);
    edit.tets.push_back({tet, TetId(t)});
  }
  return edit;
}

TEST(Grasp, SurvivesACutThroughWhatItHolds) {
  TetMesh mesh = test::box_mesh(4, 2, 4, {8 * mm, 3 * mm, 6 * mm});
  RigidBlock block;
  Grasp grasp = closed_on(block, 6.8);
  for (int k = 0; k < 20; ++k) {
    grasp.update(block.at({}, {}, 0, 6.8));
    block.advance(grasp, {1.0, 0, 0});
    grasp.after_step(block.positions);
  }
  std::vector<Spring> springs_before;
  grasp.springs(springs_before);
  const std::vector<Vec3> before = block.positions;
  const Remap remap = apply(mesh, parted_in_the_middle(mesh, 4 * mm));
  const std::vector<Vec3> after = carry_over(before, remap);
  std::size_t doubled = 0;
  for (const AddedVertex& added : remap.added_from) doubled += grasp.holds(added.from) ? 1 : 0;
  ASSERT_GT(doubled, 0U);
  Grasp followed = grasp;
  followed.follow(remap, before, after);
  for (std::size_t v = 0; v < before.size(); ++v)
    EXPECT_EQ(followed.holds(remap.vertex_to_new[v]), grasp.holds(VertexId(v)));
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k)
    EXPECT_EQ(followed.holds(remap.added_vertices[k]), grasp.holds(remap.added_from[k].from));
  EXPECT_EQ(followed.report().slipped, grasp.report().slipped);

  // The next step holds on, with the stiffness it had (but for the cut faces, which count a little).
  block.positions = after;
  block.rest = carry_over(block.rest, remap);
  block.velocities = carry_over(block.velocities, remap);
  block.triangles = test::LinearTissue::boundary_surface_of(mesh);
  followed.update(block.at({}, {}, 0, 6.8));
  std::vector<Spring> springs;
  followed.springs(springs);
  Mat3 sum = Mat3::Zero(), sum_before = Mat3::Zero();
  for (const Spring& s : springs) sum += s.stiffness;
  for (const Spring& s : springs_before) sum_before += s.stiffness;
  EXPECT_LT((sum - sum_before).norm(), 0.02 * sum.norm());
  block.advance(followed, {1.0, 0, 0});
  followed.after_step(block.positions);
  EXPECT_NEAR(followed.report().pull.x(), 1.0, 0.05);
}

TEST(Grasp, LosesOnlyTissueThatIsGone) {
  TetMesh mesh = test::box_mesh(4, 2, 4, {8 * mm, 3 * mm, 6 * mm});
  RigidBlock block;
  const Grasp grasp = closed_on(block, 6.8);
  TopologyEdit edit;
  for (const TetId t : test::tets_where(mesh, [](const Vec3& c) { return c.x() > 4 * mm; })) edit.removed.push_back(t);
  const Remap remap = apply(mesh, edit);
  Grasp followed = grasp;
  followed.follow(remap, block.positions, carry_over(block.positions, remap));
  EXPECT_TRUE(followed.holding());
  EXPECT_LT(followed.held_count(), grasp.held_count());
  for (std::size_t v = 0; v < remap.vertex_to_new.size(); ++v)
    if (const VertexId now = remap.vertex_to_new[v]; now.valid()) {
      EXPECT_EQ(followed.holds(now), grasp.holds(VertexId(v)));
    }

  TopologyEdit rest;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) rest.removed.emplace_back(t);
  const std::vector<Vec3> before = carry_over(block.positions, remap);
  const Remap all = apply(mesh, rest);
  followed.follow(all, before, {});
  EXPECT_FALSE(followed.holding());
}

/// A strip of tissue, gripped at one end, pulled at the other: what arrives at the jaws is the pull.
TEST(Grasp, HoldsRealTetsAndStopsAtTheirThickness) {
  const TetMesh box = test::box_mesh(16, 2, 4, {32 * mm, 3 * mm, 8 * mm});
  TetMesh mesh = box;
  for (Vec3& x : mesh.positions) x += Vec3(-4 * mm, -1.5 * mm, 12 * mm);
  const double h = 0.01;
  test::LinearTissue tissue(mesh, {20e3, 0.3, 1000}, std::vector<std::uint8_t>(mesh.vertex_count(), 0), h);
  Grasp grasp(grasper(), 0.6);
  std::vector<Vec3> forces(mesh.vertex_count(), Vec3::Zero());
  const std::vector<Spring> none;
  for (int k = 0; k < 150; ++k) {
    for (std::size_t v = 0; v < forces.size(); ++v)  // 0.02 N on the free end
      if (std::abs(mesh.positions[v].x() - 28 * mm) < 1e-9) forces[v] = {k > 60 ? 0.02 / 15 : 0, 0, 0};
    grasp.update(
        {h, {}, {}, std::max(0.0, 0.6 - 0.05 * k), 6.8, tissue.surface(), tissue.velocities, tissue.rest, false});
    std::vector<Spring> springs;
    grasp.springs(springs);
    tissue.advance(springs, forces);
    grasp.after_step(tissue.positions);
  }
  ASSERT_TRUE(grasp.holding());
  // 20 kPa give way before 6.8 N are reached, so the jaws stop at 40 % of the thickness and count as fully closed.
  EXPECT_TRUE(grasp.report().at_thickness);
  EXPECT_NEAR(grasp.report().grip, 6.8, 1e-9);
  EXPECT_NEAR(2 * 16 * std::tan(grasp.opening() / 2), 0.4 * 3, 0.6);  // the gap at the strip's middle [mm]
  EXPECT_NEAR(grasp.report().pull.x(), 0.02, 0.002);
}

/// Lifted across its jaws, as fast as a hand lifts, a grasper keeps both of them on what it holds.
TEST(Grasp, DoesNotChatterWhenItLifts) {
  TetMesh mesh = test::box_mesh(16, 2, 4, {32 * mm, 4 * mm, 8 * mm});
  for (Vec3& x : mesh.positions) x += Vec3(-4 * mm, -2 * mm, 12 * mm);
  const double h = 1.0 / 60, lift = 0.3 * mm;
  test::LinearTissue tissue(mesh, {200e3, 0.4, 1000}, std::vector<std::uint8_t>(mesh.vertex_count(), 0), h);
  Grasp grasp(grasper(), 0.6);
  const std::vector<Vec3> forces(mesh.vertex_count(), Vec3::Zero());
  double widest = 0, narrowest = 1;
  for (int k = 0; k < 160; ++k) {
    Pose from, to;
    from.position.y() = lift * std::max(0, k - 80);
    to.position.y() = lift * std::max(0, k - 79);
    grasp.update(
        {h, from, to, std::max(0.0, 0.6 - 0.02 * k), 3.0, tissue.surface(), tissue.velocities, tissue.rest, false});
    std::vector<Spring> springs;
    grasp.springs(springs);
    tissue.advance(springs, forces);
    grasp.after_step(tissue.positions);
    if (k < 100) continue;
    widest = std::max(widest, grasp.opening());
    narrowest = std::min(narrowest, grasp.opening());
    EXPECT_GT(std::min(grasp.report().a.area, grasp.report().b.area), 20e-6) << k;
  }
  EXPECT_LT(widest - narrowest, 2e-3);
}

TEST(Grasp, SameInputSameBytes) {
  std::array<std::string, 2> states;
  for (std::string& state : states) {
    RigidBlock block;
    Grasp grasp = closed_on(block, 3.0);
    for (int k = 0; k < 60; ++k) {
      grasp.update(block.at({}, {}, 0, 3.0));
      block.advance(grasp, {0.1 * k, 0.02 * k, 0});
      grasp.after_step(block.positions);
      grasp.append_state(state);
    }
  }
  EXPECT_EQ(states[0], states[1]);
  EXPECT_GT(states[0].size(), 1000U);
}

TEST(Grasp, RefusesInstrumentsThatHoldNothing) {
  EXPECT_THROW(Grasp(instrument_geometry(InstrumentKind::hook)), std::runtime_error);
  EXPECT_THROW(Grasp(instrument_geometry(InstrumentKind::scissors)), std::runtime_error);
}

TEST(MouthContents, AreaIsThatOfTheFacesBetweenTheJaws) {
  RigidBlock block;
  MouthContents mouth;
  look_into_mouth(grasper(), {{}, 0.3, 0, 0, 0.5 * mm}, {block.triangles, block.positions}, mouth);
  double a = 0, b = 0;
  for (const JawShare& share : mouth.shares) (share.side == JawSide::a ? a : b) += share.area;
  // 5 mm wide, 6 mm long; the ends at z = 12 and 18 mm, seen edge-on, count a tenth of 1.5 mm × 5 mm each.
  const double expected = (5 * 6 + 0.1 * (5 * 6 + 2 * 1.5 * 5)) * mm * mm;
  EXPECT_NEAR(a, expected, 1e-9 * expected);
  EXPECT_NEAR(b, expected, 1e-9 * expected);
  EXPECT_NEAR(mouth.extent_a, std::atan2(1.5, 12.0), 1e-12);
  EXPECT_NEAR(mouth.extent_b, std::atan2(1.5, 12.0), 1e-12);
}

TEST(MouthContents, CostsLittleOnALargeOrgan) {
  const TetMesh mesh = test::box_mesh(12, 12, 12, {60 * mm, 60 * mm, 60 * mm});  // 10,368 tets
  const auto triangles = test::LinearTissue::boundary_surface_of(mesh);
  MouthContents mouth;
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX())), {30 * mm, 30 * mm, 78 * mm}};
  const int count = 200;
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < count; ++k)
    look_into_mouth(grasper(), {pose, 0.6, 0, 0, 0.5 * mm}, {triangles, mesh.positions}, mouth);
  const double each =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() / count;
  EXPECT_FALSE(mouth.empty());
  RecordProperty("milliseconds", std::to_string(each));
  EXPECT_LT(each, 2.0);  // 0.2 wanted; ten times that is no noise any more
}

}  // namespace
}  // namespace calot
