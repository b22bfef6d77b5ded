#include "calot/sim/fluids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "calot/base/error.h"
#include "calot/cut/separate.h"
#include "calot/mesh/surface.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

constexpr double ml = 1e-6;

/// A tube along x, 40 mm long, 2 mm × 2 mm; optionally inside a jacket of fat. Fed at x = 0.
struct Tube {
  TetMesh mesh;
  std::map<std::int32_t, TissueProperties> tissues;
  std::vector<VertexId> supplies;
  Fluids fluids;
  std::vector<double> coagulation;
  std::vector<std::uint8_t> closed;
  explicit Tube(std::string_view tissue, bool jacket = false) {
    mesh = jacket ? test::cell_mesh(20, 4, 4, {0.04, 0.004, 0.004},
                                    [](int, int j, int k) { return j >= 1 && j < 3 && k >= 1 && k < 3 ? 1 : 2; })
                  : test::cell_mesh(20, 2, 2, {0.04, 0.002, 0.002}, [](int, int, int) { return 1; });
    tissues = {{1, tissue_properties(tissue)}, {2, tissue_properties("hepatocystic fat")}};
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.positions[v].x() < 1e-9) supplies.emplace_back(v);
    fluids = Fluids(mesh, tissues, supplies);
    coagulation.assign(mesh.vertex_count(), 0);
  }
  void step(double dt = 0.01) { fluids.step(dt, mesh, mesh.positions, coagulation, closed); }
  void edit(const TopologyEdit& edit) {
    const Remap remap = apply(mesh, edit);
    fluids.follow(remap, mesh, vertex_tets(mesh));
    coagulation.assign(mesh.vertex_count(), 0);
    closed.clear();
  }
  void remove(const std::function<bool(const Vec3&)>& where) {
    TopologyEdit e;
    e.removed = test::tets_where(mesh, where);
    edit(e);
  }
  /// Separates along the plane x = at, where y is below `depth`.
  void slit(double at, double depth) {
    std::vector<std::array<VertexId, 3>> faces;
    for (const Tet& tet : mesh.tets)
      for (std::size_t f = 0; f < 4; ++f) {
        std::array<VertexId, 3> face{};
        bool in = true;
        for (std::size_t c = 0, k = 0; c < 4; ++c)
          if (c != f) face[k++] = tet[c];
        for (const VertexId v : face)
          in = in && std::abs(mesh.position(v).x() - at) < 1e-9 && mesh.position(v).y() < depth + 1e-9;
        if (in) faces.push_back(face);
      }
    edit(separate(mesh, vertex_tets(mesh), faces));
  }
  void clip(double from, double to) {
    closed.assign(mesh.tet_count(), 0);
    for (const TetId t : test::tets_where(mesh, [&](const Vec3& x) { return x.x() > from && x.x() < to; }))
      closed[t.index()] = 1;
  }
  std::vector<FluidSource> open(FluidSourceKind kind) const {
    std::vector<FluidSource> all;
    for (const FluidSource& s : fluids.sources())
      if (s.kind == kind && !s.ended) all.push_back(s);
    return all;
  }
};

TEST(Fluids, AnUntouchedVesselShedsNothingAndAnUncoveredOneNeither) {
  Tube tube("cystic artery", true);
  tube.step();
  EXPECT_TRUE(tube.fluids.sources().empty());
  tube.remove([](const Vec3& x) { return x.z() > 0.003; });  // a strip of fat comes off the artery
  tube.step();
  EXPECT_TRUE(tube.open(FluidSourceKind::vessel).empty());
  const auto raw = tube.open(FluidSourceKind::ooze);
  ASSERT_EQ(raw.size(), 2u);  // fat at both sides of the artery
  for (const FluidSource& source : raw) EXPECT_EQ(source.region, 2);
  EXPECT_NEAR(raw[0].open_area + raw[1].open_area, 0.04 * 0.002, 1e-12);
  EXPECT_EQ(tube.fluids.totals().bile_spilled, 0);
}

TEST(Fluids, ACutArteryBleedsFromItsFedEndAsThePressureSays) {
  Tube tube("cystic artery");
  tube.remove([](const Vec3& x) { return x.x() > 0.02 && x.x() < 0.024; });
  tube.step();
  const auto ends = tube.open(FluidSourceKind::vessel);
  ASSERT_EQ(ends.size(), 2u);
  const FluidSource &fed = ends[0].fed ? ends[0] : ends[1], &cut_off = ends[0].fed ? ends[1] : ends[0];
  EXPECT_FALSE(cut_off.fed);
  EXPECT_EQ(cut_off.rate, 0);
  EXPECT_LT(fed.position.x(), cut_off.position.x());
  EXPECT_NEAR(fed.position.x(), 0.02, 1e-9);
  EXPECT_NEAR(fed.open_area, 4e-6, 1e-15);
  const TissueProperties artery = tissue_properties("cystic artery");
  const double lumen = std::numbers::pi * artery.inner_radius * artery.inner_radius;
  const double straight = 8 * artery.viscosity * 0.02 / (std::numbers::pi * std::pow(artery.inner_radius, 4));
  const double left = artery.pressure - 1060 / 2.0 * std::pow(fed.rate / (0.6 * lumen), 2);
  if (fed.rate < artery.max_flow * (1 - 1e-9)) {
    EXPECT_GT(left / fed.rate, 0.9 * straight);
    EXPECT_LT(left / fed.rate, 1.7 * straight);  // from tet to tet the way is longer
  } else {
    EXPECT_GT(left, straight * fed.rate);
  }
  EXPECT_GT(fed.rate, 0.2 * ml);
  EXPECT_NEAR(tube.fluids.totals().blood_lost, 0.01 * fed.rate, 1e-18);
}

TEST(Fluids, FlowThroughASlenderTubeIsHagenPoiseuilles) {
  Tube tube("cystic artery");
  TissueProperties& thin = tube.tissues[1];
  thin.inner_radius = 0.1e-3;
  thin.outer_radius = 0.12e-3;
  tube.fluids = Fluids(tube.mesh, tube.tissues, tube.supplies);
  const auto rate_at = [&](double from) {
    Tube cut = tube;
    cut.remove([&](const Vec3& x) { return x.x() > from && x.x() < from + 0.004; });
    cut.step();
    return cut.fluids.totals().blood_rate;
  };
  const double near = 1 / rate_at(0.008), middle = 1 / rate_at(0.016), far = 1 / rate_at(0.024);
  EXPECT_NEAR((far - middle) / (middle - near), 1, 0.02);  // 1/Q grows evenly with the length
  const double flow = thin.pressure * std::numbers::pi * 1e-16 / (8 * thin.viscosity * 0.016);
  EXPECT_LT(rate_at(0.016), flow * 1.1);
  EXPECT_GT(rate_at(0.016), flow / 1.8);
}

TEST(Fluids, AClipUpstreamStopsItAndOneDownstreamDoesNot) {
  Tube tube("cystic artery");
  tube.remove([](const Vec3& x) { return x.x() > 0.02 && x.x() < 0.024; });
  tube.step();
  const double open = tube.fluids.totals().blood_rate;
  EXPECT_GT(open, 0);
  tube.clip(0.03, 0.034);
  tube.step();
  EXPECT_EQ(tube.fluids.totals().blood_rate, open);
  tube.clip(0.01, 0.014);
  tube.step();
  EXPECT_EQ(tube.fluids.totals().blood_rate, 0);
  for (const FluidSource& source : tube.open(FluidSourceKind::vessel)) EXPECT_FALSE(source.fed);
  tube.closed.clear();  // the clip came off
  tube.step();
  EXPECT_EQ(tube.fluids.totals().blood_rate, open);
}

TEST(Fluids, ASlitBecomesTwoEndsAndTheFirstKeepsItsNumber) {
  Tube tube("cystic artery");
  tube.slit(0.02, 0.001);
  tube.step();
  auto open = tube.open(FluidSourceKind::vessel);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_TRUE(open[0].fed);
  EXPECT_NEAR(open[0].open_area, 2 * 2e-6, 1e-15);
  const double before = open[0].rate;
  tube.slit(0.02, 0.002);
  tube.step();
  open = tube.open(FluidSourceKind::vessel);
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0].id, 0u);
  EXPECT_EQ(open[0].fed + open[1].fed, 1);
  EXPECT_GT(before, 0);
  EXPECT_NEAR(open[0].open_area + open[1].open_area, 2 * 4e-6, 1e-15);
}

TEST(Fluids, HeatSealsASmallLumenAndNotAWideOne) {
  for (const bool wide : {false, true}) {
    Tube tube(wide ? "right hepatic artery" : "cystic artery");
    tube.remove([](const Vec3& x) { return x.x() > 0.02 && x.x() < 0.024; });
    tube.step();
    const double before = tube.fluids.totals().blood_rate;
    std::fill(tube.coagulation.begin(), tube.coagulation.end(), 0.4);
    tube.step();
    EXPECT_LE(tube.fluids.totals().blood_rate, before);
    std::fill(tube.coagulation.begin(), tube.coagulation.end(), 0.9);
    tube.step();
    EXPECT_EQ(tube.fluids.totals().blood_rate, wide ? before : 0) << wide;
  }
}

TEST(Fluids, AWideArteryGivesNoMoreThanItsSupplyBrings) {
  Tube tube("right hepatic artery");
  tube.tissues[1].outer_radius = tube.tissues[1].inner_radius;
  tube.fluids = Fluids(tube.mesh, tube.tissues, tube.supplies);
  tube.slit(0.02, 0.002);
  tube.slit(0.006, 0.001);
  tube.step();
  EXPECT_NEAR(tube.fluids.totals().blood_rate, tube.tissues[1].max_flow, 1e-12 * tube.tissues[1].max_flow);
}

TEST(Fluids, RawLiverOozesByItsAreaAndClots) {
  Tube tube("liver");
  tube.remove([](const Vec3& x) { return x.x() > 0.02; });
  tube.step(1);
  const auto raw = tube.open(FluidSourceKind::ooze);
  ASSERT_EQ(raw.size(), 1u);
  EXPECT_TRUE(tube.open(FluidSourceKind::vessel).empty());
  const TissueProperties liver = tissue_properties("liver");
  EXPECT_NEAR(raw[0].rate, 4e-6 * liver.ooze_rate * std::exp(-1 / liver.clotting_time), 1e-18);
  for (int s = 0; s < 999; ++s) tube.step(1);
  const double closed_form = 4e-6 * liver.ooze_rate * liver.clotting_time * (1 - std::exp(-1000 / liver.clotting_time));
  EXPECT_NEAR(tube.fluids.totals().blood_lost, closed_form, 5e-3 * closed_form);
  EXPECT_EQ(tube.fluids.sources()[0].shed, tube.fluids.totals().blood_lost);
}

TEST(Fluids, APerforatedGallbladderEmptiesByTorricellisLaw) {
  Tube tube("gallbladder");
  tube.slit(0.02, 0.001);
  const TissueProperties& sac = tube.tissues[1];
  const double calibre = sac.inner_radius / sac.outer_radius, hole = 4e-6 * calibre * calibre;
  const double v0 = 40 * ml, speed = 0.6 * hole * std::sqrt(2 * sac.pressure / (sac.fluid_density * v0));
  double time = 0;
  for (; time < 8; time += 0.01) tube.step();
  const double root = std::sqrt(v0) - speed * time / 2;
  ASSERT_GT(root, 0);
  EXPECT_NEAR(tube.fluids.totals().gallbladder_left, root * root, 2e-3 * v0);
  for (; time < 120; time += 0.02) tube.step(0.02);
  EXPECT_NEAR(tube.fluids.totals().bile_spilled, v0, 0.02 * v0);
  EXPECT_NEAR(tube.fluids.totals().bile_spilled + tube.fluids.totals().gallbladder_left, v0, 1e-9 * v0);
  EXPECT_GT(tube.fluids.totals().blood_lost, 0);  // its wall bleeds a little too
}

/// A gallbladder, its duct and the common duct; bile is fed at the common duct's upper end.
struct Biliary : Tube {
  Biliary() : Tube("cystic duct") {
    mesh = test::biliary_mesh(1);
    tissues = tissue_properties(mesh);
    supplies.clear();
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.positions[v].z() > 0.058) supplies.emplace_back(v);
    fluids = Fluids(mesh, tissues, supplies);
    coagulation.assign(mesh.vertex_count(), 0);
  }
};

TEST(Fluids, ACutDuctSpillsFromBothEndsUntilBothAreClipped) {
  Biliary tree;
  tree.remove([](const Vec3& x) { return x.x() > 0.017 && x.x() < 0.022 && std::abs(x.z() - 0.03) < 0.05; });
  for (int s = 0; s < 1000; ++s) tree.step();
  const auto ends = tree.open(FluidSourceKind::vessel);
  ASSERT_EQ(ends.size(), 2u);
  for (const FluidSource& end : ends) {
    EXPECT_TRUE(end.fed);
    EXPECT_GT(end.shed, 0.1 * ml);
  }
  const FluidTotals& totals = tree.fluids.totals();
  EXPECT_NEAR(totals.bile_spilled + totals.gallbladder_left + totals.biliary_tree_left, 45 * ml + 7e-9 * 10, 1e-15);
  tree.clip(0.011, 0.017);
  tree.step();
  int fed = 0;
  for (const FluidSource& end : tree.open(FluidSourceKind::vessel)) fed += end.fed;
  EXPECT_EQ(fed, 1);
  tree.clip(0.0, 0.03);
  tree.step();
  EXPECT_EQ(totals.bile_rate, 0);
}

TEST(Fluids, NumbersAndPlacesStayThroughOtherEdits) {
  Tube tube("cystic artery");
  tube.remove([](const Vec3& x) { return x.x() > 0.02 && x.x() < 0.024; });
  tube.step();
  const auto before = tube.fluids.sources();
  TopologyEdit edit;  // pieces at the far ends of both stumps
  edit.removed = test::tets_where(tube.mesh, [](const Vec3& x) { return x.x() < 0.0007 || x.x() > 0.0393; });
  tube.edit(edit);
  tube.step();
  const auto after = tube.fluids.sources();
  for (std::size_t s = 0; s < before.size(); ++s) {
    EXPECT_EQ(after[s].id, before[s].id);
    EXPECT_LT((after[s].position - before[s].position).norm(), 1e-12);
    EXPECT_GE(after[s].shed, before[s].shed);
    EXPECT_FALSE(after[s].ended);
  }
  tube.remove([](const Vec3& x) { return x.x() < 0.02; });  // the whole stump goes
  tube.step();
  EXPECT_EQ(std::count_if(before.begin(), before.end(),
                          [&](const FluidSource& s) { return tube.fluids.sources()[s.id].ended; }),
            1);
  EXPECT_GT(tube.fluids.totals().blood_lost, 0);
}

TEST(Fluids, InjuriesJoinMoveOnAndAreSuckedUp) {
  Tube tube("liver");
  BleedingOnset onset;
  const Tet corner = tube.mesh.tets[30];
  onset.point = {{corner[0], corner[1], corner[2]}, {0.6, 0.2, 0.2}, TetId(30)};
  onset.region = 1;
  onset.rate = 1e-8;
  tube.fluids.injure(onset, tube.mesh);
  tube.fluids.injure(onset, tube.mesh);
  ASSERT_EQ(tube.fluids.sources().size(), 1u);
  tube.step(1);
  const double clotting = tissue_properties("liver").clotting_time;
  EXPECT_NEAR(tube.fluids.sources()[0].rate, 2e-8 * std::exp(-1 / clotting), 1e-20);
  TopologyEdit edit;
  edit.removed = {TetId(30)};
  const Vec3 kept = tube.mesh.position(corner[0]);
  tube.edit(edit);
  tube.step(1);
  const FluidSource& source = tube.fluids.sources()[0];
  EXPECT_FALSE(source.ended);
  EXPECT_LT((source.position - kept).norm(), 1e-12);
  const double pooled = source.pooled;
  EXPECT_EQ(tube.fluids.suck(kept + Vec3(0, 0.02, 0), 0.01, 1e-6, 1), 0);
  EXPECT_NEAR(tube.fluids.suck(kept, 0.01, 1e-8, 1), 1e-8, 1e-20);
  EXPECT_NEAR(tube.fluids.sources()[0].pooled, pooled - 1e-8, 1e-20);
  EXPECT_GT(tube.fluids.totals().blood_lost, pooled * 0.99);
  std::fill(tube.coagulation.begin(), tube.coagulation.end(), 1.0);
  tube.step();
  EXPECT_EQ(tube.fluids.totals().blood_rate, 0);
}

/// Splits every tet around the edge between two vertices.
TopologyEdit split_edge(const TetMesh& mesh, VertexId a, VertexId b, double weight) {
  TopologyEdit edit;
  edit.vertices.push_back({(1 - weight) * mesh.position(a) + weight * mesh.position(b), a, b, weight});
  const VertexId middle(mesh.vertex_count());
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
  return edit;
}

TEST(Fluids, RawAreaIsAllTheBoundaryThatWasNotThereAtFirstAfterAnyEdits) {
  test::Random random(11);
  for (int round = 0; round < 12; ++round) {
    Tube tube("liver");
    for (int step = 0; step < 12; ++step) {
      const std::size_t kind = random.below(3);
      if (kind == 0) {
        TopologyEdit edit;
        edit.removed = test::random_tets(tube.mesh, 3, random.next());
        tube.edit(edit);
      } else if (kind == 1) {
        const Tet& tet = tube.mesh.tets[random.below(tube.mesh.tet_count())];
        tube.edit(split_edge(tube.mesh, tet[0], tet[1 + random.below(3)], random.between(0.2, 0.8)));
      } else {
        const double x = 0.002 * static_cast<double>(1 + random.below(19));
        tube.slit(x, random.unit() < 0.5 ? 0.001 : 0.002);
      }
      tube.step();
    }
    double expected = 0;
    const Surface surface = boundary_surface(tube.mesh);
    for (const Triangle& t : surface.triangles) {
      const Vec3 &a = surface.positions[t[0]], &b = surface.positions[t[1]], &c = surface.positions[t[2]];
      const auto on = [&](int axis, double at) {
        return std::max({std::abs(a[axis] - at), std::abs(b[axis] - at), std::abs(c[axis] - at)}) < 1e-9;
      };
      if (on(0, 0) || on(0, 0.04) || on(1, 0) || on(1, 0.002) || on(2, 0) || on(2, 0.002)) continue;
      expected += 0.5 * (b - a).cross(c - a).norm();
    }
    double raw = 0;
    for (const FluidSource& source : tube.open(FluidSourceKind::ooze)) raw += source.open_area;
    EXPECT_NEAR(raw, expected, 1e-9 * expected + 1e-15) << round;
    EXPECT_GT(expected, 0);
  }
}

TEST(Fluids, SuppliesAreTheFixedEndsOrTheFarOnes) {
  const TetMesh mesh = test::biliary_mesh(1);
  const auto tissues = tissue_properties(mesh);
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  auto free_end = supply_vertices(mesh, tissues, fixed);
  ASSERT_EQ(free_end.size(), 1u);
  EXPECT_TRUE(mesh.position(free_end[0]).z() < 0.002 || mesh.position(free_end[0]).z() > 0.058);
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = mesh.positions[v].z() > 0.058;
  const auto held = supply_vertices(mesh, tissues, fixed);
  EXPECT_EQ(held.size(), static_cast<std::size_t>(std::count(fixed.begin(), fixed.end(), 1)));
}

TEST(Fluids, CopiesGoTheSameWay) {
  Tube one("cystic artery");
  one.remove([](const Vec3& x) { return x.x() > 0.02 && x.x() < 0.024; });
  Tube two = one;
  for (Tube* tube : {&one, &two})
    for (int s = 0; s < 10; ++s) tube->step();
  std::string a, b;
  one.fluids.append_state(a);
  two.fluids.append_state(b);
  EXPECT_EQ(a, b);
  two.step();
  b.clear();
  two.fluids.append_state(b);
  EXPECT_NE(a, b);
}

TEST(Fluids, RefusesWhatIsNotOfThisMesh) {
  Tube tube("cystic artery");
  tube.coagulation.pop_back();
  EXPECT_THROW(tube.step(), InputError);
  tube.coagulation.push_back(0);
  EXPECT_THROW(tube.step(0), InputError);
  const std::vector<VertexId> nowhere{VertexId(1000000)};
  EXPECT_THROW(Fluids(tube.mesh, tube.tissues, nowhere), InputError);
  EXPECT_THROW(Fluids(tube.mesh, {}, {}), InputError);
  FluidOptions options;
  options.discharge = 0;
  EXPECT_THROW(Fluids(tube.mesh, tube.tissues, {}, options), InputError);
}

}  // namespace
}  // namespace calot
