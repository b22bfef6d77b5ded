#include "calot/sim/tissue_properties.h"

#include <cmath>
#include <set>
#include <string>

#include "calot/base/error.h"

namespace calot {
namespace {

constexpr double ml = 1e-6;  // [m³]
constexpr double minute = 60;
constexpr double square_centimetre = 1e-4;
constexpr double water_latent_heat = 2.257e6;  // [J/kg] at 100 °C

TissueProperties liver() {
  TissueProperties p;
  p.ultimate_stretch = 1.35;
  p.conductivity = 0.512;
  p.perfusion = 6.4e-3;
  p.electrical_conductivity = 0.15;
  p.latent_heat = 0.72 * water_latent_heat;
  p.bruising_pressure = 80e3;
  p.bleeding_pressure = 200e3;
  p.injury_rate = 5 * ml / minute / square_centimetre;
  p.vessel = VesselKind::parenchyma;
  p.ooze_rate = 3 * ml / minute / square_centimetre;
  return p;
}

TissueProperties fat() {
  TissueProperties p;
  p.ultimate_stretch = 1.8;
  p.friction = 0.08;
  p.conductivity = 0.21;
  p.specific_heat = 2350;
  p.density = 920;
  p.perfusion = 5e-4;
  p.electrical_conductivity = 0.03;
  p.latent_heat = 0.2 * water_latent_heat;
  p.coagulated_stiffening = 1.5;
  p.arrhenius = {4.43e16, 1.3e5};
  p.bleeding_pressure = 300e3;
  p.ooze_rate = 0.2 * ml / minute / square_centimetre;
  return p;
}

TissueProperties bed() {
  TissueProperties p;
  p.ultimate_stretch = 1.6;
  p.density = 1000;
  p.ooze_rate = 0.5 * ml / minute / square_centimetre;
  return p;
}

void fill_with_bile(TissueProperties& p, double inner, double outer, double pressure) {
  p.inner_radius = inner;
  p.outer_radius = outer;
  p.pressure = pressure;
  p.viscosity = 1.5e-3;
  p.fluid_density = 1010;
}

TissueProperties gallbladder(VesselKind kind) {
  TissueProperties p;
  p.ultimate_stretch = 1.6;
  p.bruising_pressure = 120e3;
  p.bleeding_pressure = 300e3;
  p.electrical_conductivity = 0.9;
  p.ooze_rate = 0.3 * ml / minute / square_centimetre;
  p.vessel = kind;
  fill_with_bile(p, 15e-3, 17e-3, 980);
  p.max_flow = 100 * ml;
  if (kind == VesselKind::gallbladder) {  // mostly bile
    p.density = 1020;
    p.conductivity = 0.57;
    p.specific_heat = 3900;
    p.perfusion = 3e-4;
    p.latent_heat = 0.9 * water_latent_heat;
  }
  return p;
}

TissueProperties tube_wall() {
  TissueProperties p;
  p.ultimate_stretch = 1.7;
  p.conductivity = 0.46;
  p.perfusion = 2e-3;
  p.electrical_conductivity = 0.3;
  p.bruising_pressure = 150e3;
  p.bleeding_pressure = 400e3;
  return p;
}

TissueProperties duct(double inner, double outer) {
  TissueProperties p = tube_wall();
  p.vessel = VesselKind::bile_duct;
  p.ooze_rate = 0.3 * ml / minute / square_centimetre;
  fill_with_bile(p, inner, outer, 980);
  p.max_flow = 100 * ml;
  return p;
}

TissueProperties artery(double inner, double outer, double max_flow) {
  TissueProperties p = tube_wall();
  p.ultimate_stretch = 1.6;
  p.vessel = VesselKind::artery;
  p.inner_radius = inner;
  p.outer_radius = outer;
  p.pressure = 93 * 133.322;  // mean arterial pressure, 93 mmHg
  p.max_flow = max_flow;
  return p;
}

}  // namespace

TissueProperties tissue_properties(std::string_view name) {
  if (name == "liver") return liver();
  if (name == "gallbladder") return gallbladder(VesselKind::gallbladder);
  if (name == "gallbladder wall") return gallbladder(VesselKind::gallbladder_wall);
  if (name == "cystic duct") return duct(0.9e-3, 1.4e-3);
  if (name == "aberrant right hepatic duct") return duct(1.0e-3, 1.5e-3);
  if (name == "common bile duct" || name == "common hepatic duct") return duct(2.2e-3, 3e-3);
  if (name == "cystic artery" || name == "second cystic artery") return artery(0.5e-3, 0.7e-3, 60 * ml / minute);
  if (name == "right hepatic artery") return artery(1.5e-3, 2.0e-3, 300 * ml / minute);
  if (name == "hepatocystic fat") return fat();
  if (name == "gallbladder bed") return bed();
  TissueProperties other;
  other.ooze_rate = 0.5 * ml / minute / square_centimetre;
  return other;
}

std::map<std::int32_t, TissueProperties> tissue_properties(const TetMesh& mesh) {
  std::map<std::int32_t, TissueProperties> all;
  const std::set<std::int32_t> present(mesh.regions.begin(), mesh.regions.end());
  for (const std::int32_t region : present) {
    const auto name = mesh.region_names.find(region);
    all[region] = tissue_properties(name == mesh.region_names.end() ? std::string_view() : name->second);
  }
  return all;
}

namespace {

void require(bool good, std::string_view region, const char* figure, const char* range) {
  if (!good)
    throw InputError("tissue \"" + std::string(region) + "\"", std::string(figure) + " is out of range", range);
}

bool positive(double x) {
  return std::isfinite(x) && x > 0;
}
bool not_negative(double x) {
  return std::isfinite(x) && x >= 0;
}

}  // namespace

void check(const TissueProperties& p, std::string_view name) {
  require(std::isfinite(p.ultimate_stretch) && p.ultimate_stretch > 1, name, "ultimate_stretch", "give one above 1");
  require(not_negative(p.friction), name, "friction", "give 0 or more");
  require(positive(p.conductivity), name, "conductivity", "give W/(m K) above 0");
  require(positive(p.specific_heat), name, "specific_heat", "give J/(kg K) above 0");
  require(positive(p.density), name, "density", "give kg/m3 above 0");
  require(not_negative(p.perfusion), name, "perfusion", "give 1/s, 0 or more");
  require(positive(p.electrical_conductivity), name, "electrical_conductivity", "give S/m above 0");
  require(std::isfinite(p.vaporisation_temperature) && p.vaporisation_temperature > 45, name,
          "vaporisation_temperature", "give degrees Celsius above 45");
  require(positive(p.latent_heat), name, "latent_heat", "give J/kg above 0");
  require(std::isfinite(p.coagulated_stiffening) && p.coagulated_stiffening >= 1, name, "coagulated_stiffening",
          "give 1 or more");
  require(positive(p.arrhenius.frequency) && positive(p.arrhenius.activation_energy), name, "arrhenius",
          "give 1/s and J/mol above 0");
  require(positive(p.blanching_pressure) && positive(p.bruising_pressure) && positive(p.bleeding_pressure), name,
          "a pressure of injury", "give Pa above 0");
  require(positive(p.bleeding_speed), name, "bleeding_speed", "give m/s above 0");
  require(not_negative(p.injury_rate) && not_negative(p.ooze_rate), name, "a bleeding rate", "give m/s, 0 or more");
  require(positive(p.clotting_time), name, "clotting_time", "give s above 0");
  const bool lumen = p.vessel != VesselKind::none && p.vessel != VesselKind::parenchyma;
  require(!lumen || (positive(p.inner_radius) && positive(p.outer_radius) && p.outer_radius >= p.inner_radius), name,
          "inner_radius or outer_radius", "give 0 < inner <= outer, in metres");
  require(!lumen || (positive(p.pressure) && positive(p.max_flow)), name, "pressure or max_flow",
          "give Pa and m3/s above 0");
  require(positive(p.viscosity) && positive(p.fluid_density), name, "viscosity or fluid_density",
          "give Pa s and kg/m3 above 0");
}

}  // namespace calot
