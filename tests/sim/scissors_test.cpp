#include "calot/sim/scissors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace calot {
namespace {

const InstrumentGeometry& geometry() {
  static const InstrumentGeometry g = instrument_geometry(InstrumentKind::scissors);
  return g;
}

double area(const Sweep& sweep) {
  double sum = 0;
  for (const auto& t : sweep.triangles) sum += (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2;
  return sum;
}

/// ∫ 2 (r sin θ − e)/cos θ dr from the crossing point to the tips: the sector between the edges.
double sector(double opening) {
  const double s = std::sin(opening / 2), c = std::cos(opening / 2), e = geometry().blade_offset,
               length = geometry().jaw_length;
  const double beyond = length - e / s;
  return s / c * beyond * beyond;
}

/// No margins: what is compared is the geometry alone.
constexpr ScissorsFigures bare{0, 0, 1e-3};

TEST(Scissors, EdgesCrossWhereTheClosedFormSays) {
  const Scissors scissors(geometry());
  for (const double opening : {0.1, 0.3, 0.8}) {
    const double r = scissors.crossing(opening);
    // Blade a's edge, turned by half the opening, meets y = 0 at z = r: undo the turn and it lies on y = e.
    const Vec3 on_edge = articulate(geometry(), opening).jaw_a.inverse() * Vec3(0, 0, r);
    EXPECT_NEAR(on_edge.y(), geometry().blade_offset, 1e-15);
    EXPECT_EQ(scissors.half_gap(r, opening), 0);
    // Beyond: a point of the edge, seen from the instrument.
    const Vec3 seen = articulate(geometry(), opening).jaw_a * Vec3(0, geometry().blade_offset, 0.015);
    EXPECT_NEAR(scissors.half_gap(seen.z(), opening), std::max(0.0, -seen.y()), 1e-15);
  }
  EXPECT_EQ(scissors.crossing(0), geometry().jaw_length);
}

TEST(Scissors, AFullCloseSweepsTheSectorOfTheBlades) {
  const double opening = 0.2;  // the backs reach over the whole sector
  Scissors once(geometry(), opening, bare), gradual(geometry(), opening, bare);
  EXPECT_NEAR(area(once.close({}, {}, 0)), sector(opening), 1e-9 * sector(opening));
  double sum = 0;
  for (int k = 1; k <= 50; ++k) sum += area(gradual.close({}, {}, opening * (1 - k / 50.0)));
  EXPECT_NEAR(sum, sector(opening), 1e-9 * sector(opening));
}

TEST(Scissors, StripsOfSuccessiveStepsJoin) {
  Scissors scissors(geometry(), 0.7, bare);
  const auto pose_at = [](int k) {
    return Pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.01 * k, Vec3::UnitZ())), {1e-4 * k, 0, 2e-4 * k}};
  };
  std::vector<Sweep> sweeps;
  for (int k = 0; k < 20; ++k) {
    Sweep sweep = scissors.close(pose_at(k), pose_at(k + 1), 0.7 - 0.03 * (k + 1));
    if (!sweep.triangles.empty()) sweeps.push_back(std::move(sweep));
  }
  ASSERT_GT(sweeps.size(), 15U);
  for (std::size_t k = 1; k < sweeps.size(); ++k) {
    // The last rung of one is the first rung of the next; its height may change as the blades' backs come closer.
    const auto& end = sweeps[k - 1].triangles.back();
    const auto& start = sweeps[k].triangles.front();
    const Vec3 last = sweeps[k - 1].triangles[sweeps[k - 1].triangles.size() - 2][2];
    const Vec3 middle_end = (sweeps[k - 1].triangles[sweeps[k - 1].triangles.size() - 2][1] + last) / 2;
    const Vec3 middle_start = (start[0] + sweeps[k].triangles[1][2]) / 2;
    EXPECT_LT((middle_end - middle_start).norm(), 1e-12);
    EXPECT_EQ(end[1], last);
    const Vec3 axis = (last - middle_end).normalized(), other = (start[0] - middle_start).normalized();
    EXPECT_NEAR(std::abs(axis.dot(other)), 1, 1e-12);
  }
}

TEST(Scissors, AStepBeginsALittleBehindTheOneBefore) {
  const ScissorsFigures figures;
  Scissors scissors(geometry(), 0.5, figures);
  scissors.close({}, {}, 0.3);
  const double r = scissors.crossing(0.3);
  const Sweep sweep = scissors.close({}, {}, 0.25);
  ASSERT_FALSE(sweep.triangles.empty());
  EXPECT_NEAR(sweep.triangles.front()[0].z(), r - figures.overlap, 1e-12);
  EXPECT_NEAR(sweep.triangles.back()[1].z(), scissors.crossing(0.25), 1e-12);
}

TEST(Scissors, OpeningRestingAndOverlappingCutNothing) {
  Scissors scissors(geometry(), 0.3);
  EXPECT_TRUE(scissors.close({}, {}, 0.5).triangles.empty());
  EXPECT_TRUE(scissors.close({}, {}, 0.5).triangles.empty());
  const Pose ahead{Eigen::Quaterniond::Identity(), {0, 0, 0.001}};
  EXPECT_TRUE(scissors.close({}, ahead, 0.5).triangles.empty());  // pushed on without closing
  EXPECT_FALSE(scissors.close({}, {}, 0).triangles.empty());
  EXPECT_TRUE(scissors.close({}, {}, 0).triangles.empty());
}

TEST(Scissors, PullingBackFasterThanTheyCloseCutsNothing) {
  Scissors scissors(geometry(), 0.5);
  const Pose back{Eigen::Quaterniond::Identity(), {0, 0, -0.02}};
  EXPECT_TRUE(scissors.close({}, back, 0.45).triangles.empty());
}

TEST(Scissors, TipsAloneCutAndASnipCanBePartial) {
  Scissors tips(geometry(), 0.12, bare);
  const Sweep tip = tips.close({}, {}, 0);
  ASSERT_FALSE(tip.triangles.empty());
  for (const auto& t : tip.triangles)
    for (const Vec3& corner : t) EXPECT_GT(corner.z(), 13e-3);
  Scissors partial(geometry(), 0.8, bare);
  double far = 0;
  for (const auto& t : partial.close({}, {}, 0.2).triangles)
    for (const Vec3& corner : t) far = std::max(far, corner.z());
  EXPECT_NEAR(far, geometry().blade_offset / std::sin(0.1), 1e-12);
  EXPECT_LT(far, 9e-3);
}

TEST(Scissors, TissueBehindTheBacksIsSafe) {
  Scissors scissors(geometry(), 0.8, bare);
  scissors.close({}, {}, 0.15);
  // Nearly closed: what lay between the open blades but is behind their backs now is not cut.
  for (const auto& t : scissors.close({}, {}, 0.1).triangles)
    for (const Vec3& corner : t)
      EXPECT_LE(std::abs(corner.y()), scissors.half_gap(corner.z(), 0.15) + geometry().blade_depth);
}

TEST(Scissors, RefusesWhatHasNoBladesAndIsDeterministic) {
  EXPECT_THROW(Scissors(instrument_geometry(InstrumentKind::hook)), std::runtime_error);
  std::string a, b;
  for (std::string* state : {&a, &b}) {
    Scissors scissors(geometry(), 0.6);
    for (int k = 0; k < 10; ++k) scissors.close({}, {}, 0.6 - 0.05 * k);
    scissors.append_state(*state);
  }
  EXPECT_EQ(a, b);
}

}  // namespace
}  // namespace calot
