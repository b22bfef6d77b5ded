#include <gtest/gtest.h>

#include <cmath>

#include "calot/base/error.h"
#include "calot/view/effects/burns.h"
#include "calot/view/effects/effects.h"
#include "calot/view/effects/gas.h"
#include "tests/view/effects_scenes.h"

namespace calot {
namespace {

using test::incline;
using test::next_step;

InstrumentSnapshot hook_at(const Vec3& tip, double power) {
  InstrumentSnapshot hook;
  hook.kind = InstrumentKind::hook;
  const InstrumentGeometry geometry = instrument_geometry(InstrumentKind::hook);
  hook.pose.position = tip - 0.5 * (geometry.hook_heel + geometry.hook_tip);
  hook.cautery = power;
  hook.energy = power > 0;
  return hook;
}

TEST(EffectsNoise, CurlHasNoDivergence) {
  for (int k = 0; k < 20; ++k) {
    const auto x = static_cast<float>(k);
    const Vec3f p(0.37F * x, 1.91F - 0.21F * x, 0.13F * x);
    constexpr float h = 1e-3F;
    float divergence = 0, size = 0;
    for (int i = 0; i < 3; ++i) {
      const Vec3f e = h * Vec3f::Unit(i);
      const Vec3f slope = (detail::curl_noise(p + e, 5) - detail::curl_noise(p - e, 5)) / (2 * h);
      divergence += slope[i];
      size += slope.cwiseAbs().sum();
    }
    EXPECT_NEAR(divergence, 0, 5e-3F * size + 1e-3F);
  }
}

TEST(EffectsGas, SmokeRisesSpreadsAndBecomesHaze) {
  detail::Gas gas{EffectsOptions{}};
  const detail::BurningTip tip{Vec3f::Zero(), Vec3f::UnitZ(), 30};
  for (int k = 0; k < 200; ++k) gas.step(0.01, {&tip, 1}, {}, Vec3f::UnitZ(), 1);
  ASSERT_GT(gas.puffs().size(), 20U);
  float height = 0, oldest = gas.puffs().front().spread, newest = gas.puffs().back().spread;
  for (const detail::Puff& puff : gas.puffs()) height += puff.position.z() / static_cast<float>(gas.puffs().size());
  EXPECT_GT(height, 0.02F);
  EXPECT_GT(oldest, 3 * newest);
  const double haze = gas.haze_mass();
  for (int k = 0; k < 1000; ++k) gas.step(0.01, {}, {}, Vec3f::UnitZ(), 1);
  EXPECT_GT(gas.haze_mass(), haze);
  EXPECT_NEAR(gas.made(), gas.haze_mass() + gas.smoke_in_puffs() + gas.taken(), 1e-9 * gas.made());
  const double expected = 30 * 2 * EffectsOptions{}.smoke_per_joule;
  EXPECT_NEAR(gas.made(), expected, 0.15 * expected);
}

/// Haze that nothing adds to falls off as exp(−t Q/V).
TEST(EffectsGas, ExchangeAndSuctionClearTheHazeAsAWellMixedVolume) {
  EffectsOptions options;
  options.puffs = 0;  // all of it haze at once
  for (const bool sucks : {false, true}) {
    detail::Gas gas(options);
    const detail::BurningTip tip{Vec3f::Zero(), Vec3f::UnitZ(), 40};
    for (int k = 0; k < 100; ++k) gas.step(0.01, {&tip, 1}, {}, Vec3f::UnitZ(), 1);
    const double before = gas.haze_mass();
    ASSERT_GT(before, 0);
    const Vec3f tube(0.05F, 0, 0);
    for (int k = 0; k < 2000; ++k)
      gas.step(0.01, {}, sucks ? std::span(&tube, 1) : std::span<const Vec3f>(), Vec3f::UnitZ(), 1);
    const double flow = options.gas_exchange + (sucks ? options.gas_suction : 0);
    EXPECT_NEAR(gas.haze_mass(), before * std::exp(-20 * flow / options.gas_volume), 1e-6 * before);
  }
}

TEST(EffectsGas, SuctionDrawsThePuffsIn) {
  const auto left = [](bool sucks) {
    EffectsOptions options;
    options.gas_exchange = 0;
    detail::Gas gas(options);
    const detail::BurningTip tip{Vec3f::Zero(), Vec3f::UnitZ(), 30};
    const Vec3f tube(0.012F, 0, 0.01F);
    const auto tubes = sucks ? std::span(&tube, 1) : std::span<const Vec3f>();
    for (int k = 0; k < 300; ++k) gas.step(0.01, {&tip, 1}, tubes, Vec3f::UnitZ(), 1);
    return (gas.smoke_in_puffs() + gas.haze_mass()) / gas.made();
  };
  EXPECT_GT(left(false), 0.99);
  EXPECT_LT(left(true), 0.7);
}

TEST(EffectsGas, PuffsAndSparksAreLimitedAndEnd) {
  Snapshot s = incline(0.0F, 20, 0.02F);
  EffectsOptions options;
  options.puffs = 30;
  options.sparks = 10;
  Effects effects(s, {}, options);
  s.instruments = {hook_at({0, 0, 0.0005}, 45)};
  std::size_t most_sparks = 0;
  for (int k = 0; k < 300; ++k) {
    next_step(s, 0);
    effects.advance(s, 1);
    ASSERT_LE(effects.state().puffs.size(), 30U);
    ASSERT_LE(effects.state().sparks.size(), 10U);
    most_sparks = std::max(most_sparks, effects.state().sparks.size());
  }
  EXPECT_GT(most_sparks, 2U);
  EXPECT_GT(effects.state().haze, 0);
  const float haze = effects.state().haze;
  s.instruments.clear();
  for (int k = 0; k < 40; ++k) {
    next_step(s, 0);
    effects.advance(s, 1);
  }
  EXPECT_TRUE(effects.state().sparks.empty());   // a fraction of a second
  EXPECT_GT(effects.state().haze, 0.5F * haze);  // it lingers
}

TEST(EffectsBurns, NoSmokeFarFromTissueOrWithoutPower) {
  Snapshot s = incline(0.0F, 20, 0.02F);
  Effects effects(s);
  s.instruments = {hook_at({0, 0, 0.05}, 45), hook_at({0, 0, 0.0005}, 0)};
  next_step(s, 0);
  effects.advance(s, 20);
  EXPECT_TRUE(effects.state().puffs.empty());
  EXPECT_TRUE(effects.state().sparks.empty());
}

TEST(EffectsBurns, CharredTissueIsPaintedAndStaysSoThroughACut) {
  Snapshot s = incline(0.0F, 40, 0.02F);
  Effects effects(s);
  const std::size_t middle = 20 * 41 + 20;
  s.conditions[middle].charred = 0.9F;
  next_step(s, 0);
  effects.advance(s, 3);
  EXPECT_GT(effects.state().mask.sample(Vec3f::Zero())[1], 120);
  EXPECT_LT(effects.state().mask.sample(Vec3f(0.01F, 0.01F, 0))[1], 1);
  ++s.skin.version;
  s.conditions[middle].charred = 0;
  next_step(s, 0);
  effects.advance(s, 3);
  EXPECT_GT(effects.state().mask.sample(Vec3f::Zero())[1], 120);
}

TEST(MaskVolume, KnowsItsSizeAndItsDirtyBoxes) {
  const Eigen::AlignedBox3f box(Vec3f(-0.05F, -0.02F, 0), Vec3f(0.05F, 0.02F, 0.03F));
  MaskVolume mask(box, 0.75e-3F, 8U << 20U);
  EXPECT_EQ(mask.size()[0], 134);
  EXPECT_LE(mask.bytes(), 8U << 20U);
  EXPECT_FLOAT_EQ(mask.voxel(), 0.75e-3F);
  const std::uint64_t before = mask.version();
  EXPECT_TRUE(mask.dirty_boxes(before).empty());
  EXPECT_EQ(mask.dirty_boxes(0).front().size, mask.size());
  const Vec3f at(0.01F, 0.005F, 0.02F);
  mask.paint(MaskChannel::charred, at, 2e-3F, 200);
  EXPECT_NEAR(mask.sample(at)[1], 200, 1);
  EXPECT_EQ(mask.sample(at)[0], 0);
  const auto boxes = mask.dirty_boxes(before);
  ASSERT_FALSE(boxes.empty());
  for (int z = 0; z < mask.size()[2]; ++z)
    for (int y = 0; y < mask.size()[1]; ++y)
      for (int x = 0; x < mask.size()[0]; ++x) {
        if (mask.at(x, y, z)[1] == 0) continue;
        bool inside = false;
        for (const VoxelBlock& b : boxes)
          inside = inside || (x >= b.first[0] && x < b.first[0] + b.size[0] && y >= b.first[1] &&
                              y < b.first[1] + b.size[1] && z >= b.first[2] && z < b.first[2] + b.size[2]);
        ASSERT_TRUE(inside);
      }
  EXPECT_TRUE(mask.dirty_boxes(mask.version()).empty());
  // Scattered: still few boxes, and every one within the volume.
  for (int k = 0; k < 60; ++k)
    mask.paint(MaskChannel::wet,
               Vec3f(-0.045F + 0.0015F * static_cast<float>(k), 0.0006F * static_cast<float>(k) - 0.018F, 0.015F),
               1e-3F, 255);
  EXPECT_LE(mask.dirty_boxes(before).size(), 16U);
  const MaskVolume small(box, 0.75e-3F, 1U << 20U);
  EXPECT_LE(small.bytes(), 1U << 20U);
  EXPECT_GT(small.voxel(), 0.75e-3F);
  EXPECT_THROW(MaskVolume(Eigen::AlignedBox3f(), 1e-3F, 1U << 20U), InputError);
  EXPECT_THROW(MaskVolume(box, 0, 1U << 20U), InputError);
  const Vec3f there = mask.texture_place(box.center());
  EXPECT_NEAR(there.x(), 0.5F, 1e-4F);
}

}  // namespace
}  // namespace calot
