// Tissue that lies, sticks and slides; held by a plane that does not move.
#include <gtest/gtest.h>

#include "tests/sim/world_scenes.h"

namespace calot {
namespace {

constexpr double g = 9.81, h = 1.0 / 60;

/// A plane z = 0, 1 m × 0.2 m, that only its upper side holds.
StillSurface plane(double friction) {
  Surface surface;
  surface.positions = {{-0.1, -0.1, 0}, {0.9, -0.1, 0}, {0.9, 0.1, 0}, {-0.1, 0.1, 0}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  return {std::move(surface), friction, false};
}

/// A flat free block on it; gravity leans by `angle` towards +x, as on a slope.
World block_on_a_slope(double angle, double friction, double young = 2e5) {
  TetMesh mesh = test::box_mesh(4, 4, 2, Vec3(0.02, 0.02, 0.006));
  for (Vec3& x : mesh.positions) x += Vec3(-0.01, -0.01, 1e-5);
  WorldSetup setup = test::world_setup(test::make_model(std::move(mesh), h, [](const Vec3&) { return false; },
                                                        {young, 0.4, 1000}, {.rayleigh_stiffness = 0.01}));
  setup.still.push_back(plane(friction));
  setup.options.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
  return World(std::move(setup));
}

Vec3 mean(const std::vector<Vec3>& values, const std::vector<double>& masses) {
  Vec3 sum = Vec3::Zero();
  double mass = 0;
  for (std::size_t v = 0; v < values.size(); ++v) {
    sum += masses[v] * values[v];
    mass += masses[v];
  }
  return sum / mass;
}

void run(World& world, int steps) {
  for (int k = 0; k < steps; ++k) {
    const StepReport& report = world.step({});
    ASSERT_TRUE(report.friction.converged) << report.step << " residual " << report.friction.residual;
    ASSERT_TRUE(report.free_motion.converged) << report.step;
    ASSERT_TRUE(report.response.converged) << report.step << " residual " << report.response.residual;
    ASSERT_FALSE(report.ran_away) << report.step;
    ASSERT_LT(report.deepest_overlap, 2e-4) << report.step;
  }
}

/// Forces of the plane on the block: along the slope, across it, and away from it [N].
Vec3 support(const World& world) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < world.contacts().size(); ++k)
    sum += contact_frame(world.contacts()[k].normal).transpose() *
           world.report().friction.forces.segment<3>(3 * static_cast<Eigen::Index>(k));
  return sum;
}

TEST(WorldFriction, ABlockSticksBelowItsFrictionAngle) {
  constexpr double friction = 0.4;
  for (const double share : {0.5, 0.95}) {
    const double angle = std::atan(share * friction);
    World world = block_on_a_slope(angle, friction);
    const std::vector<double> masses = world.model().vertex_masses();
    const double weight = g * 0.02 * 0.02 * 0.006 * 1000;
    run(world, 60);
    const Vec3 settled = mean(world.state().positions, masses);
    run(world, 60);
    // W is known in single precision: a part that nothing else holds creeps by some micrometres a second.
    EXPECT_LT((mean(world.state().positions, masses) - settled).norm(), 2e-5) << share;
    EXPECT_LT(test::fastest(world), 5e-5) << share;
    // The plane carries the weight, along the slope and across it.
    const Vec3 force = support(world);
    EXPECT_NEAR(force.z(), weight * std::cos(angle), 1e-3 * weight);
    EXPECT_NEAR(force.x(), -weight * std::sin(angle), 1e-3 * weight);
    EXPECT_NEAR(force.y(), 0, 1e-3 * weight);
  }
}

TEST(WorldFriction, ABlockSlidesAboveItsFrictionAngle) {
  constexpr double friction = 0.3;
  for (const double share : {1.1, 2.0}) {
    const double angle = std::atan(share * friction);
    World world = block_on_a_slope(angle, friction);
    const std::vector<double> masses = world.model().vertex_masses();
    run(world, 15);
    const Vec3 before = mean(world.state().velocities, masses);
    run(world, 20);
    const Vec3 gained = mean(world.state().velocities, masses) - before;
    const double expected = g * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(gained.x() / (20 * h), expected, 0.02 * expected) << share;
    EXPECT_NEAR(gained.y() / (20 * h), 0, 0.01 * expected) << share;
    EXPECT_LT(std::abs(mean(world.state().velocities, masses).z()), 2e-3) << share;
    const Vec3 force = support(world);
    EXPECT_NEAR(std::hypot(force.x(), force.y()), friction * force.z(), 0.01 * force.z()) << share;
  }
}

TEST(WorldFriction, WithoutFrictionItSlidesAsOnIce) {
  const double angle = 0.2;
  World world = block_on_a_slope(angle, 0);
  const std::vector<double> masses = world.model().vertex_masses();
  run(world, 30);
  EXPECT_NEAR(mean(world.state().velocities, masses).x(), 30 * h * g * std::sin(angle), 1e-3 * 30 * h * g);
}

}  // namespace
}  // namespace calot
