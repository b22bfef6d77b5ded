#include "calot/sim/clip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/sim/instrument_tissue.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double radius = 1.5 * mm, length = 16 * mm;

/// A solid cylinder along x, 3 mm thick, its axis through the middle of the applier's clip (z = 13.25 mm).
TetMesh duct(double across = 0) {
  TetMesh mesh = test::box_mesh(16, 4, 4, {length, 2, 2});
  for (Vec3& x : mesh.positions) {
    const double u = x.y() - 1, v = x.z() - 1;  // the square −1 … 1 onto the disc
    x = {x.x() - length / 2, radius * u * std::sqrt(1 - v * v / 2), radius * v * std::sqrt(1 - u * u / 2)};
    x.z() += 13.25 * mm + across;
  }
  return mesh;
}

const InstrumentGeometry& applier() {
  static const InstrumentGeometry g = instrument_geometry(InstrumentKind::clip_applier);
  return g;
}

struct Scene {
  explicit Scene(double across = 0, double step_s = 0.01)
      : mesh(duct(across)), step(step_s), tissue(mesh, {300e3, 0.3, 1000}, ends(mesh), step_s) {}

  static std::vector<std::uint8_t> ends(const TetMesh& mesh) {
    std::vector<std::uint8_t> fixed;
    for (const Vec3& x : mesh.positions) fixed.push_back(std::abs(std::abs(x.x()) - length / 2) < 1e-9 ? 1 : 0);
    return fixed;
  }
  [[nodiscard]] Clip fire() const { return {ClipFigures{}, applier(), Pose{}, 0.4, tissue.surface(), mesh}; }

  void run(Clip& clip, int steps, const Vec3& pull = Vec3::Zero()) {
    for (int k = 0; k < steps; ++k) {
      std::vector<Spring> springs;
      std::vector<Vec3> forces(mesh.vertex_count(), Vec3::Zero());
      clip.pull(pull);
      clip.springs(step, springs);
      clip.loads(forces);
      tissue.advance(springs, forces);
      clip.after_step(tissue.positions);
    }
  }

  TetMesh mesh;
  double step;
  test::LinearTissue tissue;
};

/// A clip that has closed on its tube; run once, copied by the tests.
struct Closed {
  Closed() : clip(scene.fire()) { scene.run(clip, 60); }
  Scene scene;
  Clip clip;
};
const Closed& closed() {
  static const Closed once;
  return once;
}

/// Legs beside the middle, by more and more: between them lies all of the tube, a corner of it, nothing.
TEST(Clip, OneThatCatchesACornerOfTheTubeDoesNotHoldTheWholeTube) {
  const auto fire_beside = [](Scene& scene, double beside) {
    const Pose pose{Eigen::Quaterniond::Identity(), Vec3(0, beside, 0)};
    return Clip(ClipFigures{}, applier(), pose, 0.4, scene.tissue.surface(), scene.mesh);
  };
  Scene scene;
  EXPECT_TRUE(fire_beside(scene, 0.8 * mm).whole());
  EXPECT_EQ(fire_beside(scene, 4.5 * mm).state(), ClipState::off);
  for (const double beside : {2.2 * mm, -2.2 * mm}) {
    Clip clip = fire_beside(scene, beside);
    ASSERT_EQ(clip.state(), ClipState::closing) << beside;
    EXPECT_FALSE(clip.whole()) << beside;
    scene.run(clip, 60);
    EXPECT_FALSE(clip.closes(1, scene.mesh, scene.tissue.positions)) << beside;
  }
}

TEST(Clip, PairsOppositeWallsAcrossTheWholeTube) {
  const Scene scene;
  const Clip clip = scene.fire();
  EXPECT_EQ(clip.state(), ClipState::closing);
  EXPECT_TRUE(clip.whole());
  EXPECT_LT((clip.frame().position - Vec3(0, 0, 13.25 * mm)).norm(), 1e-12);
  // The lines cross the disc along their z: the walls are as far apart as the chord there, at most the diameter.
  EXPECT_NEAR(clip.gap(), 2 * radius, 0.05 * radius);
  // One wall under the legs: the clip's width times the tube's, within a line's spacing.
  EXPECT_NEAR(clip.held_area(), 1 * mm * 2 * radius, 1 * mm * 8.5 * mm / 17);
  EXPECT_GT(clip.pair_count(), 10U);
  for (const TetId t : clip.tets()) {
    double nearest = 1;
    for (const VertexId v : scene.mesh.tet(t)) nearest = std::min(nearest, std::abs(scene.mesh.position(v).x()));
    EXPECT_LE(nearest, 0.5 * mm + 1e-9);
  }
  EXPECT_FALSE(clip.closes(1, scene.mesh, scene.tissue.positions));  // not yet
}

TEST(Clip, ClosesTheTubeSmoothlyAndKeepsIt) {
  Scene scene;
  Clip clip = scene.fire();
  double fastest = 0;
  for (int k = 0; k < 60; ++k) {
    scene.run(clip, 1);
    for (const Vec3& v : scene.tissue.velocities) fastest = std::max(fastest, v.norm());
  }
  EXPECT_EQ(clip.state(), ClipState::closed);
  EXPECT_LT(fastest, 0.05);  // 1 mm of each wall in 0.15 s
  EXPECT_LT(clip.gap(), clip.closed_gap() + 0.3 * mm);
  EXPECT_GT(clip.gap(), 0.5 * clip.closed_gap());
  EXPECT_GT(clip.closing_force(), 0);
  EXPECT_LT(clip.closing_force(), ClipFigures{}.closing_force);
  EXPECT_TRUE(clip.closes(1, scene.mesh, scene.tissue.positions));
  const Vec3 place = clip.frame().position;
  scene.run(clip, 40);
  EXPECT_LT((clip.frame().position - place).norm(), 0.01 * mm);  // it stays, and nothing drifts
}

TEST(Clip, WallsFeelEqualAndOppositeForces) {
  Scene scene;
  Clip clip = scene.fire();
  scene.run(clip, 10);
  std::vector<Spring> springs;
  clip.springs(scene.step, springs);
  ASSERT_FALSE(springs.empty());
  for (const Spring& s : springs) {
    EXPECT_TRUE(s.other.valid());  // the other vertex feels the opposite: a clip never pushes a tube along
    EXPECT_NE(s.other, s.vertex);
  }
}

TEST(Clip, AClipAcrossAPartOfTheTubeIsLooseAndDoesNotClose) {
  Scene scene(4.5 * mm);  // the tube lies at the tips of the legs, half of it beyond them
  Clip clip = scene.fire();
  ASSERT_EQ(clip.state(), ClipState::closing);
  EXPECT_FALSE(clip.whole());
  scene.run(clip, 60);
  EXPECT_FALSE(clip.closes(1, scene.mesh, scene.tissue.positions));
  scene.run(clip, 1, {0, 0, 1.2});  // half of 2.2 N takes it off
  EXPECT_EQ(clip.state(), ClipState::off);
}

TEST(Clip, ComesOffAtItsForces) {
  const std::vector<std::pair<Vec3, bool>> cases{{{0, 0, 2.1}, false},  {{0, 0, 2.3}, true}, {{4.3, 0, 0}, false},
                                                 {{4.5, 0, 0}, true},   {{0, 2.3, 0}, true}, {{3.5, 0, 1.6}, true},
                                                 {{3.0, 0, 1.4}, false}};
  const Scene& scene = closed().scene;
  const Clip& fired = closed().clip;
  ASSERT_TRUE(fired.closes(1, scene.mesh, scene.tissue.positions));
  for (const auto& [pull, off] : cases) {
    Clip clip = fired;
    clip.pull(pull);
    clip.after_step(scene.tissue.positions);
    EXPECT_EQ(clip.state() == ClipState::off, off) << pull.transpose();
    if (off) continue;
    EXPECT_NEAR(clip.strain(), std::hypot(pull.x() / 4.4, std::hypot(pull.y(), pull.z()) / 2.2), 0.02);
  }
}

TEST(Clip, APullReachesTheTissueWhole) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  clip.pull({0.3, 0.1, -0.5});
  clip.pull({0.1, 0, 0});
  std::vector<Vec3> forces(scene.mesh.vertex_count(), Vec3::Zero());
  clip.loads(forces);
  Vec3 sum = Vec3::Zero();
  for (const Vec3& f : forces) sum += f;
  EXPECT_LT((sum - Vec3(0.4, 0.1, -0.5)).norm(), 1e-12);
}

TEST(Clip, FollowsItsTissueAsARigidBody) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  const Pose before = clip.frame();
  const Pose moved{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized())), {0.01, -0.02, 0.03}};
  std::vector<Vec3> positions;
  for (const Vec3& x : scene.tissue.positions) positions.push_back(moved * x);
  clip.after_step(positions);
  const Pose wanted = moved * before;
  EXPECT_LT((clip.frame().position - wanted.position).norm(), 1e-6);
  EXPECT_LT(clip.frame().rotation.angularDistance(wanted.rotation), 1e-6);
  EXPECT_EQ(clip.shape().pieces.size(), 3U);
}

TEST(Clip, ACutBesideItChangesNothing) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  TopologyEdit edit;  // the piece of tube between x = 2 and 3 mm goes
  for (std::size_t t = 0; t < scene.mesh.tet_count(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const VertexId v : scene.mesh.tets[t]) centre += scene.mesh.position(v) / 4;
    if (centre.x() > 2 * mm && centre.x() < 3 * mm) edit.removed.emplace_back(t);
  }
  ASSERT_FALSE(edit.removed.empty());
  const std::vector<Vec3> before = scene.tissue.positions;
  const Remap remap = apply(scene.mesh, edit);
  const std::vector<Vec3> after = carry_over(before, remap);
  Clip followed = clip;
  followed.follow(remap, before, after);
  followed.after_step(after);
  EXPECT_EQ(followed.state(), ClipState::closed);
  EXPECT_EQ(followed.pair_count(), clip.pair_count());
  EXPECT_EQ(followed.tets().size(), clip.tets().size());
  EXPECT_NEAR(followed.gap(), clip.gap(), 1e-9);
  EXPECT_TRUE(followed.closes(1, scene.mesh, after));
  for (std::size_t v = 0; v < before.size(); ++v)
    if (remap.vertex_to_new[v].valid()) {
      EXPECT_EQ(followed.holds(remap.vertex_to_new[v]), clip.holds(VertexId(v)));
    }
}

/// The cross-section x = 0 parts.
TopologyEdit part_the_middle(const TetMesh& mesh) {
  TopologyEdit edit;
  std::map<VertexId, VertexId> copies;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (std::abs(mesh.positions[v].x()) < 1e-9) {
      copies[VertexId(v)] = VertexId(mesh.vertex_count() + edit.vertices.size());
      edit.vertices.push_back({mesh.positions[v], VertexId(v), VertexId(v), 0});
    }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Tet tet = mesh.tets[t];
    bool beyond = false, on = false;
    for (VertexId& v : tet) {
      beyond |= mesh.position(v).x() > 1e-9;
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

/// What springs between two vertices add up to.
struct SpringSum {
  SpringSum(const std::vector<Spring>& springs, const std::vector<Vec3>& positions) {
    for (const Spring& s : springs) {
      const Vec3 apart = positions[s.vertex.index()] - positions[s.other.index()];
      const Vec3 pull = s.stiffness * (s.anchor - apart);
      stiffness += s.stiffness;
      force += pull;
      torque += apart.cross(pull);
      largest_torque += apart.norm() * pull.norm();
    }
  }
  Mat3 stiffness = Mat3::Zero();
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double largest_torque = 0;
};

std::vector<Spring> springs_of(Clip& clip, double step) {
  std::vector<Spring> springs;
  clip.springs(step, springs);
  return springs;
}

TEST(Clip, ACutThroughItChangesNeitherItsStiffnessNorItsForce) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  const std::vector<Vec3> before = scene.tissue.positions;
  const SpringSum was(springs_of(clip, scene.step), before);
  const Remap remap = apply(scene.mesh, part_the_middle(scene.mesh));
  const std::vector<Vec3> after = carry_over(before, remap);
  Clip followed = clip;
  followed.follow(remap, before, after);
  const SpringSum is(springs_of(followed, scene.step), after);
  EXPECT_GT(followed.pair_count(), clip.pair_count());
  EXPECT_LT((is.stiffness - was.stiffness).norm(), 1e-9 * was.stiffness.norm());
  EXPECT_LT((is.force - was.force).norm(), 1e-9 * was.force.norm());
  EXPECT_LT((is.torque - was.torque).norm(), 1e-9 * was.largest_torque);
  double shares = 0, beyond = 0, all_beyond = 0;
  for (const auto& [vertex, weight] : followed.held()) {
    shares += weight;
    beyond += after[vertex.index()].x() > 1e-4 ? weight : 0;
  }
  for (const auto& [vertex, weight] : clip.held()) all_beyond += before[vertex.index()].x() > 1e-4 ? weight : 0;
  EXPECT_NEAR(shares, 1, 1e-12);
  EXPECT_NEAR(beyond, all_beyond, 1e-12);
}

// A clip that is askew on its tube would like to turn. It hangs on nothing but the tissue: what it does to it has no
// torque, or it would turn it for ever.
TEST(Clip, AskewItDoesNotTurnTheTissue) {
  Scene scene;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.35, Vec3(0.3, 1, 0.8).normalized()));
  const Vec3 middle(0, 0, 13.25 * mm);
  Clip clip(ClipFigures{}, applier(), {turn, middle - turn * middle}, 0.4, scene.tissue.surface(), scene.mesh);
  ASSERT_EQ(clip.state(), ClipState::closing);
  scene.run(clip, 60);
  ASSERT_EQ(clip.state(), ClipState::closed);
  const SpringSum sum(springs_of(clip, scene.step), scene.tissue.positions);
  EXPECT_LT(sum.torque.norm(), 1e-6 * sum.largest_torque);
  const std::vector<Vec3> before = scene.tissue.positions;
  scene.run(clip, 60);
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_LT((scene.tissue.positions[v] - before[v]).norm(), 0.05 * mm);
}

TEST(Clip, ASplitInItKeepsBothCopies) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  const TopologyEdit edit = part_the_middle(scene.mesh);
  const std::vector<Vec3> before = scene.tissue.positions;
  const Remap remap = apply(scene.mesh, edit);
  const std::vector<Vec3> after = carry_over(before, remap);
  Clip followed = clip;
  followed.follow(remap, before, after);
  EXPECT_EQ(followed.state(), ClipState::closed);
  EXPECT_GT(followed.pair_count(), clip.pair_count());
  EXPECT_EQ(followed.tets().size(), clip.tets().size());
  std::size_t doubled = 0;
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    EXPECT_EQ(followed.holds(remap.added_vertices[k]), clip.holds(remap.added_from[k].from));
    doubled += clip.holds(remap.added_from[k].from) ? 1 : 0;
  }
  EXPECT_GT(doubled, 0U);
}

TEST(Clip, IsLostWithItsTissue) {
  Scene scene = closed().scene;
  Clip clip = closed().clip;
  TopologyEdit edit;
  for (std::size_t t = 0; t < scene.mesh.tet_count(); ++t) {
    double nearest = 1;
    for (const VertexId v : scene.mesh.tets[t]) nearest = std::min(nearest, std::abs(scene.mesh.position(v).x()));
    if (nearest < 2.5 * mm) edit.removed.emplace_back(t);
  }
  const std::vector<Vec3> before = scene.tissue.positions;
  const Remap remap = apply(scene.mesh, edit);
  clip.follow(remap, before, carry_over(before, remap));
  EXPECT_EQ(clip.state(), ClipState::off);
  EXPECT_EQ(clip.pair_count(), 0U);
}

TEST(Clip, FiredAtNothingItIsOff) {
  const Scene scene;
  const Pose away{Eigen::Quaterniond::Identity(), {0, 0.1, 0}};
  const Clip clip(ClipFigures{}, applier(), away, 0.4, scene.tissue.surface(), scene.mesh);
  EXPECT_EQ(clip.state(), ClipState::off);
  EXPECT_THROW(
      Clip(ClipFigures{}, instrument_geometry(InstrumentKind::scissors), away, 0.4, scene.tissue.surface(), scene.mesh),
      std::runtime_error);
}

TEST(Clip, TwoOfThemKnowTheirSpacingAndTheSameInputGivesTheSameBytes) {
  std::string a, b;
  for (std::string* bytes : {&a, &b}) {
    Scene scene;
    Clip clip = scene.fire();
    scene.run(clip, 20, {0.1, 0, 0});
    clip.append_state(*bytes);
  }
  EXPECT_EQ(a, b);
  const Scene scene;
  const Pose beside{Eigen::Quaterniond::Identity(), {3 * mm, 0, 0}};
  const Clip second(ClipFigures{}, applier(), beside, 0.4, scene.tissue.surface(), scene.mesh);
  EXPECT_NEAR(spacing(scene.fire(), second), 3 * mm, 1e-12);
}

}  // namespace
}  // namespace calot
