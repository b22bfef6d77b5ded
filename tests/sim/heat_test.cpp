#include "calot/sim/heat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calot/base/error.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

constexpr double body = 37;

TissueProperties plain(double perfusion = 0) {
  TissueProperties p;
  p.conductivity = 0.5;
  p.specific_heat = 3600;
  p.density = 1000;
  p.perfusion = perfusion;
  return p;
}

HeatOptions closed() {  // nothing leaves through the surface, everything conducts
  HeatOptions options;
  options.surface_exchange = 0;
  options.threshold = 1e-12;
  return options;
}

double balance_error(const TissueHeat& heat) {
  const HeatLedger& l = heat.ledger();
  const double gone = l.perfused + l.exchanged + l.removed - l.reshaped;
  return std::abs(l.supplied - heat.stored() - gone) / l.supplied;
}

/// A slab whose temperature starts as a cosine: it keeps its shape and decays as exp(−α k² t).
/// @return the error of the amplitude after a quarter of it is gone, relative
double cosine_error(int cells, int steps) {
  const double length = 0.02;
  const TetMesh mesh = test::box_mesh(cells, 1, 1, {length, length / cells, length / cells});
  TissueHeat heat(mesh, {{1, plain()}}, closed());
  const double k = std::numbers::pi / length, alpha = 0.5 / (1000 * 3600);
  const double duration = std::log(4.0 / 3) / (alpha * k * k);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    heat.set_temperature(VertexId(v), body + 5 + 4 * std::cos(k * mesh.positions[v].x()));
  for (int s = 0; s < steps; ++s) heat.step(duration / steps, {}, mesh, mesh.positions);
  double worst = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    worst =
        std::max(worst, std::abs(heat.temperature(VertexId(v)) - body - 5 - 3 * std::cos(k * mesh.positions[v].x())));
  return worst / 3;
}

TEST(TissueHeat, CosineInASlabDecaysAsFouriersSeriesSays) {
  EXPECT_LT(cosine_error(32, 1000), 2e-3);
}

TEST(TissueHeat, ConvergesWithSecondOrderInSpaceAndFirstInTime) {
  const double coarse = cosine_error(4, 20000), fine = cosine_error(8, 20000);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
  const double long_steps = cosine_error(64, 2), short_steps = cosine_error(64, 4);
  EXPECT_NEAR(std::log2(long_steps / short_steps), 1, 0.15);
}

TEST(TissueHeat, FluxIntoAHalfSpaceWarmsItAsTheComplementaryErrorFunctionSays) {
  // A step of temperature between two halves: ΔT/2 erfc(x / (2 √(α t))), while the ends stay out of reach.
  const int cells = 80;
  const double length = 0.04;
  const TetMesh mesh = test::box_mesh(cells, 1, 1, {length, length / cells, length / cells});
  TissueHeat heat(mesh, {{1, plain()}}, closed());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double x = mesh.positions[v].x() - length / 2;
    heat.set_temperature(VertexId(v), body + (std::abs(x) < 1e-9 ? 5 : x < 0 ? 10 : 0));
  }
  const double duration = 60, alpha = 0.5 / (1000 * 3600);
  for (int s = 0; s < 600; ++s) heat.step(duration / 600, {}, mesh, mesh.positions);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double x = mesh.positions[v].x() - length / 2;
    EXPECT_NEAR(heat.temperature(VertexId(v)) - body, 5 * std::erfc(x / (2 * std::sqrt(alpha * duration))), 0.03) << x;
  }
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, PerfusedTissueAtRestCoolsAwayFromTheSourceByTheLawOfPennes) {
  // Steady: θ'' = θ/δ², δ = √(k / (ω ρ c)); a source in the plane x = 0 gives exp(−x/δ), and takes k θ0/δ per area.
  const int cells = 40;
  const double length = 0.04, side = 0.001, perfusion = 6.4e-3;
  const TetMesh mesh = test::box_mesh(cells, 1, 1, {length, side, side}, test::CubeSplit::six);
  TissueHeat heat(mesh, {{1, plain(perfusion)}}, closed());
  const double delta = std::sqrt(0.5 / (perfusion * 1060 * 3617)), wanted = 5;
  HeatSource source;
  source.place = {0, side / 2, side / 2};
  source.radius = 1.05e-3;
  source.power = 0.5 * wanted / delta * side * side;
  source.efficiency = 1;
  for (int s = 0; s < 300; ++s) heat.step(20, {&source, 1}, mesh, mesh.positions);
  const auto at = [&](int i) { return heat.temperature(VertexId(i)) - body; };
  for (int i = 5; i < 20; ++i)  // far from the source, whose own width shows only near it
    EXPECT_NEAR(at(i + 5) / at(i), std::exp(-5 * length / cells / delta), 2e-3) << i;
  const HeatLedger& l = heat.ledger();
  EXPECT_NEAR(l.supplied, 300 * 20 * source.power, 1e-9 * l.supplied);
  EXPECT_LT(balance_error(heat), 1e-12);
  EXPECT_GT(l.perfused, 0.9 * l.supplied);
}

TEST(TissueHeat, SurfaceLosesHeatByNewtonsLaw) {
  const TetMesh mesh = test::box_mesh(2, 2, 2, {1e-3, 1e-3, 1e-3});
  HeatOptions options = closed();
  options.surface_exchange = 20;
  TissueProperties even = plain();
  even.conductivity = 500;  // so that it cools as one
  TissueHeat heat(mesh, {{1, even}}, options);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) heat.set_temperature(VertexId(v), body + 4);
  for (int s = 0; s < 1000; ++s) heat.step(0.01, {}, mesh, mesh.positions);
  const double rate = 20 * 6e-6 / (1000 * 3600 * 1e-9);
  EXPECT_NEAR(heat.temperature(VertexId(13)) - body, 4 * std::exp(-rate * 10), 2e-3);
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, KeepsItsBooksThroughBurningBoilingAndCooling) {
  const TetMesh mesh = test::biliary_mesh(2);
  TissueHeat heat(mesh, tissue_properties(mesh));
  HeatSource source;
  source.place = mesh.positions[100];
  source.radius = 4e-3;
  source.power = 40;
  source.cutting = 0.5;
  std::size_t boiled = 0;
  for (int s = 0; s < 400; ++s) {
    const HeatStep& now = heat.step(0.016, {&source, s < 200 ? 1u : 0u}, mesh, mesh.positions);
    EXPECT_EQ(now.delivered, s < 200 ? 20 : 0);
    EXPECT_LT(now.residual, 1e-11);
    boiled = std::max(boiled, now.vaporised.size());
  }
  EXPECT_GT(boiled, 0u);
  EXPECT_NEAR(heat.ledger().supplied, 200 * 0.016 * 20, 1e-9);
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, WaterHoldsTheBoilingPointUntilItIsGone) {
  const TetMesh mesh = test::box_mesh(1, 1, 1, {2e-3, 2e-3, 2e-3});
  const TissueProperties tissue = plain();
  TissueHeat heat(mesh, {{1, tissue}}, closed());
  HeatSource source;
  source.place = {1e-3, 1e-3, 1e-3};
  source.radius = 0.1;  // even heating
  source.power = 10;
  source.efficiency = 1;
  const double mass = 1000 * 8e-9;
  const double to_boil = mass * 3600 * 63 / 10, to_dry = to_boil + mass * tissue.latent_heat / 10;
  double first_dry = 0, last_dry = 0;
  for (int s = 1; first_dry == 0 || last_dry == 0; ++s) {
    ASSERT_LT(s, 5000);
    const HeatStep& now = heat.step(0.005, {&source, 1}, mesh, mesh.positions);
    const double time = s * 0.005;
    EXPECT_TRUE(!now.vaporised.empty() || now.hottest < 100.0 + 1e-6) << time;
    EXPECT_TRUE(time < 1.2 * to_boil || now.hottest > 99.9) << time;
    if (first_dry == 0 && !now.vaporised.empty()) first_dry = time;
    if (last_dry == 0 && now.vaporised.size() == mesh.tet_count()) last_dry = time;
  }
  EXPECT_LE(first_dry, to_dry + 0.005);
  EXPECT_GE(last_dry, to_dry - 0.005);
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, AScrapTakesWhatDriesItAndTheRestIsNotDelivered) {
  // The whole power of a generator on a scrap that a hundredth of a second could boil away many times over.
  const TetMesh mesh = test::box_mesh(2, 1, 1, {0.4e-3, 0.2e-3, 0.2e-3});
  const TissueProperties tissue = plain();
  for (const double cutting : {0.0, 0.5, 1.0}) {
    TissueHeat heat(mesh, {{1, tissue}}, closed());
    HeatSource source;
    source.place = {0.05e-3, 0.1e-3, 0.05e-3};
    source.radius = 1e-3;
    source.power = 200;
    source.efficiency = 1;
    source.cutting = cutting;
    const double needed = 1000 * 16e-12 * (tissue.latent_heat + 3600 * 63);
    double delivered = 0;
    std::size_t vaporised = 0;
    for (int s = 0; s < 10; ++s) {  // nobody removes what is dry
      const HeatStep& now = heat.step(0.01, {&source, 1}, mesh, mesh.positions);
      delivered += 0.01 * now.delivered;
      vaporised = now.vaporised.size();
      EXPECT_LE(now.hottest, 100 + 1e-9) << cutting << ", step " << s;
      EXPECT_LT(balance_error(heat), 1e-12);
    }
    EXPECT_EQ(vaporised, mesh.tet_count());
    EXPECT_NEAR(delivered, needed, 1e-9 * needed);
    EXPECT_NEAR(heat.ledger().supplied, needed, 1e-9 * needed);
  }
}

TEST(TissueHeat, AHotCornerBoilsItsTetsBeforeItsHeatHasWarmedTheirOtherCorners) {
  const TetMesh mesh = test::box_mesh(1, 1, 1, {2e-3, 2e-3, 2e-3});
  const TissueProperties tissue = plain();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    TissueHeat heat(mesh, {{1, tissue}}, closed());
    // Dries the tets around, of which it is a quarter of the capacity, but for half of what warms their other corners.
    heat.set_temperature(VertexId(v), body + 4 * tissue.latent_heat / 3600 + 2.5 * 63);
    const HeatStep& now = heat.step(1e-6, {}, mesh, mesh.positions);
    EXPECT_LE(now.hottest, 100 + 1e-9);
    EXPECT_TRUE(now.vaporised.empty());
    EXPECT_LT(balance_error(heat), 1e-12);
  }
}

TEST(TissueHeat, CuttingCurrentBoilsTheNearestTetFirst) {
  const TetMesh mesh = test::box_mesh(8, 8, 8, {0.02, 0.02, 0.02});
  const TissueProperties tissue = plain();
  TissueHeat heat(mesh, {{1, tissue}});
  HeatSource source;
  source.place = {0.0101, 0.0102, 0.0199};
  source.radius = 2e-3;
  source.power = 30;
  source.efficiency = 0.5;
  source.cutting = 1;
  const double volume = 0.02 * 0.02 * 0.02 / static_cast<double>(mesh.tet_count());
  const double needed = 1000 * volume * (tissue.latent_heat + 3600 * 63);
  int steps = 0;
  while (heat.step(0.01, {&source, 1}, mesh, mesh.positions).vaporised.empty()) ASSERT_LT(++steps, 1000);
  EXPECT_NEAR((steps + 1) * 0.01, needed / 15, 0.0101);
}

TEST(TissueHeat, CoagulatesByArrheniusLawAndCountsTheDose) {
  const TetMesh mesh = test::box_mesh(1, 1, 1, {1e-2, 1e-2, 1e-2});
  TissueHeat heat(mesh, {{1, plain()}}, closed());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) heat.set_temperature(VertexId(v), 55);
  std::vector<TetId> stiffened;
  for (int s = 0; s < 1000; ++s) {
    const HeatStep& now = heat.step(0.02, {}, mesh, mesh.positions);
    stiffened.insert(stiffened.end(), now.stiffened.begin(), now.stiffened.end());
  }
  const double omega = 20 * 7.39e39 * std::exp(-2.577e5 / (8.314462618 * 328.15));
  EXPECT_NEAR(heat.coagulation()[0], 1 - std::exp(-omega), 1e-6);
  EXPECT_NEAR(heat.thermal_dose()[0], 20.0 / 60 * std::pow(2.0, 12), 1e-6 * 4096);
  EXPECT_NEAR(heat.peak_temperatures()[0], 55, 1e-9);
  const double level = std::round(4 * heat.coagulation()[0]);
  EXPECT_GE(level, 1);
  EXPECT_EQ(heat.stiffness_factor(TetId(0)), 1 + 2 * level / 4);
  EXPECT_EQ(stiffened.size(), mesh.tet_count() * static_cast<std::size_t>(level));  // rare: once a level
}

TEST(TissueHeat, BodyTemperatureHarmsNothingAndCostsNothing) {
  const TetMesh mesh = test::biliary_mesh(1);
  TissueHeat heat(mesh, tissue_properties(mesh));
  std::string before, after;
  heat.append_state(before);
  for (int s = 0; s < 100; ++s) {
    const HeatStep& now = heat.step(1, {}, mesh, mesh.positions);
    EXPECT_EQ(now.active_tets, 0u);
    EXPECT_EQ(now.iterations, 0);
  }
  for (const double c : heat.coagulation()) EXPECT_EQ(c, 0);
  HeatSource away;
  away.place = {1, 1, 1};
  EXPECT_EQ(heat.step(0.01, {&away, 1}, mesh, mesh.positions).delivered, 0);
}

TEST(TissueHeat, OnlyTheHotPartIsAtWorkAndTheAnswerIsTheSame) {
  const TetMesh mesh = test::biliary_mesh(2);
  TissueHeat lazy(mesh, tissue_properties(mesh)), eager(mesh, tissue_properties(mesh), [] {
    HeatOptions all;
    all.threshold = 1e-300;
    return all;
  }());
  HeatSource source;
  source.place = mesh.positions[500];
  source.radius = 2e-3;
  std::size_t most = 0;
  for (int s = 0; s < 300; ++s) {
    most = std::max(most, lazy.step(0.016, {&source, s < 150 ? 1u : 0u}, mesh, mesh.positions).active_tets);
    eager.step(0.016, {&source, s < 150 ? 1u : 0u}, mesh, mesh.positions);
  }
  EXPECT_LT(most, mesh.tet_count() / 5);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_NEAR(lazy.temperature(VertexId(v)), eager.temperature(VertexId(v)), 0.02);
}

TissueHeat burnt_bar(const TetMesh& mesh) {
  TissueHeat heat(mesh, {{1, plain(1e-3)}, {2, plain(1e-3)}});
  HeatSource source;
  source.place = {0.05, 0.01, 0.02};
  source.radius = 8e-3;
  source.power = 50;
  for (int s = 0; s < 300; ++s) heat.step(0.016, {&source, 1}, mesh, mesh.positions);
  return heat;
}

TEST(TissueHeat, RemovedTetsTakeTheirEnergyWithThem) {
  TetMesh mesh = test::bar_mesh(20);
  TissueHeat heat = burnt_bar(mesh);
  const double before = heat.stored();
  TopologyEdit edit;
  edit.removed = test::tets_where(mesh, [](const Vec3& x) { return x.x() > 0.048 && x.z() > 0.01; });
  const Remap remap = apply(mesh, edit);
  heat.follow(remap, mesh, vertex_tets(mesh));
  EXPECT_GT(heat.ledger().removed, 0.05 * before);
  EXPECT_NEAR(heat.stored() + heat.ledger().removed, before, 1e-12 * before);
  EXPECT_LT(std::abs(heat.ledger().reshaped), 1e-11 * before);
  for (int s = 0; s < 100; ++s) heat.step(0.016, {}, mesh, mesh.positions);
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, SplittingATetConservesEnergyAndMovingAVertexIsBooked) {
  TetMesh mesh = test::bar_mesh(20);
  TissueHeat heat = burnt_bar(mesh);
  const double before = heat.stored();
  // Every tet around an edge is split in the middle of it.
  const Tet first =
      mesh.tets[test::tets_where(mesh, [](const Vec3& x) { return x.x() > 0.05 && x.z() > 0.015; })[0].index()];
  const VertexId a = first[0], b = first[1], middle(mesh.vertex_count());
  TopologyEdit edit;
  edit.vertices.push_back({0.7 * mesh.position(a) + 0.3 * mesh.position(b), a, b, 0.3});
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::count(tet.begin(), tet.end(), a) + std::count(tet.begin(), tet.end(), b) != 2) continue;
    edit.removed.emplace_back(t);
    for (const VertexId end : {a, b}) {
      Tet piece = tet;
      std::replace(piece.begin(), piece.end(), end, middle);
      edit.tets.push_back({piece, TetId(t)});
    }
  }
  Remap remap = apply(mesh, edit);
  heat.follow(remap, mesh, vertex_tets(mesh));
  EXPECT_NEAR(heat.stored(), before, 1e-12 * before);
  EXPECT_EQ(heat.ledger().removed, 0);
  EXPECT_NEAR(heat.ledger().reshaped, 0, 1e-12 * before);

  TopologyEdit move;  // two vertices of the middle slide a little towards each other
  move.moved.push_back({a, b, 0.1, 0.9 * mesh.position(a) + 0.1 * mesh.position(b)});
  remap = Remap();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    remap.vertex_to_new.emplace_back(v);
    remap.vertex_to_old.emplace_back(v);
  }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    remap.tet_to_new.emplace_back(t);
    remap.tet_to_old.emplace_back(t);
  }
  remap.moved = move.moved;
  remap.touched = {a};
  mesh.positions[a.index()] = move.moved[0].position;
  heat.follow(remap, mesh, vertex_tets(mesh));
  for (int s = 0; s < 100; ++s) heat.step(0.016, {}, mesh, mesh.positions);
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, ATetThatAMovedVertexShrinksIsNoDrierThanBefore) {
  TetMesh mesh = test::box_mesh(1, 1, 1, {2e-3, 2e-3, 2e-3});
  TissueHeat heat(mesh, {{1, plain()}}, closed());
  HeatSource source;
  source.place = {1e-3, 1e-3, 1e-3};
  source.radius = 0.1;  // even heating
  source.efficiency = 1;
  source.power = 0.7 * 1000 * 8e-9 * (plain().latent_heat + 3600 * 63);  // 70 % of what dries the cube in 1 s
  for (int s = 0; s < 100; ++s) EXPECT_TRUE(heat.step(0.01, {&source, 1}, mesh, mesh.positions).vaporised.empty());
  const TopologyEdit move{
      .removed = {},
      .vertices = {},
      .tets = {},
      .moved = {{VertexId(0), VertexId(1), 0.6, 0.4 * mesh.positions[0] + 0.6 * mesh.positions[1]}}};
  const Remap remap = apply(mesh, move);
  ASSERT_FALSE(remap.reshaped.empty());
  heat.follow(remap, mesh, vertex_tets(mesh));
  EXPECT_LT(heat.ledger().reshaped, 0);
  for (int s = 0; s < 100; ++s) EXPECT_TRUE(heat.step(0.01, {}, mesh, mesh.positions).vaporised.empty());
  EXPECT_LT(balance_error(heat), 1e-12);
}

TEST(TissueHeat, FlatTetsCoolNothingBelowBlood) {
  // Flattened boxes, whose tets conduct from cold to hot across their obtuse edges.
  TetMesh mesh = test::box_mesh(6, 6, 3, {6e-3, 6e-3, 3e-3});
  for (Vec3& x : mesh.positions) x = {x.x() + 2.5 * x.z(), x.y() + 1.5 * x.x(), 0.3 * x.z()};
  TissueHeat heat(mesh, {{1, plain(1e-3)}});
  for (std::size_t v = 0; v < mesh.vertex_count(); v += 17) heat.set_temperature(VertexId(v), 95);
  for (int s = 0; s < 200; ++s) {
    heat.step(0.016, {}, mesh, mesh.positions);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) ASSERT_GE(heat.temperature(VertexId(v)), body - 1e-9) << s;
    ASSERT_LT(balance_error(heat), 1e-12);
  }
  // Where something is colder than blood from the start, it warms up.
  heat.set_temperature(VertexId(40), 20);
  for (int s = 0; s < 200; ++s) {
    heat.step(0.016, {}, mesh, mesh.positions);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) ASSERT_GE(heat.temperature(VertexId(v)), 20 - 1e-9) << s;
  }
  EXPECT_GT(heat.temperature(VertexId(40)), 21);
}

TEST(TissueHeat, CopiesGoTheSameWay) {
  const TetMesh mesh = test::bar_mesh(20);
  TissueHeat one = burnt_bar(mesh), two = one;
  for (int s = 0; s < 70; ++s) {
    one.step(0.016, {}, mesh, mesh.positions);
    two.step(0.016, {}, mesh, mesh.positions);
  }
  std::string a, b;
  one.append_state(a);
  two.append_state(b);
  EXPECT_EQ(a, b);
  two.step(0.016, {}, mesh, mesh.positions);
  b.clear();
  two.append_state(b);
  EXPECT_NE(a, b);
}

TEST(TissueHeat, ListsTetsInOrderHoweverLongItLasts) {
  const TetMesh mesh = test::box_mesh(12, 6, 4, {0.024, 0.012, 0.008});
  TissueHeat heat(mesh, {{1, plain()}});
  HeatSource source{{0.020, 0.010, 0.008}, 2e-3, 12, 0.5, 0.2};
  std::size_t stiffened = 0, vaporised = 0;
  for (int s = 0; s < 600; ++s) {
    source.power = s % 100 < 60 ? 12 : 0;  // cools in between, so that what is active changes
    const HeatStep& step = heat.step(1.0 / 60, {&source, 1}, mesh, mesh.positions);
    EXPECT_TRUE(std::is_sorted(step.stiffened.begin(), step.stiffened.end())) << s;
    EXPECT_TRUE(std::is_sorted(step.vaporised.begin(), step.vaporised.end())) << s;
    stiffened += step.stiffened.size();
    vaporised += step.vaporised.size();
  }
  EXPECT_GT(stiffened, 20U);
  EXPECT_GT(vaporised, 20U);
}

TEST(TissueHeat, RefusesBadFigures) {
  const TetMesh mesh = test::bar_mesh(4);
  EXPECT_THROW(TissueHeat(mesh, {{1, plain()}}), InputError);
  TissueHeat heat(mesh, {{1, plain()}, {2, plain()}});
  EXPECT_THROW(heat.step(0, {}, mesh, mesh.positions), InputError);
  HeatSource source;
  source.efficiency = 1.1;
  EXPECT_THROW(heat.step(0.1, {&source, 1}, mesh, mesh.positions), InputError);
  source = {};
  source.place.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(heat.step(0.1, {&source, 1}, mesh, mesh.positions), InputError);
}

}  // namespace
}  // namespace calot
