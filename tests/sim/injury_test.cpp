#include "calot/sim/injury.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "calot/base/error.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

TissueProperties tissue() {
  TissueProperties p;
  p.blanching_pressure = 4e3;
  p.bruising_pressure = 100e3;
  p.bleeding_pressure = 200e3;
  p.bleeding_speed = 0.5;
  p.injury_rate = 1e-3;
  return p;
}

struct Bench {
  TetMesh mesh = test::box_mesh(2, 2, 2, {0.02, 0.02, 0.02});
  InjuryOptions options;
  Injury injury{mesh, {{1, tissue()}}, options};
  InjuryContact contact;
  Bench() {
    contact.point = {{mesh.tets[0][0], mesh.tets[0][1], mesh.tets[0][2]}, {0.5, 0.3, 0.2}, TetId(0)};
    contact.area = 1e-4;
  }
  const InjuryStep& step(double dt = 0.01) { return injury.step(dt, mesh, {&contact, 1}); }
  double blanching(int k) { return injury.blanching()[contact.point.vertices[k].index()]; }
  double bruising(int k) { return injury.bruising()[contact.point.vertices[k].index()]; }
};

TEST(Injury, BlanchesUnderPressureAndFadesOnReleaseWithItsTimeConstants) {
  Bench bench;
  bench.contact.force = 0.2;  // 2 kPa, half of what empties the capillaries
  for (int s = 0; s < 30; ++s) bench.step();
  EXPECT_NEAR(bench.blanching(0), 0.5 * (1 - std::exp(-0.3 / bench.options.blanching_time)), 1e-12);
  EXPECT_NEAR(bench.blanching(1), 0.6 * bench.blanching(0), 1e-12);  // by weight
  const double before = bench.blanching(0);
  for (int s = 0; s < 70; ++s) bench.injury.step(0.01, bench.mesh, {});
  EXPECT_NEAR(bench.blanching(0), before * std::exp(-0.7 / bench.options.refill_time), 1e-12);
  EXPECT_EQ(bench.bruising(0), 0);
}

TEST(Injury, BruisesInTimeAndStaysBruised) {
  Bench bench;
  bench.contact.force = 15;  // 150 kPa
  for (int s = 0; s < 100; ++s) EXPECT_TRUE(bench.step().onsets.empty());
  EXPECT_NEAR(bench.bruising(0), 0.5 / bench.options.bruising_time, 1e-12);
  for (int s = 0; s < 500; ++s) bench.injury.step(0.01, bench.mesh, {});
  EXPECT_NEAR(bench.bruising(0), 0.5 / bench.options.bruising_time, 1e-12);
}

TEST(Injury, BleedsOncePerBreakAndMoreWhenItBreaksFurther) {
  Bench bench;
  bench.contact.force = 30;  // 300 kPa: half broken
  const InjuryStep first = bench.step();
  ASSERT_EQ(first.onsets.size(), 1u);
  EXPECT_NEAR(first.onsets[0].rate, 1e-3 * 1e-4 * 0.5, 1e-18);
  EXPECT_EQ(first.onsets[0].region, 1);
  EXPECT_FALSE(first.onsets[0].impact);
  EXPECT_NEAR(first.highest_pressure, 300e3, 1e-6);
  EXPECT_TRUE(bench.step().onsets.empty());
  bench.contact.force = 100;
  const InjuryStep more = bench.step();
  ASSERT_EQ(more.onsets.size(), 1u);
  EXPECT_NEAR(more.onsets[0].rate, 1e-3 * 1e-4 * 0.5, 1e-18);  // the other half
  EXPECT_NEAR(bench.injury.breaks()[bench.contact.point.vertices[0].index()], 1, 1e-12);
}

TEST(Injury, AnEdgeIsWorseThanAShaftAndHeadOnWorseThanGrazing) {
  const auto rate = [](double force, double speed, double angle, bool edge) {
    Bench bench;
    bench.contact.force = force;
    bench.contact.speed = speed;
    bench.contact.angle = angle;
    bench.contact.edge = edge;
    double sum = 0;
    for (const BleedingOnset& onset : bench.step().onsets) sum += onset.rate;
    return sum;
  };
  const double right_angle = std::numbers::pi / 2;
  EXPECT_EQ(rate(10, 0, 0, false), 0);  // 100 kPa
  EXPECT_GT(rate(10, 0, 0, true), 0);
  EXPECT_GT(rate(1, 0.8, 0, false), 0);
  EXPECT_EQ(rate(1, 0.8, right_angle, false), 0);  // a shaft that slides along does no harm
  EXPECT_GT(rate(1, 0.8, right_angle, true), 0);   // an edge slices
  EXPECT_GT(rate(1, 0.8, 0.3, false), rate(1, 0.8, 0.6, false));
  EXPECT_GE(rate(1, 0.25, 0, true), rate(1, 0.25, right_angle, true));
  EXPECT_EQ(rate(0, 2, 0, true), 0);                  // near, but not touching
  EXPECT_EQ(rate(1, 2, std::numbers::pi, false), 0);  // moving away
}

TEST(Injury, FollowsAnEdit) {
  Bench bench;
  bench.contact.force = 30;
  bench.step();
  const VertexId v = bench.contact.point.vertices[0];
  TopologyEdit edit;
  edit.removed = {TetId(bench.mesh.tet_count() - 1)};
  const Remap remap = apply(bench.mesh, edit);
  const double before = bench.injury.breaks()[v.index()];
  bench.injury.follow(remap);
  EXPECT_EQ(bench.injury.breaks().size(), bench.mesh.vertex_count());
  EXPECT_EQ(bench.injury.breaks()[remap.vertex_to_new[v.index()].index()], before);
  Injury copy = bench.injury;
  std::string a, b;
  copy.append_state(a);
  bench.injury.append_state(b);
  EXPECT_EQ(a, b);
}

TEST(Injury, RefusesWhatIsNotOfThisMesh) {
  Bench bench;
  bench.contact.point.tet = TetId(100000);
  EXPECT_THROW(bench.step(), InputError);
  bench = Bench();
  bench.contact.force = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(bench.step(), InputError);
  EXPECT_THROW(Injury(bench.mesh, {}), InputError);
  bench = Bench();
  EXPECT_THROW(bench.step(0), InputError);
}

}  // namespace
}  // namespace calot
