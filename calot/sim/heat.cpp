#include "calot/sim/heat.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/fem/element.h"
#include "calot/sim/heat_source.h"
#include "calot/sim/tear_faces.h"

namespace calot {
namespace {

constexpr double blood_heat = 1060.0 * 3617.0;  // of blood, per volume [J/(m³ K)]
constexpr double gas_constant = 8.314462618;    // [J/(mol K)]
constexpr double kelvin = 273.15;               // 0 °C
constexpr double dose_reference = 43;           // [°C]
constexpr double dose_from = 39;                // below it the dose stays under 0.4 % of that at 43 °C
constexpr std::uint64_t settle_every = 64;      // steps between looks at what has cooled down
constexpr double tolerance = 1e-12;             // of the linear system
constexpr int iteration_limit = 500;
constexpr std::array<std::array<std::size_t, 2>, 6> edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

void check(const HeatOptions& o) {
  const auto good = [](double x) { return std::isfinite(x); };
  if (!good(o.body_temperature) || !(o.surface_exchange >= 0) || !good(o.surface_exchange) || !(o.threshold > 0) ||
      !good(o.damage_from) || o.stiffness_levels < 1 || o.stiffness_levels > 100)
    throw InputError("heat", "an option is out of range",
                     "give finite temperatures, exchange >= 0, threshold > 0 and 1 ... 100 levels");
}

void check(double dt, std::span<const HeatSource> sources) {
  if (!(dt > 0) || !std::isfinite(dt)) throw InputError("heat", "the time step is not above 0", "give seconds");
  const auto share = [](double x) { return x >= 0 && x <= 1; };
  for (const HeatSource& s : sources)
    if (!s.place.allFinite() || !(s.radius > 0) || !std::isfinite(s.radius) || !(s.power >= 0) ||
        !std::isfinite(s.power) || !share(s.efficiency) || !share(s.cutting))
      throw InputError("heat source", "a figure is out of range",
                       "give a place and radius in metres, power in W, efficiency and cutting in 0 ... 1");
}

}  // namespace

TissueHeat::TissueHeat(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
                       const HeatOptions& options)
    : options_(options), around_(vertex_tets(mesh)) {
  check(options);
  for (const auto& [region, tissue] : properties) {
    const auto name = mesh.region_names.find(region);
    calot::check(tissue, name == mesh.region_names.end() ? std::to_string(region) : name->second);
    kind_of_region_[region] = static_cast<std::uint8_t>(kinds_.size());
    kinds_.push_back(tissue);
  }
  const std::size_t n = mesh.vertex_count(), m = mesh.tet_count();
  for (std::size_t t = 0; t < m; ++t) {
    if (kind_of_region_.count(mesh.regions[t]) == 0)
      throw InputError("heat", "region " + std::to_string(mesh.regions[t]) + " has no properties",
                       "give every region of the mesh its tissue");
    elements_.push_back(element(mesh, TetId(t)));
  }
  for (std::size_t t = 0; t < m; ++t) measure_surface(mesh, TetId(t));
  sum_vertices(mesh);
  excess_.assign(n, 0);
  peak_.assign(n, options.body_temperature);
  dose_.assign(n, 0);
  damage_.assign(n, 0);
  coagulated_.assign(n, 0);
  charred_.assign(n, 0);
  hot_.assign(n, 0);
  dried_.assign(m, 0);
  level_.assign(m, 0);
  tet_is_active_.assign(m, 0);
  vertex_is_active_.assign(n, 0);
  harmed_.assign(n, 0);
  for (auto* field : {&heating_, &solution_, &residual_, &direction_, &product_, &diagonal_, &inverse_})
    field->assign(n, 0);
}

TissueHeat::Element TissueHeat::element(const TetMesh& mesh, TetId tet) const {
  const Tet& c = mesh.tet(tet);
  const TetShape shape = tet_shape(mesh.position(c[0]), mesh.position(c[1]), mesh.position(c[2]), mesh.position(c[3]));
  Element e;
  e.kind = kind_of_region_.at(mesh.regions[tet.index()]);
  e.volume = shape.volume;
  e.surface = {};
  const double factor = -kinds_[e.kind].conductivity * shape.volume;
  for (std::size_t k = 0; k < 6; ++k)
    e.exchange[k] = factor * shape.gradient[edges[k][0]].dot(shape.gradient[edges[k][1]]);
  return e;
}

void TissueHeat::measure_surface(const TetMesh& mesh, TetId tet) {
  Element& e = elements_[tet.index()];
  e.surface = {};
  if (options_.surface_exchange == 0) return;
  for (std::size_t f = 0; f < 4; ++f) {
    if (detail::across(mesh, around_, tet, f).valid()) continue;
    const auto face = detail::face_of(mesh.tet(tet), f);
    const Vec3 &a = mesh.position(face[0]), &b = mesh.position(face[1]), &c = mesh.position(face[2]);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    for (const std::size_t corner : detail::tet_face_corners[f]) e.surface[corner] += area / 3;
  }
}

void TissueHeat::sum_vertices(const TetMesh& mesh) {
  vertices_.assign(mesh.vertex_count(), {});
  std::vector<double> largest(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Element& e = elements_[t];
    const TissueProperties& tissue = kinds_[e.kind];
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t v = mesh.tets[t][c].index();
      Vertex& vertex = vertices_[v];
      vertex.capacity += tissue.density * tissue.specific_heat * e.volume / 4;
      vertex.perfusion += tissue.perfusion * blood_heat * e.volume / 4;
      vertex.exchange += options_.surface_exchange * e.surface[c];
      const double boiling = tissue.vaporisation_temperature - options_.body_temperature;
      vertex.boiling = largest[v] == 0 ? boiling : std::min(vertex.boiling, boiling);
      if (e.volume <= largest[v]) continue;
      largest[v] = e.volume;
      vertex.kind = e.kind;
    }
  }
}

/// What it takes to dry a tet out, beyond what has gone into it [J]: its water boils once all of it is hot enough.
double TissueHeat::dry_energy(TetId tet, const Tet& corners) const {
  const Element& e = elements_[tet.index()];
  const TissueProperties& tissue = kinds_[e.kind];
  const double boiling = tissue.vaporisation_temperature - options_.body_temperature;
  double to_heat = 0;  // a corner that is too hot has yet to warm the others
  for (const VertexId v : corners) to_heat += std::max(0.0, boiling - heated_to(v.index())) / 4;
  return tissue.density * e.volume * (tissue.latent_heat + tissue.specific_heat * to_heat) - dried_[tet.index()];
}

double TissueHeat::corner_energy(TetId tet, const Tet& corners) const {
  const Element& e = elements_[tet.index()];
  double sum = 0;
  for (const VertexId v : corners) sum += excess_[v.index()];
  return kinds_[e.kind].density * kinds_[e.kind].specific_heat * e.volume / 4 * sum;
}

double TissueHeat::stored() const {
  double sum = 0;
  for (std::size_t v = 0; v < excess_.size(); ++v) sum += vertices_[v].capacity * excess_[v];
  for (const double energy : dried_) sum += energy;
  return sum;
}

double TissueHeat::stiffness_factor(TetId tet) const {
  const double most = kinds_[elements_[tet.index()].kind].coagulated_stiffening;
  return 1 + (most - 1) * level_[tet.index()] / options_.stiffness_levels;
}

void TissueHeat::set_temperature(VertexId v, double celsius) {
  if (v.index() >= excess_.size() || !std::isfinite(celsius))
    throw InputError("heat", "no such vertex or temperature", "give a vertex of the mesh and degrees Celsius");
  double& excess = excess_[v.index()];
  const double now = celsius - options_.body_temperature;
  ledger_.supplied += vertices_[v.index()].capacity * (now - excess);
  excess = now;
  peak_[v.index()] = std::max(peak_[v.index()], celsius);
  hot_[v.index()] = 2;  // its tets start to conduct in the next step
}

void TissueHeat::place_sources(double dt, std::span<const HeatSource> sources, const TetMesh& mesh,
                               std::span<const Vec3> positions) {
  if (sources.empty()) return;
  conductance_.resize(elements_.size());
  for (std::size_t t = 0; t < elements_.size(); ++t) {  // dry tissue hardly conducts current
    const TissueProperties& tissue = kinds_[elements_[t].kind];
    const double dryness = dried_[t] / (tissue.density * elements_[t].volume * tissue.latent_heat);
    conductance_[t] = tissue.electrical_conductivity * std::max(1e-3, 1 - dryness);
  }
  for (const HeatSource& source : sources) {
    detail::heated_tets(mesh, positions, source.place, source.radius, conductance_, heated_);
    const double energy = source.power * source.efficiency * dt;
    if (heated_.empty() || energy == 0) continue;
    const double left = cut_into(mesh, source.cutting * energy + warm(mesh, (1 - source.cutting) * energy));
    report_.delivered += source.power * source.efficiency - left / dt;
    ledger_.supplied += energy - left;
  }
}

/// Warms the touched tets' corners as far as the boiling point, and dries the tets with the rest of their shares.
/// @return the energy that tets have left because they are dry [J]
double TissueHeat::warm(const TetMesh& mesh, double energy) {
  for (detail::HeatedTet& heated : heated_) {
    heated.rest = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const VertexId v = mesh.tet(heated.tet)[c];
      const Vertex& vertex = vertices_[v.index()];
      const double part = energy * heated.share[c];
      const double warmth = std::clamp(vertex.capacity * (vertex.boiling - heated_to(v.index())), 0.0, part);
      heating_[v.index()] += warmth;
      heated.rest += part - warmth;
      activate(mesh, v);
    }
  }
  double left = 0;
  for (const detail::HeatedTet& heated : heated_) {
    const double part = std::clamp(dry_energy(heated.tet, mesh.tet(heated.tet)), 0.0, heated.rest);
    dried_[heated.tet.index()] += part;
    left += heated.rest - part;
  }
  return left;
}

/// Boils the touched tets one after another, the nearest first. @return the energy that none of them could take [J]:
/// through dry tissue no current passes
double TissueHeat::cut_into(const TetMesh& mesh, double energy) {
  if (energy <= 0) return 0;
  std::sort(heated_.begin(), heated_.end(), [](const detail::HeatedTet& a, const detail::HeatedTet& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.tet < b.tet;
  });
  for (const detail::HeatedTet& heated : heated_) {
    const double part = std::clamp(dry_energy(heated.tet, mesh.tet(heated.tet)), 0.0, energy);
    dried_[heated.tet.index()] += part;
    energy -= part;
    if (energy <= 0) break;
  }
  return energy;
}

void TissueHeat::activate(const TetMesh& mesh, VertexId v) {
  if (hot_[v.index()] == 1) return;
  hot_[v.index()] = 1;
  for (std::uint32_t k = around_.start[v.index()]; k < around_.start[v.index() + 1]; ++k) {
    const TetId tet = around_.tets[k];
    if (tet_is_active_[tet.index()] != 0) continue;
    tet_is_active_[tet.index()] = 1;
    active_tets_.push_back(tet.value);
    for (const VertexId corner : mesh.tet(tet)) {
      if (vertex_is_active_[corner.index()] != 0) continue;
      vertex_is_active_[corner.index()] = 1;
      active_vertices_.push_back(corner.value);
    }
  }
}

/// Lets tets rest that have cooled down; they keep what little heat they have.
void TissueHeat::settle_active(const TetMesh& mesh) {
  for (const std::uint32_t t : active_tets_) tet_is_active_[t] = 0;
  for (const std::uint32_t v : active_vertices_) vertex_is_active_[v] = 0;
  active_tets_.clear();
  std::vector<std::uint32_t> before;
  before.swap(active_vertices_);
  for (const std::uint32_t v : before) hot_[v] = 0;
  for (const std::uint32_t v : before)
    if (std::abs(excess_[v]) > 0.5 * options_.threshold) activate(mesh, VertexId(v));
  std::sort(active_tets_.begin(), active_tets_.end());
  std::sort(active_vertices_.begin(), active_vertices_.end());
}

/// y = (C/dt + P + H + L) x on the active vertices.
void TissueHeat::multiply(const TetMesh& mesh, double dt, const std::vector<double>& x, std::vector<double>& y) const {
  for (const std::uint32_t v : active_vertices_) y[v] = (vertices_[v].capacity / dt + diagonal_[v]) * x[v];
  for (const std::uint32_t t : active_tets_) {
    const Tet& c = mesh.tets[t];
    const auto& w = elements_[t].exchange;
    const std::array<double, 4> at{x[c[0].index()], x[c[1].index()], x[c[2].index()], x[c[3].index()]};
    for (std::size_t k = 0; k < 6; ++k) {
      const double flow = w[k] * (at[edges[k][0]] - at[edges[k][1]]);
      y[c[edges[k][0]].index()] += flow;
      y[c[edges[k][1]].index()] -= flow;
    }
  }
}

/// What leaves each active vertex by itself, and the inverse of the system's diagonal.
void TissueHeat::prepare(const TetMesh& mesh, double dt) {
  for (const std::uint32_t v : active_vertices_) {  // perfusion ends where tissue is coagulated
    diagonal_[v] = vertices_[v].perfusion * (1 - coagulated_[v]) + vertices_[v].exchange;
    inverse_[v] = vertices_[v].capacity / dt + diagonal_[v];
  }
  for (const std::uint32_t t : active_tets_)
    for (std::size_t k = 0; k < 6; ++k)
      for (const std::size_t end : edges[k]) inverse_[mesh.tets[t][end].index()] += elements_[t].exchange[k];
  for (const std::uint32_t v : active_vertices_) inverse_[v] = 1 / inverse_[v];
}

/// Conjugate gradients with the diagonal as preconditioner, from the state before.
void TissueHeat::solve(const TetMesh& mesh, double dt) {
  std::vector<double>&x = solution_, &r = residual_, &p = direction_, &q = product_;
  const auto over = [&](const auto& body) {
    for (const std::uint32_t v : active_vertices_) body(v);
  };
  multiply(mesh, dt, excess_, q);
  double scale = 0, rho = 0;
  over([&](std::uint32_t v) {
    const double right = (vertices_[v].capacity * excess_[v] + heating_[v]) / dt;
    r[v] = right - q[v];
    p[v] = inverse_[v] * r[v];
    x[v] = excess_[v];
    rho += r[v] * p[v];
    scale += right * inverse_[v] * right;
  });
  const double goal = tolerance * tolerance * scale;
  for (report_.iterations = 0; rho > goal && report_.iterations < iteration_limit; ++report_.iterations) {
    multiply(mesh, dt, p, q);
    double curvature = 0;
    over([&](std::uint32_t v) { curvature += p[v] * q[v]; });
    const double alpha = rho / curvature;
    double next = 0;
    over([&](std::uint32_t v) {
      x[v] += alpha * p[v];
      r[v] -= alpha * q[v];
      next += r[v] * inverse_[v] * r[v];
    });
    const double beta = next / rho;
    rho = next;
    over([&](std::uint32_t v) { p[v] = inverse_[v] * r[v] + beta * p[v]; });
  }
  report_.residual = scale > 0 ? std::sqrt(rho / scale) : 0;
}

/// Advances the state with the flows at the solution, so that energy is kept to rounding whatever the solver leaves.
void TissueHeat::conduct(const TetMesh& mesh, double dt) {
  prepare(mesh, dt);
  solve(mesh, dt);
  multiply(mesh, dt, solution_, product_);
  for (const std::uint32_t v : active_vertices_) {
    const Vertex& vertex = vertices_[v];
    const double now = solution_[v];
    const double perfused = vertex.perfusion * (1 - coagulated_[v]) * now * dt, exchanged = vertex.exchange * now * dt;
    const double flow = product_[v] - (vertex.capacity / dt + diagonal_[v]) * now;
    ledger_.perfused += perfused;
    ledger_.exchanged += exchanged;
    excess_[v] += (heating_[v] - dt * flow - perfused - exchanged) / vertex.capacity;
  }
}

/// Flat tets conduct a little heat from cold to hot. A vertex that this leaves colder than anything was before, blood
/// included, gets what it lacks back from its neighbours, each giving by what it has to give.
void TissueHeat::warm_undercooled(const TetMesh& mesh, double coldest) {
  for (const std::uint32_t v : active_vertices_) {
    const double lack = vertices_[v].capacity * (coldest - excess_[v]);
    if (lack <= 0) continue;
    neighbours_.clear();
    for (std::uint32_t k = around_.start[v]; k < around_.start[v + 1]; ++k)
      for (const VertexId w : mesh.tet(around_.tets[k]))
        if (excess_[w.index()] > coldest) neighbours_.push_back(w.value);
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
    double there = 0;
    for (const std::uint32_t w : neighbours_) there += vertices_[w].capacity * (excess_[w] - coldest);
    if (there <= 0) continue;
    const double share = std::min(1.0, lack / there);
    for (const std::uint32_t w : neighbours_) excess_[w] -= share * (excess_[w] - coldest);
    excess_[v] += share * there / vertices_[v].capacity;
  }
}

/// Heat above the boiling point dries the tets around; only where these are dry does the temperature rise further.
void TissueHeat::boil(const TetMesh& mesh) {
  for (const std::uint32_t v : active_vertices_) {
    const double over = vertices_[v].capacity * (excess_[v] - vertices_[v].boiling);
    if (over <= 0) continue;
    const std::span<const TetId> tets(around_.tets.data() + around_.start[v], around_.start[v + 1] - around_.start[v]);
    double room = 0;
    for (const TetId t : tets) room += std::max(0.0, dry_energy(t, mesh.tet(t)));
    if (room <= 0) continue;
    const double taken = std::min(over, room);
    for (const TetId t : tets) dried_[t.index()] += taken / room * std::max(0.0, dry_energy(t, mesh.tet(t)));
    excess_[v] -= taken / vertices_[v].capacity;
  }
}

/// What the heat does to the tissue: peak, dose, coagulation, stiffness, charring.
void TissueHeat::harm(const TetMesh& mesh, double dt) {
  for (const std::uint32_t v : active_vertices_) {
    const double celsius = options_.body_temperature + excess_[v];
    peak_[v] = std::max(peak_[v], celsius);
    report_.hottest = std::max(report_.hottest, celsius);
    if (celsius > dose_from) {
      const double above = celsius - dose_reference;  // R is 0.5 above it, 0.25 below
      dose_[v] += dt / 60 * std::exp2(above >= 0 ? above : 2 * above);
    }
    harmed_[v] = celsius > options_.damage_from && coagulated_[v] < 1;
    if (harmed_[v] == 0) continue;
    const Arrhenius& rate = kinds_[vertices_[v].kind].arrhenius;
    damage_[v] += dt * rate.frequency * std::exp(-rate.activation_energy / (gas_constant * (celsius + kelvin)));
    coagulated_[v] = -std::expm1(-damage_[v]);
  }
  for (const std::uint32_t t : active_tets_) {
    const Tet& c = mesh.tets[t];
    if (dried_[t] > 0) {
      const TissueProperties& tissue = kinds_[elements_[t].kind];
      const double latent = tissue.density * elements_[t].volume * tissue.latent_heat;
      for (const VertexId v : c) charred_[v.index()] = std::max(charred_[v.index()], std::min(1.0, dried_[t] / latent));
      if (dry_energy(TetId(t), c) <= 1e-9 * latent) report_.vaporised.emplace_back(t);
    }
    double coagulated = 0;
    bool changed = false;
    for (const VertexId v : c) {
      coagulated += coagulated_[v.index()] / 4;
      changed = changed || harmed_[v.index()] != 0;
    }
    if (!changed) continue;
    const auto level = static_cast<std::uint8_t>(std::lround(coagulated * options_.stiffness_levels));
    if (level <= level_[t]) continue;
    level_[t] = level;
    report_.stiffened.emplace_back(t);
  }
}

const HeatStep& TissueHeat::step(double dt, std::span<const HeatSource> sources, const TetMesh& mesh,
                                 std::span<const Vec3> positions) {
  check(dt, sources);
  report_.delivered = report_.residual = 0;
  report_.hottest = options_.body_temperature;
  report_.iterations = 0;
  report_.stiffened.clear();
  report_.vaporised.clear();
  ++steps_;
  const std::size_t active_before = active_tets_.size();
  place_sources(dt, sources, mesh, positions);
  for (std::size_t v = 0; v < hot_.size(); ++v)
    if (hot_[v] == 2) activate(mesh, VertexId(v));
  if (active_tets_.size() != active_before) {
    std::sort(active_tets_.begin(), active_tets_.end());
    std::sort(active_vertices_.begin(), active_vertices_.end());
  }
  report_.active_tets = active_tets_.size();
  if (active_tets_.empty()) return report_;
  double coldest = 0;
  for (const std::uint32_t v : active_vertices_) coldest = std::min(coldest, excess_[v]);
  conduct(mesh, dt);
  warm_undercooled(mesh, coldest);
  for (const std::uint32_t v : active_vertices_) heating_[v] = 0;
  boil(mesh);
  harm(mesh, dt);
  for (const std::uint32_t v : active_vertices_)
    if (hot_[v] == 0 && std::abs(excess_[v]) > options_.threshold) hot_[v] = 2;
  if (steps_ % settle_every == 0) settle_active(mesh);
  return report_;
}

}  // namespace calot
