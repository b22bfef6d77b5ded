// What a tissue is, besides elastic: how it tears, heats, bruises, bleeds and leaks.
#pragma once
#include <cstdint>
#include <map>
#include <string_view>

#include "calot/mesh/tet_mesh.h"

namespace calot {

enum class Fluid : std::uint8_t { blood, bile };

/// What flows in a tissue. The meshes have no lumen: a tube is solid, and stands for wall and lumen together.
enum class VesselKind : std::uint8_t {
  none,
  artery,            ///< a tube of blood under arterial pressure
  parenchyma,        ///< many small vessels: oozes wherever it is cut or torn
  bile_duct,         ///< a tube of bile
  gallbladder,       ///< a sac of bile under pressure, of finite volume
  gallbladder_wall,  ///< around it, where the wall is a region of its own: bile leaks only where it is cut through
};

/// Protein denaturation as a first-order reaction: dΩ/dt = A exp(−E_a / (R T)). Source: [Henriques1947].
struct Arrhenius {
  double frequency = 7.39e39;          ///< A [1/s]
  double activation_energy = 2.577e5;  ///< E_a [J/mol]
};

/// Figures of one region. Sources, and what is assumed: docs/simulation.md, "Tissue besides motion".
struct TissueProperties {
  // Strength
  double ultimate_stretch = 1.35;  ///< largest principal stretch that holds, > 1
  double friction = 0.1;           ///< Coulomb's coefficient against wet steel, ≥ 0
  // Heat
  double conductivity = 0.5;              ///< [W/(m K)]
  double specific_heat = 3600;            ///< [J/(kg K)]
  double density = 1060;                  ///< [kg/m³]
  double perfusion = 1e-3;                ///< blood that passes, volume per volume [1/s]
  double electrical_conductivity = 0.2;   ///< at 500 kHz [S/m]; shares cautery's power among neighbouring tissues
  double vaporisation_temperature = 100;  ///< [°C]
  double latent_heat = 0.7 * 2.257e6;     ///< to dry it: water content × water's heat of vaporisation [J/kg]
  double coagulated_stiffening = 3;       ///< stiffness when wholly coagulated, times the fresh one, ≥ 1
  Arrhenius arrhenius;
  // Injury by tools
  double blanching_pressure = 4.3e3;  ///< that empties the capillaries [Pa]
  double bruising_pressure = 100e3;   ///< above it tissue is bruised in time [Pa]
  double bleeding_pressure = 250e3;   ///< above it the surface breaks [Pa]
  double bleeding_speed = 0.5;        ///< of a head-on impact by a shaft, above it the surface breaks [m/s]
  double injury_rate = 5e-4;          ///< bleeding of a wholly broken surface, per area [m³/(s m²) = m/s]
  // Vessels
  VesselKind vessel = VesselKind::none;
  double ooze_rate = 0;         ///< bleeding of a fresh cut face, per area [m/s]
  double clotting_time = 180;   ///< time constant with which oozing and injuries stop by themselves [s]
  double inner_radius = 0;      ///< of the tube's lumen [m]
  double outer_radius = 0;      ///< of the tube [m]
  double pressure = 0;          ///< in the lumen above that of the abdomen, > 0 where there is a lumen [Pa]
  double max_flow = 0;          ///< what its supply can bring, all openings together [m³/s]
  double viscosity = 3.5e-3;    ///< of the fluid [Pa s]
  double fluid_density = 1060;  ///< of the fluid [kg/m³]
};

/// Defaults by region name, the names of docs/patient.md ("liver", "gallbladder", "cystic duct" …); any other name gets
/// those of a soft tissue in general.
TissueProperties tissue_properties(std::string_view region_name);

/// The defaults for every region that a mesh carries, by number.
std::map<std::int32_t, TissueProperties> tissue_properties(const TetMesh& mesh);

/// Throws InputError naming the region and the figure that is out of range.
void check(const TissueProperties& properties, std::string_view region_name);

/// What flows in a lumen of this kind; parenchyma and plain tissue bleed.
constexpr Fluid fluid_of(VesselKind kind) {
  return kind == VesselKind::bile_duct || kind == VesselKind::gallbladder || kind == VesselKind::gallbladder_wall
             ? Fluid::bile
             : Fluid::blood;
}

}  // namespace calot
