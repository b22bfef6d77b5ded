#include "calot/sim/fluids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calot/base/error.h"
#include "calot/sim/tear_faces.h"

namespace calot {
namespace {

constexpr std::size_t arteries = 0, gallbladder = 1, biliary_tree = 2;
constexpr double injury_reach = 3e-3;  // [m]
constexpr double infinite = std::numeric_limits<double>::infinity();

void check(const FluidOptions& o) {
  const auto in = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!in(o.gallbladder_volume, 0, 1e-3) || !in(o.biliary_tree_volume, 1e-9, 1e-3) || !in(o.bile_secretion, 0, 1e-6) ||
      !in(o.discharge, 0.01, 1) || !in(o.sealing_coagulation, 0.01, 1) || !in(o.largest_sealed_radius, 0, 1))
    throw InputError("fluids", "an option is out of range",
                     "give volumes of at most 1 L in m3, a discharge and a sealing coagulation in 0.01 ... 1");
}

/// Q from Δp = R Q + k Q², k = ρ / (2 (C_d A)²).
double through_opening(double pressure, double resistance, double area, double density, double discharge) {
  if (!(area > 0) || !std::isfinite(resistance) || !(pressure > 0)) return 0;
  const double k = density / (2 * discharge * discharge * area * area);
  return 2 * pressure / (resistance + std::sqrt(resistance * resistance + 4 * k * pressure));
}

}  // namespace

Fluids::Fluids(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
               std::span<const VertexId> supplies, const FluidOptions& options)
    : options_(options), tets_(mesh.tets) {
  check(options);
  for (const auto& [region, tissue] : properties) {
    const auto name = mesh.region_names.find(region);
    calot::check(tissue, name == mesh.region_names.end() ? std::to_string(region) : name->second);
    kind_of_region_[region] = static_cast<std::uint8_t>(kinds_.size());
    kinds_.push_back(tissue);
  }
  const VertexTets around = vertex_tets(mesh);
  neighbours_.resize(mesh.tet_count());
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const auto kind = kind_of_region_.find(mesh.regions[t]);
    if (kind == kind_of_region_.end())
      throw InputError("fluids", "region " + std::to_string(mesh.regions[t]) + " has no properties",
                       "give every region of the mesh its tissue");
    kind_.push_back(kind->second);
    for (std::size_t f = 0; f < 4; ++f) neighbours_[t][f] = detail::across(mesh, around, TetId(t), f);
  }
  supply_.assign(mesh.vertex_count(), 0);
  for (const VertexId v : supplies) {
    if (v.index() >= supply_.size())
      throw InputError("fluids", "supply vertex " + std::to_string(v.value) + " doesn't exist",
                       "give vertices of the mesh");
    supply_[v.index()] = 1;
  }
  totals_.gallbladder_left = options.gallbladder_volume;
  totals_.biliary_tree_left = options.biliary_tree_volume;
}

const TissueProperties& Fluids::tissue_of(std::int32_t region) const {
  return kinds_[kind_of_region_.at(region)];
}

std::size_t Fluids::index_of(std::uint32_t id) const {
  const auto found = std::lower_bound(sources_.begin(), sources_.end(), id,
                                      [](const FluidSource& s, std::uint32_t wanted) { return s.id < wanted; });
  return static_cast<std::size_t>(found - sources_.begin());
}

/// Resistance of the open ways from each supply to each tet; only where there is an open vessel to be fed.
void Fluids::find_ways(const TetMesh& mesh, std::span<const std::uint8_t> closed) {
  if (ways_known_ && std::equal(closed.begin(), closed.end(), closed_.begin(), closed_.end())) return;
  if (std::none_of(open_.begin(), open_.end(), [](const OpenFace& face) { return face.lumen; })) return;
  if (!ways_known_) graph_.build(mesh, neighbours_, kind_, kinds_);
  closed_.assign(closed.begin(), closed.end());
  ways_known_ = true;
  std::array<std::vector<std::uint8_t>, 3> seeds;
  for (auto& seed : seeds) seed.assign(mesh.tet_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const VesselKind vessel = tissue(TetId(t)).vessel;
    const bool fed = std::any_of(tets_[t].begin(), tets_[t].end(), [&](VertexId v) { return supply_[v.index()] != 0; });
    seeds[arteries][t] = vessel == VesselKind::artery && fed;
    seeds[gallbladder][t] = vessel == VesselKind::gallbladder || vessel == VesselKind::gallbladder_wall;
    seeds[biliary_tree][t] = vessel == VesselKind::bile_duct && fed;
  }
  for (std::size_t k = 0; k < 3; ++k) graph_.resistances(seeds[k], closed, resistance_[k]);
}

/// How much of an opening heat has left open. It doesn't shut a wide lumen.
double Fluids::open_share(const TissueProperties& tissue, bool lumen, double coagulated) const {
  if (lumen && tissue.inner_radius > options_.largest_sealed_radius) return 1;
  return std::max(0.0, 1 - coagulated / options_.sealing_coagulation);
}

void Fluids::survey(double dt, const TetMesh& mesh, std::span<const double> coagulation) {
  ways_.assign(sources_.size(), {{infinite, infinite, infinite}, {}, 0});
  for (FluidSource& source : sources_) source.open_area = source.rate = 0;
  for (OpenFace& open : open_) {
    const std::size_t s = index_of(open.source);
    double coagulated = 0;
    for (const VertexId v : detail::face_of(mesh.tet(open.tet), open.face)) coagulated += coagulation[v.index()] / 3;
    const TissueProperties& here = tissue(open.tet);
    const double area = open.area * open_share(here, open.lumen, coagulated);
    sources_[s].open_area += area;
    open.age += dt;
    if (!open.lumen) ways_[s].ooze += area * here.ooze_rate * std::exp(-open.age / here.clotting_time);
    if (!open.lumen || area == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      ways_[s].resistance[k] = std::min(ways_[s].resistance[k], resistance_[k][open.tet.index()]);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    FluidSource& source = sources_[s];
    if (source.kind != FluidSourceKind::injury || source.ended) continue;
    const TissueProperties& here = tissue_of(source.region);
    double coagulated = 0;
    for (int k = 0; k < 3; ++k)
      coagulated += source.place.weights[k] * coagulation[source.place.vertices[static_cast<std::size_t>(k)].index()];
    injury_rate_[s] *= std::exp(-dt / here.clotting_time);
    ways_[s].ooze = injury_rate_[s] * open_share(here, false, coagulated);
  }
}

/// What the supplies would give one source, each for itself.
void Fluids::flow(FluidSource& source, Ways& ways) const {
  if (source.kind != FluidSourceKind::vessel) return;
  const TissueProperties& here = tissue_of(source.region);
  const double calibre = here.inner_radius / here.outer_radius;
  const double lumen =
      std::min(source.open_area * calibre * calibre, std::numbers::pi * here.inner_radius * here.inner_radius);
  const auto full = [](double left, double at_start) { return at_start > 0 ? left / at_start : 0; };
  const std::array<double, 3> filling{1, full(totals_.gallbladder_left, options_.gallbladder_volume),
                                      full(totals_.biliary_tree_left, options_.biliary_tree_volume)};
  const std::size_t first = source.fluid == Fluid::blood ? arteries : gallbladder;
  const std::size_t last = source.fluid == Fluid::blood ? arteries : biliary_tree;
  source.fed = false;
  for (std::size_t k = first; k <= last; ++k) {
    source.fed = source.fed || std::isfinite(ways.resistance[k]);
    ways.drawn[k] =
        through_opening(here.pressure * filling[k], ways.resistance[k], lumen, here.fluid_density, options_.discharge);
  }
}

/// No supply gives more than it can: arteries their region's flow, the others what they hold.
void Fluids::share_supplies(double dt) {
  std::map<std::int32_t, double> wanted;
  std::array<double, 3> drawn{};
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    wanted[sources_[s].region] += ways_[s].drawn[arteries];
    for (std::size_t k = 0; k < 3; ++k) drawn[k] += ways_[s].drawn[k];
  }
  totals_.biliary_tree_left += options_.bile_secretion * dt;
  const auto share = [&](double left, double flow) { return flow * dt > left ? left / (flow * dt) : 1; };
  const double of_gallbladder = share(totals_.gallbladder_left, drawn[gallbladder]),
               of_tree = share(totals_.biliary_tree_left, drawn[biliary_tree]);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    FluidSource& source = sources_[s];
    Ways& ways = ways_[s];
    const double most = tissue_of(source.region).max_flow, all = wanted[source.region];
    if (all > most) ways.drawn[arteries] *= most / all;
    ways.drawn[gallbladder] *= of_gallbladder;
    ways.drawn[biliary_tree] *= of_tree;
    source.rate = ways.ooze + ways.drawn[arteries] + ways.drawn[gallbladder] + ways.drawn[biliary_tree];
  }
  totals_.gallbladder_left = std::max(0.0, totals_.gallbladder_left - drawn[gallbladder] * of_gallbladder * dt);
  totals_.biliary_tree_left = std::clamp(totals_.biliary_tree_left - drawn[biliary_tree] * of_tree * dt, 0.0,
                                         options_.biliary_tree_volume);  // the rest goes its usual way, to the gut
}

void Fluids::shed(double dt, std::span<const Vec3> positions) {
  totals_.blood_rate = totals_.bile_rate = 0;
  for (FluidSource& source : sources_) {
    if (source.ended) continue;
    const auto& [vertices, weights, tet] = source.place;
    source.position = weights[0] * positions[vertices[0].index()] + weights[1] * positions[vertices[1].index()] +
                      weights[2] * positions[vertices[2].index()];
    source.shed += source.rate * dt;
    source.pooled += source.rate * dt;
    (source.fluid == Fluid::blood ? totals_.blood_rate : totals_.bile_rate) += source.rate;
    (source.fluid == Fluid::blood ? totals_.blood_lost : totals_.bile_spilled) += source.rate * dt;
  }
}

void Fluids::step(double dt, const TetMesh& mesh, std::span<const Vec3> positions, std::span<const double> coagulation,
                  std::span<const std::uint8_t> closed) {
  if (!(dt > 0) || !std::isfinite(dt)) throw InputError("fluids", "the time step is not above 0", "give seconds");
  if (positions.size() != supply_.size() || coagulation.size() != supply_.size() ||
      (!closed.empty() && closed.size() != tets_.size()))
    throw InputError("fluids", "positions, coagulation or clips are not of this mesh", "let fluids follow each edit");
  find_ways(mesh, closed);
  survey(dt, mesh, coagulation);
  for (std::size_t s = 0; s < sources_.size(); ++s)
    if (!sources_[s].ended) flow(sources_[s], ways_[s]);
  share_supplies(dt);
  shed(dt, positions);
}

void Fluids::injure(const BleedingOnset& onset, const TetMesh& mesh) {
  if (!(onset.rate >= 0) || !std::isfinite(onset.rate) || kind_of_region_.count(onset.region) == 0)
    throw InputError("fluids", "an injury's rate or region is out of range", "give m3/s and a region of the mesh");
  const auto at_rest = [&](const SurfacePoint& point) {
    Vec3 x = Vec3::Zero();
    for (int k = 0; k < 3; ++k) x += point.weights[k] * mesh.position(point.vertices[static_cast<std::size_t>(k)]);
    return x;
  };
  const Vec3 here = at_rest(onset.point);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const FluidSource& source = sources_[s];
    if (source.kind != FluidSourceKind::injury || source.ended || source.region != onset.region) continue;
    if ((at_rest(source.place) - here).norm() > injury_reach) continue;
    injury_rate_[s] += onset.rate;
    return;
  }
  FluidSource source;
  source.id = sources_.empty() ? 0 : sources_.back().id + 1;
  source.kind = FluidSourceKind::injury;
  source.region = onset.region;
  source.place = onset.point;
  source.position = here;
  source.fed = true;
  sources_.push_back(source);
  injury_rate_.push_back(onset.rate);
}

double Fluids::suck(const Vec3& tip, double radius, double flow, double dt) {
  if (!tip.allFinite() || !(radius >= 0) || !(flow >= 0) || !(dt >= 0) || !std::isfinite(flow * dt))
    throw InputError("fluids", "suction is out of range", "give metres, m3/s and seconds, not negative");
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const double distance = (sources_[s].position - tip).norm();
    if (sources_[s].pooled > 0 && distance <= radius) near.emplace_back(distance, s);
  }
  std::sort(near.begin(), near.end());
  double room = flow * dt;
  for (const auto& [distance, s] : near) {
    const double taken = std::min(room, sources_[s].pooled);
    sources_[s].pooled -= taken;
    room -= taken;
  }
  totals_.sucked += flow * dt - room;
  return flow * dt - room;
}

}  // namespace calot
