// The simulation's benchmarks on a small organ: every row is there, and what they say hangs together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/simulation_rows.h"
#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "tests/support/models.h"

namespace calot::bench {
namespace {

const Organ& small_organ() {
  static const Organ organ = organ_of(test::biliary_model(1.0 / 60));
  return organ;
}

const Row& row_named(const std::vector<Row>& rows, const std::string& name) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name == name; });
  if (row == rows.end()) throw std::runtime_error("no row " + name);
  return *row;
}

void expect_finite(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    EXPECT_TRUE(std::isfinite(row.value)) << row.name;
    EXPECT_LE(row.p50.value_or(0), row.p99.value_or(0)) << row.name;
    EXPECT_TRUE(std::isfinite(row.ratio.value_or(0))) << row.name;
  }
}

TEST(Operation, HoldsLiftsAndPresses) {
  Operation operation(small_organ(), {});
  warm_up(operation);
  EXPECT_TRUE(operation.holds());
  const World& world = operation.world();
  // The jaws went up by 30 mm along an arc, and took the tissue with them.
  const Vec3 moved = world.instruments()[Operation::grasper].to().position -
                     world.instruments()[Operation::grasper].setup().start.pose.position;
  EXPECT_GT(moved.norm(), 0.02);
  double lifted = 0;
  for (std::size_t v = 0; v < world.state().positions.size(); ++v)
    lifted = std::max(lifted, (world.state().positions[v] - world.model().mesh().positions[v]).norm());
  EXPECT_GT(lifted, 0.02);
  EXPECT_GE(world.contacts().size(), 4u);
  EXPECT_GE(operation.acting_contacts(), 2u);
  // The tubes are pushed apart.
  const Vec3 press = operation.pressing();
  EXPECT_LT(world.instruments()[Operation::second_tube].force.dot(press), 0);
  EXPECT_GT(world.instruments()[Operation::first_tube].force.dot(press), 0);
}

TEST(Operation, IsTheSameEveryTime) {
  Operation a(small_organ(), {}), b(small_organ(), {});
  for (int k = 0; k < 60; ++k) {
    a.step();
    b.step();
  }
  EXPECT_EQ(a.world().state_hash(), b.world().state_hash());
}

TEST(Operation, AnOrganWithoutABodyIsRefused) {
  Dynamics dynamics;
  EXPECT_THROW(Operation(organ_of(test::make_model(
                             test::box_mesh(6, 2, 2, Vec3(0.06, 0.02, 0.02)), 1.0 / 60,
                             [](const Vec3& x) { return x.x() < 1e-9; }, {}, dynamics)),
                         {}),
               InputError);
}

TEST(StepRows, HavePhasesGoalsAndRatios) {
  const std::vector<Row> rows = step_rows("step.small", small_organ(), {}, 8, 60);
  expect_finite(rows);
  const Row& step = row_named(rows, "step.small");
  EXPECT_EQ(step.unit, "ms");
  EXPECT_EQ(step.goal, 8.0);
  EXPECT_GT(step.value, 0);
  EXPECT_TRUE(step.ratio && *step.ratio > 0);
  double phases = 0;
  for (const char* phase : {"edits", "compliance", "free_motion", "detection", "contact", "response", "tissue"})
    phases += *row_named(rows, std::string("step.small.") + phase).ratio;
  EXPECT_NEAR(phases, 1, 1e-6) << "the phases make up the step";
  row_named(rows, "step.small.waiting");
  EXPECT_GE(*row_named(rows, "step.small.frame").max, *step.p50);
  EXPECT_LE(row_named(rows, "step.small.late_frames").value, 60);
  EXPECT_LT(*row_named(rows, "step.small.residual").p50, 1.001 * SolverOptions{}.tolerance);
  EXPECT_GT(*row_named(rows, "step.small.contacts").p50, 0);
  // Fewer iterations than plain conjugate gradients, whatever the machine does meanwhile.
  const Row& solve = row_named(rows, "step.small.solve");
  EXPECT_NE(solve.baseline.find("plain"), std::string::npos);
  EXPECT_LT(*row_named(rows, "step.small.solve.iterations").p50, 100);
  row_named(rows, "step.small.solve.block_jacobi");
}

TEST(ContactRows, SolveWhatTheWorldSolved) {
  const std::vector<Row> rows = contact_rows(small_organ(), 12);
  expect_finite(rows);
  EXPECT_LT(row_named(rows, "contact.solve.residual").max.value_or(1), 1e-3);
  EXPECT_GT(*row_named(rows, "contact.contacts").p50, 0);
  row_named(rows, "contact.detection");
  const Row& solve = row_named(rows, "contact.solve");
#ifdef CALOT_BENCH_SICONOS
  EXPECT_TRUE(solve.ratio && *solve.ratio > 0);
  EXPECT_NE(solve.baseline.find("Siconos"), std::string::npos);
  EXPECT_LT(*row_named(rows, "contact.siconos_nsgs.residual").p50, 1e-5);
  row_named(rows, "contact.siconos_newton");
#else
  EXPECT_FALSE(solve.ratio);
#endif
}

TEST(CutRows, AFullTransectionIsFollowedExactly) {
  // The benchmark's own organ: ducts of a few millimetres need a mesh that scissors can part.
  const Organ organ = make_organ_of_tets({}, 10000, 1.0 / 60);
  const std::vector<std::uint8_t>& fixed = organ.model.fixed();
  ASSERT_GT(std::count(fixed.begin(), fixed.end(), 1), 4) << "held, or it would count as severed as it is";
  const std::vector<Row> rows = cut_rows(organ, {0.4});
  expect_finite(rows);
  const Row& frame = row_named(rows, "cut.while_simulating");
  EXPECT_EQ(frame.goal, 16.7);
  EXPECT_TRUE(frame.ratio && *frame.ratio > 0);
  EXPECT_EQ(row_named(rows, "cut.while_simulating.transection").goal, 16.7);
  EXPECT_GE(*row_named(rows, "cut.while_simulating.transection").max, *frame.max);
  EXPECT_TRUE(row_named(rows, "cut.while_simulating.in_memory").ratio);
  EXPECT_EQ(row_named(rows, "cut.while_simulating.not_severed").value, 0);
  EXPECT_EQ(row_named(rows, "cut.operation.ran_away").value, 0);
  const Row& error = row_named(rows, "cut.while_simulating.error");
  EXPECT_GT(error.value, 0);
  EXPECT_TRUE(met(error)) << error.value << " bound " << *error.goal;
}

TEST(HapticRows, TickAThousandTimesASecond) {
  const std::vector<Row> rows = haptic_rows(small_organ(), 0.5);
  expect_finite(rows);
  EXPECT_EQ(row_named(rows, "haptics.jitter").goal, 0.2);
  EXPECT_NEAR(*row_named(rows, "haptics.period").p50, 1, 0.2);
  EXPECT_LE(*row_named(rows, "haptics.tick").p50, 1);
  EXPECT_GT(*row_named(rows, "haptics.force").max, 0.01) << "the device feels the tissue";
  row_named(rows, "haptics.missed");
  row_named(rows, "haptics.realtime");
}

}  // namespace
}  // namespace calot::bench
