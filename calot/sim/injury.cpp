#include "calot/sim/injury.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/sim/tear_faces.h"
#include "calot/sim/tissue_state.h"

namespace calot {
namespace {

constexpr double least_onset = 0.02;  // smaller growth of a break waits until it adds up

bool positive(double x) {
  return std::isfinite(x) && x > 0;
}

void check(const InjuryContact& contact, const TetMesh& mesh) {
  bool good = contact.point.tet.index() < mesh.tet_count() && contact.point.weights.allFinite() &&
              contact.point.weights.minCoeff() >= -1e-9 && contact.point.weights.maxCoeff() > 0;
  for (const VertexId v : contact.point.vertices) good = good && v.index() < mesh.vertex_count();
  if (!good) throw InputError("injury", "a contact is not on this mesh", "give contacts of the mesh as it is now");
  if (!(std::isfinite(contact.force) && contact.force >= 0 && positive(contact.area) && std::isfinite(contact.speed) &&
        contact.speed >= 0 && std::isfinite(contact.angle)))
    throw InputError("injury", "a contact's force, area, speed or angle is out of range",
                     "give N, m2, m/s and rad, finite and not negative");
}

}  // namespace

Injury::Injury(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
               const InjuryOptions& options)
    : options_(options), tissues_(properties) {
  if (!positive(options.blanching_time) || !positive(options.refill_time) || !positive(options.bruising_time) ||
      !(options.edge_factor >= 1) || !std::isfinite(options.edge_factor) ||
      !(options.slicing >= 0 && options.slicing <= 1))
    throw InputError("injury", "an option is out of range", "give times above 0, edge_factor >= 1, slicing in 0 ... 1");
  for (const auto& [region, tissue] : properties) {
    const auto name = mesh.region_names.find(region);
    calot::check(tissue, name == mesh.region_names.end() ? std::to_string(region) : name->second);
  }
  for (const std::int32_t region : mesh.regions)
    if (tissues_.count(region) == 0)
      throw InputError("injury", "region " + std::to_string(region) + " has no properties",
                       "give every region of the mesh its tissue");
  for (auto* field : {&blanched_, &bruised_, &broken_, &wanted_}) field->assign(mesh.vertex_count(), 0);
}

void Injury::press(double dt, const InjuryContact& contact, const TissueProperties& tissue, std::int32_t region) {
  const double stress = contact.force / contact.area, pressure = stress * (contact.edge ? options_.edge_factor : 1);
  report_.highest_pressure = std::max(report_.highest_pressure, stress);
  const double into = std::max(0.0, contact.speed * std::cos(contact.angle)),
               along = contact.speed * std::abs(std::sin(contact.angle));
  const double impact = contact.force == 0 ? 0
                        : contact.edge     ? options_.edge_factor * std::hypot(into, options_.slicing * along)
                                           : into;
  const double by_pressure = pressure / tissue.bleeding_pressure, by_impact = impact / tissue.bleeding_speed;
  const double breaks = std::clamp(std::max(by_pressure, by_impact) - 1, 0.0, 1.0);
  const double bruise = dt / options_.bruising_time * std::max(0.0, pressure / tissue.bruising_pressure - 1);
  const double blanch = std::min(1.0, pressure / tissue.blanching_pressure);
  Eigen::Index heaviest = 0;
  const double most = contact.point.weights.maxCoeff(&heaviest);
  const double before = broken_[contact.point.vertices[static_cast<std::size_t>(heaviest)].index()];
  const bool grows = breaks > before + least_onset;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t v = contact.point.vertices[k].index();
    const double share = std::max(0.0, contact.point.weights[static_cast<Eigen::Index>(k)]) / most;
    wanted_[v] = std::max(wanted_[v], share * blanch);
    bruised_[v] = std::min(1.0, bruised_[v] + share * bruise);
    if (grows) broken_[v] = std::max(broken_[v], share * breaks);
  }
  if (grows)
    report_.onsets.push_back(
        {contact.point, region, tissue.injury_rate * contact.area * (breaks - before), by_impact > by_pressure});
}

const InjuryStep& Injury::step(double dt, const TetMesh& mesh, std::span<const InjuryContact> contacts) {
  if (!positive(dt)) throw InputError("injury", "the time step is not above 0", "give seconds");
  for (const InjuryContact& contact : contacts) check(contact, mesh);
  report_.onsets.clear();
  report_.highest_pressure = 0;
  std::fill(wanted_.begin(), wanted_.end(), 0.0);
  for (const InjuryContact& contact : contacts) {
    const std::int32_t region = mesh.regions[contact.point.tet.index()];
    press(dt, contact, tissues_.at(region), region);
  }
  const double rise = -std::expm1(-dt / options_.blanching_time), fade = -std::expm1(-dt / options_.refill_time);
  for (std::size_t v = 0; v < blanched_.size(); ++v) {
    const double change = wanted_[v] - blanched_[v];
    blanched_[v] += change * (change > 0 ? rise : fade);
  }
  return report_;
}

void Injury::follow(const Remap& remap) {
  for (auto* field : {&blanched_, &bruised_, &broken_}) *field = carry_over(*field, remap);
  wanted_.assign(blanched_.size(), 0);
}

void Injury::append_state(std::string& bytes) const {
  for (const auto* field : {&blanched_, &bruised_, &broken_}) detail::append_bytes(bytes, *field);
}

}  // namespace calot
