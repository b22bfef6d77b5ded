#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "calot/base/error.h"
#include "calot/view/effects/effects.h"
#include "calot/view/effects/surface_fluid.h"
#include "tests/view/effects_scenes.h"

namespace calot {
namespace {

using test::incline;
using test::next_step;
using test::put_source;
using test::sheet_snapshot;

void expect_conserved(const FluidLedger& ledger) {
  EXPECT_NEAR(ledger.accounted(), ledger.shed, 1e-9 * ledger.shed + 1e-18);
}

bool finite(const EffectsState& state) {
  bool good = std::isfinite(state.haze);
  for (const DropState& d : state.drops) good = good && d.position.allFinite() && d.velocity.allFinite();
  for (const PuffState& p : state.puffs) good = good && p.position.allFinite() && std::isfinite(p.depth);
  for (const PoolVertex& v : state.pool_vertices)
    good = good && v.position.allFinite() && v.normal.allFinite() && std::isfinite(v.thickness);
  for (const SparkState& s : state.sparks) good = good && s.position.allFinite();
  return good && std::isfinite(state.blood.accounted()) && std::isfinite(state.bile.accounted());
}

std::string bytes_of(const EffectsState& state) {
  std::string out(reinterpret_cast<const char*>(state.mask.data()), state.mask.bytes());
  const auto add = [&](const auto& x) { out.append(reinterpret_cast<const char*>(&x), sizeof x); };
  for (const DropState& d : state.drops) add(d.position), add(d.radius);
  for (const PuffState& p : state.puffs) add(p.position), add(p.depth);
  for (const SparkState& s : state.sparks) add(s.position);
  for (const PoolVertex& v : state.pool_vertices) add(v.position), add(v.thickness);
  add(state.blood.running), add(state.blood.film), add(state.blood.pooled), add(state.haze);
  return out;
}

TEST(EffectsFilm, LensHasItsVolumeAndAPuddleItsDepth) {
  const detail::Liquid blood;
  for (const double volume : {1e-10, 1e-9, 1e-8, 1e-7, 1e-6}) {
    const detail::LensShape lens = detail::lens_shape(blood, volume, 0.6);
    const double cap = std::numbers::pi * lens.depth * (3 * lens.radius * lens.radius + lens.depth * lens.depth) / 6;
    EXPECT_NEAR(cap, volume, 1e-9 * volume);
  }
  // Far larger than the capillary length: depth 2 √(γ/ρg) sin(θ/2) whatever the volume.
  const double deep = 2 * std::sqrt(0.056 / (1060 * 9.81)) * std::sin(0.3);
  EXPECT_NEAR(detail::lens_shape(blood, 1e-5, 0.6).depth, deep, 1e-12);
  EXPECT_EQ(detail::lens_shape(blood, 0, 0.6).radius, 0);
}

/// Nothing held back, nothing left behind: ρ g sin(a) h² / (3 μ) with the parcel's own mean thickness.
TEST(EffectsFluid, RunsDownAPlaneAsFastAsAViscousFilm) {
  for (const float angle : {0.3F, 0.7F}) {
    const Snapshot s = incline(angle);
    EffectsOptions options;
    options.retention = options.left_behind = 0;
    detail::SurfaceFluid fluid(s, {}, options);
    const double volume = 1e-9;
    const auto start = fluid.skin().nearest(Vec3f(-0.04F, 0.001F, std::tan(angle) * 0.04F), 0.01F);
    ASSERT_TRUE(start);
    fluid.pour({false, start->seat}, Fluid::blood, volume);
    for (int k = 0; k < 50; ++k) fluid.step(0.01);
    const auto from = fluid.position(fluid.parcels().front().place);
    for (int k = 0; k < 50; ++k) fluid.step(0.01);
    ASSERT_EQ(fluid.parcels().size(), 1U);
    const auto to = fluid.position(fluid.parcels().front().place);
    const detail::Liquid blood;
    const detail::LensShape lens = detail::lens_shape(blood, volume, 0.7);
    const double h = volume / (std::numbers::pi * lens.radius * lens.radius);
    const double expected = 1060 * 9.81 * std::sin(angle) * h * h / (3 * 3.5e-3);
    // It wanders aside; along its way, not as the crow flies, it has this speed.
    EXPECT_NEAR(static_cast<double>(fluid.parcels().front().velocity.norm()), expected, 1e-3 * expected);
    const double straight = static_cast<double>((to - from).norm()) / 0.5;
    EXPECT_LE(straight, 1.001 * expected);
    EXPECT_GE(straight, 0.8 * expected);
    EXPECT_GT((to - from).x(), 0);
    EXPECT_LT((to - from).z(), 0);
  }
}

TEST(EffectsFluid, DryTissueHoldsASmallDropThatAWetOneLetsGo) {
  const Snapshot s = incline(0.3F);
  detail::SurfaceFluid fluid(s, {}, {});
  const auto start = fluid.skin().nearest(Vec3f(-0.02F, 0, 0.00619F), 0.01F);
  ASSERT_TRUE(start);
  fluid.pour({false, start->seat}, Fluid::blood, 0.8e-9);
  for (int k = 0; k < 30; ++k) fluid.step(0.01);
  ASSERT_EQ(fluid.parcels().size(), 1U);
  EXPECT_LT((fluid.position(fluid.parcels()[0].place) - fluid.skin().position(start->seat)).norm(), 0.5e-3F);
  fluid.pour({false, start->seat}, Fluid::blood, 20e-9);
  for (int k = 0; k < 60; ++k) fluid.step(0.01);
  float farthest = 0;
  for (const detail::Parcel& parcel : fluid.parcels()) farthest = std::max(farthest, fluid.position(parcel.place).x());
  EXPECT_GT(farthest, -0.01F);
}

TEST(EffectsFluid, BloodIsConservedFromSourceToDripAndPool) {
  // A hill with a hollow on its side: runs, pools, over the border, drips.
  Snapshot s = sheet_snapshot(
      0.04F, 40, [](float x, float y) { return 0.02F - 0.5F * x + 0.006F * std::cos(150 * x) * std::cos(120 * y); });
  put_source(s, 3, Fluid::blood, Vec3f(-0.02F, 0, 0.03F));
  put_source(s, 4, Fluid::bile, Vec3f(-0.01F, 0.015F, 0.02F));
  Effects effects(s);
  for (int k = 0; k < 1500; ++k) {
    next_step(s, k < 1000 ? 0.3e-6 : 0);
    effects.advance(s, 1);
    if (k % 100 != 99) continue;
    expect_conserved(effects.state().blood);
    expect_conserved(effects.state().bile);
    ASSERT_TRUE(finite(effects.state()));
  }
  const FluidLedger& blood = effects.state().blood;
  EXPECT_NEAR(blood.shed, 3e-6, 1e-12);
  EXPECT_GT(blood.film, 1e-9);
  EXPECT_GT(blood.pooled, 1e-8);
  EXPECT_GT(blood.gone, 1e-7);  // over the border
  EXPECT_LT(blood.wells, 1e-8);
}

TEST(EffectsFluid, AHollowFillsAndThenRunsOver) {
  Snapshot s = sheet_snapshot(0.03F, 40, [](float x, float y) {
    const float r = std::hypot(x, y);
    return r < 0.012F ? 20 * r * r : 0.00288F - 0.4F * (r - 0.012F);
  });
  put_source(s, 0, Fluid::blood, Vec3f(0.003F, 0, 0));
  Effects effects(s);
  const auto run = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      next_step(s, 0.2e-6);
      effects.advance(s, 1);
    }
  };
  run(150);
  EXPECT_EQ(effects.state().blood.gone, 0);
  EXPECT_GT(effects.state().blood.pooled, 0.4 * effects.state().blood.shed);
  ASSERT_FALSE(effects.state().pools.empty());
  run(1500);
  EXPECT_GT(effects.state().blood.gone, 0);
  expect_conserved(effects.state().blood);
}

TEST(EffectsFluid, DripsFromAnOverhangOntoWhatLiesBelow) {
  // The underside of a bowl, and a still floor 40 mm below.
  Snapshot s = sheet_snapshot(0.02F, 30, [](float x, float y) { return 30 * (x * x + y * y); });
  for (Triangle& t : s.skin.triangles) std::swap(t[1], t[2]);
  Surface floor;
  floor.positions = {{-0.1, -0.1, -0.04}, {0.1, -0.1, -0.04}, {0.1, 0.1, -0.04}, {-0.1, 0.1, -0.04}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  put_source(s, 0, Fluid::blood, Vec3f(0.01F, 0, 0.003F));
  Effects effects(s, {&floor, 1});
  bool flew = false, splashed = false;
  for (int k = 0; k < 1000; ++k) {
    next_step(s, 0.1e-6);
    effects.advance(s, 1);
    for (const DropState& drop : effects.state().drops) {
      flew = true;
      splashed = splashed || drop.velocity.z() > 0;
      EXPECT_GT(drop.position.z(), -0.0401F);
    }
  }
  EXPECT_TRUE(flew);
  EXPECT_TRUE(splashed);
  expect_conserved(effects.state().blood);
  EXPECT_EQ(effects.state().blood.gone, 0);
  bool on_floor = false;
  for (const PoolState& pool : effects.state().pools)
    on_floor = on_floor || std::abs(pool.position.z() + 0.04F) < 1e-4F;
  EXPECT_TRUE(on_floor);
}

TEST(EffectsFluid, ACutLosesNothing) {
  Snapshot s = incline(0.5F);
  put_source(s, 0, Fluid::blood, Vec3f(-0.03F, 0, 0.0164F));
  Effects effects(s);
  for (int k = 0; k < 200; ++k) {
    next_step(s, 0.2e-6);
    effects.advance(s, 1);
  }
  const double running = effects.state().blood.running + effects.state().blood.pooled;
  EXPECT_GT(running, 1e-9);
  // Other numbers for everything, and a strip is gone: what ran there falls.
  Snapshot cut = s;
  ++cut.skin.version;
  cut.skin.triangles.clear();
  for (std::size_t t = s.skin.triangles.size(); t-- > 0;) {
    const Triangle& old = s.skin.triangles[t];
    const float x = s.positions[old[0]].x();
    if (x > 0.0F && x < 0.012F) continue;
    cut.skin.triangles.push_back({old[1], old[2], old[0]});
  }
  cut.fluids[0].triangle = {9999999, 0, 1};  // and its source names no triangle: the nearest serves
  next_step(cut, 0.2e-6);
  effects.advance(cut, 1);
  expect_conserved(effects.state().blood);
  for (int k = 0; k < 400; ++k) {
    next_step(cut, 0.2e-6);
    effects.advance(cut, 1);
  }
  expect_conserved(effects.state().blood);
  EXPECT_NEAR(effects.state().blood.shed, 601 * 0.2e-8, 1e-12);
  EXPECT_GT(effects.state().blood.gone, 0);
  EXPECT_GT(effects.state().blood.running + effects.state().blood.pooled, 0);
}

TEST(EffectsFluid, OnlyRenumberedItStaysWhereItIs) {
  Snapshot s = incline(0.1F);
  detail::SurfaceFluid fluid(s, {}, {});
  const auto start = fluid.skin().nearest(Vec3f(0.0103F, 0.0021F, -0.001F), 0.01F);
  ASSERT_TRUE(start);
  fluid.pour({false, start->seat}, Fluid::bile, 1e-9);
  const Vec3f before = fluid.position(fluid.parcels()[0].place);
  ++s.skin.version;
  std::reverse(s.skin.triangles.begin(), s.skin.triangles.end());
  for (Triangle& t : s.skin.triangles) t = {t[2], t[0], t[1]};
  fluid.take(s, 0);
  ASSERT_EQ(fluid.parcels().size(), 1U);
  EXPECT_LT((fluid.position(fluid.parcels()[0].place) - before).norm(), 1e-6F);
}

TEST(EffectsFluid, FollowsTissueThatMoves) {
  Snapshot s = incline(0.0F);
  detail::SurfaceFluid fluid(s, {}, {});
  const auto start = fluid.skin().nearest(Vec3f(0.01F, 0, 0), 0.01F);
  fluid.pour({false, start->seat}, Fluid::blood, 5e-9);
  for (int k = 0; k < 200; ++k) fluid.step(0.01);
  ASSERT_EQ(fluid.pools().size(), 1U);
  const Vec3f before = fluid.position(fluid.pools()[0].place), lift(0.01F, -0.02F, 0.03F);
  for (Vec3f& p : s.positions) p += lift;
  fluid.take(s, 0);
  EXPECT_LT((fluid.position(fluid.pools()[0].place) - before - lift).norm(), 1e-6F);
}

TEST(EffectsFluid, SuctionTakesPoolsAndThinsTheFilm) {
  Snapshot s = incline(0.0F);
  put_source(s, 0, Fluid::blood, Vec3f::Zero());
  Effects effects(s);
  for (int k = 0; k < 300; ++k) {
    next_step(s, 0.1e-6);
    effects.advance(s, 1);
  }
  const FluidLedger before = effects.state().blood;
  const float stained = effects.state().mask.sample(Vec3f::Zero())[0];
  EXPECT_GT(stained, 100);
  InstrumentSnapshot tube;
  tube.kind = InstrumentKind::suction;
  tube.pose.position = {0, 0, 0.002};
  tube.energy = true;
  s.instruments.push_back(tube);
  for (int k = 0; k < 200; ++k) {
    next_step(s, 0);
    effects.advance(s, 1);
  }
  const FluidLedger& after = effects.state().blood;
  expect_conserved(after);
  EXPECT_GT(after.sucked, 0.9 * (before.pooled + before.running));
  EXPECT_LT(effects.state().mask.sample(Vec3f::Zero())[0], 0.2F * stained);
}

TEST(EffectsFluid, LimitsHoldAndLoseNothing) {
  Snapshot s = sheet_snapshot(
      0.04F, 40, [](float x, float y) { return -0.4F * x + 0.003F * std::sin(400 * x) * std::sin(400 * y); });
  for (std::uint32_t id = 0; id < 8; ++id)
    put_source(s, id, Fluid::blood, Vec3f(-0.03F, -0.03F + 0.008F * static_cast<float>(id), 0.012F));
  EffectsOptions options;
  options.parcels = 40;
  options.pools = 5;
  options.drops = 6;
  Effects effects(s, {}, options);
  for (int k = 0; k < 600; ++k) {
    next_step(s, 0.5e-6);
    effects.advance(s, 1);
    ASSERT_LE(effects.state().drops.size(), 6U);
    ASSERT_LE(effects.state().pools.size(), 5U + 8U);
  }
  expect_conserved(effects.state().blood);
}

TEST(EffectsFluid, SameSnapshotsSameBytes) {
  const auto once = [](std::uint64_t seed) {
    Snapshot s = sheet_snapshot(0.03F, 24, [](float x, float y) { return -0.6F * x + 20 * y * y; });
    put_source(s, 0, Fluid::blood, Vec3f(-0.02F, 0, 0.012F));
    EffectsOptions options;
    options.seed = seed;
    Effects effects(s, {}, options);
    InstrumentSnapshot hook;
    hook.kind = InstrumentKind::hook;
    hook.cautery = 20;
    hook.pose.position = {0.001, 0.002, -instrument_geometry(InstrumentKind::hook).hook_tip.z()};
    s.instruments.push_back(hook);
    for (int k = 0; k < 150; ++k) {
      next_step(s, 0.3e-6);
      effects.advance(s, 1);
    }
    return bytes_of(effects.state());
  };
  EXPECT_EQ(once(1), once(1));
  EXPECT_NE(once(1), once(2));
}

TEST(EffectsFluid, TakesWhateverASnapshotHolds) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  Snapshot s = incline(0.4F, 20, 0.02F);
  put_source(s, 0, Fluid::blood, Vec3f(-0.01F, 0, 0.004F));
  Effects effects(s);
  const auto go = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      next_step(s, 0.3e-6);
      effects.advance(s, 1);
    }
    EXPECT_TRUE(finite(effects.state()));
    expect_conserved(effects.state().blood);
  };
  go(60);
  for (std::size_t v = 200; v < 240; ++v) s.positions[v] = s.positions[200];  // no area
  go(40);
  s.positions[150] = Vec3f(nan, 0, 0);
  s.fluids[0].position = Vec3f(nan, nan, nan);
  go(40);
  ++s.skin.version;
  s.skin.triangles.push_back({0, 1, 4000000000U});
  s.skin.vertices[3].vertex = 4000000000U;
  s.skin.vertices[5].rest = Vec3f(nan, 0, nan);
  go(40);
  s.positions.resize(10);  // too few
  go(10);
  Snapshot empty;
  empty.time_step = 0.01;
  empty.skin.version = 9;
  empty.step = s.step + 5;
  effects.advance(empty, 5);
  EXPECT_TRUE(finite(effects.state()));
  expect_conserved(effects.state().blood);
  Effects nothing((Snapshot()));
  nothing.advance(empty, 20);
  EXPECT_EQ(nothing.state().mask.bytes(), 0U);
}

TEST(EffectsFluid, OptionsOutOfRangeAreRefused) {
  const Snapshot s = incline(0.4F, 4);
  EffectsOptions options;
  options.voxel = 0;
  EXPECT_THROW(Effects(s, {}, options), InputError);
  options = {};
  options.parcels = 0;
  EXPECT_THROW(Effects(s, {}, options), InputError);
  options = {};
  options.blood_viscosity = 0;
  EXPECT_THROW(Effects(s, {}, options), InputError);
  options = {};
  options.gas_volume = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Effects(s, {}, options), InputError);
}

}  // namespace
}  // namespace calot
