// Tissue whose surroundings carry its weight: it stays as it lies while something holds it, and falls once it is cut
// off.
#include <gtest/gtest.h>

#include "tests/sim/world_scenes.h"

namespace calot {
namespace {

constexpr double mm = 1e-3, h = 1.0 / 60, g = 9.81, density = 1000;

/// A carried slab of 40 × 10 × 5 mm, held at x = 0.
WorldSetup slab() {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(8, 2, 1, Vec3(40 * mm, 10 * mm, 5 * mm)), h,
                                                        [](const Vec3& x) { return x.x() < 1e-9; }, {5e3, 0.4, density},
                                                        {.rayleigh_stiffness = 0.01}));
  setup.options.gravity = Vec3(0, 0, -g);
  setup.options.carried = {1};
  return setup;
}

void sever(World& world, double x) {
  const SplitEdit cut = split(world.model().mesh(), Plane{Vec3(x, 0, 0), Vec3::UnitX()});
  ASSERT_FALSE(cut.empty());
  ASSERT_NE(world.edit(cut, EventKind::cut, "cut"), nullptr);
}

/// Largest and smallest way down of the vertices whose rest place is beyond x; and of the others.
struct Fall {
  double least = 1, most = -1, others = 0;
};
Fall fall_beyond(const World& world, double x) {
  Fall fall;
  for (const Tet& tet : world.model().mesh().tets) {
    double middle = 0;
    for (const VertexId v : tet) middle += world.model().mesh().position(v).x() / 4;
    for (const VertexId v : tet) {
      const Vec3 u = world.state().positions[v.index()] - world.model().mesh().position(v);
      if (middle > x) {
        fall.least = std::min(fall.least, -u.z());
        fall.most = std::max(fall.most, -u.z());
      } else {
        fall.others = std::max(fall.others, u.norm());
      }
    }
  }
  return fall;
}

TEST(WorldCarried, ASlabStaysUntilItIsCutOffAndThenFalls) {
  World world(slab());
  for (int k = 0; k < 60; ++k) world.step({});
  EXPECT_LT(fall_beyond(world, 0).most, 1e-12);
  EXPECT_EQ(test::fastest(world), 0);
  sever(world, 22 * mm);
  const int steps = 18;  // 0.3 s
  double energy = world.energy();
  for (int k = 0; k < steps; ++k) {
    world.step({});
    EXPECT_LE(world.energy(), energy + 1e-9);
    energy = world.energy();
  }
  const Fall fall = fall_beyond(world, 22 * mm);
  // Implicit Euler: v_n = n h g; the sum of its steps is g t²/2 and half a step more.
  const double t = steps * h, euler = g * h * h * steps * (steps + 1) / 2;
  EXPECT_NEAR(fall.least, euler, 1e-4 * euler);
  EXPECT_NEAR(fall.most, euler, 1e-4 * euler);
  EXPECT_NEAR(euler, g * t * t / 2 + g * h * t / 2, 1e-12);
  EXPECT_LT(fall.others, 1e-9);
}

TEST(WorldCarried, WithoutItTheSameSlabSinks) {
  WorldSetup setup = slab();
  setup.options.carried = {};
  World world(std::move(setup));
  for (int k = 0; k < 60; ++k) world.step({});
  EXPECT_GT(fall_beyond(world, 0).most, 1 * mm);
}

/// What springs between tissue tie to a held part is held with it: by a ligament here, as by a clip.
TEST(WorldCarried, TissueTiedToWhatIsHeldStays) {
  for (const bool tied : {true, false}) {
    WorldSetup setup = slab();
    World whole(std::move(setup));
    sever(whole, 20 * mm);
    WorldSetup two = slab();
    two.model = whole.model();
    if (tied) {
      const TetMesh& mesh = two.model.mesh();
      Spring spring;  // between the corners at y = z = 0 on both sides of the cut
      for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        double middle = 0;
        for (const VertexId v : mesh.tets[t]) middle += mesh.position(v).x() / 4;
        for (const VertexId v : mesh.tets[t])
          if ((mesh.position(v) - Vec3(20 * mm, 0, 0)).norm() < 1e-9)
            (middle > 20 * mm ? spring.vertex : spring.other) = v;
      }
      ASSERT_TRUE(spring.vertex.valid() && spring.other.valid());
      ASSERT_NE(spring.vertex, spring.other);
      spring.stiffness = 10 * Mat3::Identity();
      two.ligaments = {spring};
    }
    World world(std::move(two));
    for (int k = 0; k < 12; ++k) world.step({});
    const Fall fall = fall_beyond(world, 20 * mm);
    EXPECT_LT(fall.others, 1e-9);
    if (tied) {
      EXPECT_LT(fall.most, 1e-9);
    } else {
      EXPECT_NEAR(fall.most, g * h * h * 12 * 13 / 2, 1e-5);
    }
  }
}

/// A carried strip, 20 × 4 × 20 mm, held below and in a grasper's jaws by its top edge, is cut off below them.
TEST(WorldCarried, JawsCarryTheWeightOfWhatIsCutOff) {
  WorldSetup setup = test::world_setup(test::make_model(test::box_mesh(10, 2, 10, Vec3(20 * mm, 4 * mm, 20 * mm)), h,
                                                        [](const Vec3& x) { return x.z() < 1e-9; },
                                                        {400e3, 0.4, density}, {.rayleigh_stiffness = 0.01}));
  setup.options.gravity = Vec3(0, 0, -g);
  setup.options.carried = {1};
  setup.instruments.push_back(test::instrument(InstrumentKind::bowel_grasper, Vec3(24 * mm, 2 * mm, 18.5 * mm),
                                               -Vec3::UnitX(), -Vec3::UnitZ(), 0.5));
  setup.instruments[0].start.grip = 3;
  World world(std::move(setup));
  InstrumentInput input = world.instruments()[0].setup().start;
  for (int k = 0; k < 90; ++k) {
    input.opening = std::max(0.0, 0.5 - 0.02 * (k + 1));
    world.step(test::Inputs{input});
  }
  const InstrumentArm& arm = world.instruments()[0];
  ASSERT_TRUE(arm.grasp->holding());
  const SplitEdit cut = split(world.model().mesh(), Plane{Vec3(0, 0, 5 * mm), Vec3::UnitZ()});
  ASSERT_NE(world.edit(cut, EventKind::cut, "cut"), nullptr);
  for (int k = 0; k < 180; ++k) {
    if (k < 60) input.pose.position.z() += 0.05 * mm;  // off the stump
    world.step(test::Inputs{input});
  }
  ASSERT_TRUE(arm.grasp->holding());
  const double weight = density * 20 * 4 * 15 * mm * mm * mm * g;
  EXPECT_NEAR(arm.force.z(), -weight, 0.05 * weight);
  EXPECT_LT(test::fastest(world), 1e-4);
}

}  // namespace
}  // namespace calot
