#include "calot/scene/region_figures.h"

#include <array>

namespace calot::detail {
namespace {

using P = TissueProperties;
using M = Material;

constexpr std::array figures{
    RegionFigure{"young", 1, 1e10, "Pa", &M::young, nullptr},
    RegionFigure{"poisson", 0, 0.499, "", &M::poisson, nullptr},
    RegionFigure{"density", 1, 1e5, "kg/m3", &M::density, &P::density},
    RegionFigure{"friction", 0, 10, "", nullptr, &P::friction},
    RegionFigure{"ultimate_stretch", 1.001, 100, "", nullptr, &P::ultimate_stretch},
    RegionFigure{"conductivity", 0, 1e3, "W/(m K)", nullptr, &P::conductivity},
    RegionFigure{"specific_heat", 1, 1e5, "J/(kg K)", nullptr, &P::specific_heat},
    RegionFigure{"perfusion", 0, 10, "1/s", nullptr, &P::perfusion},
    RegionFigure{"electrical_conductivity", 0, 100, "S/m", nullptr, &P::electrical_conductivity},
    RegionFigure{"vaporisation_temperature", 40, 1000, "degrees Celsius", nullptr, &P::vaporisation_temperature},
    RegionFigure{"latent_heat", 1, 1e8, "J/kg", nullptr, &P::latent_heat},
    RegionFigure{"coagulated_stiffening", 1, 1e3, "", nullptr, &P::coagulated_stiffening},
    RegionFigure{"blanching_pressure", 0, 1e9, "Pa", nullptr, &P::blanching_pressure},
    RegionFigure{"bruising_pressure", 0, 1e9, "Pa", nullptr, &P::bruising_pressure},
    RegionFigure{"bleeding_pressure", 0, 1e9, "Pa", nullptr, &P::bleeding_pressure},
    RegionFigure{"bleeding_speed", 0, 1e3, "m/s", nullptr, &P::bleeding_speed},
    RegionFigure{"injury_rate", 0, 10, "m/s", nullptr, &P::injury_rate},
    RegionFigure{"ooze_rate", 0, 10, "m/s", nullptr, &P::ooze_rate},
    RegionFigure{"clotting_time", 1e-3, 1e6, "s", nullptr, &P::clotting_time},
    RegionFigure{"inner_radius", 0, 0.1, "m", nullptr, &P::inner_radius, true},
    RegionFigure{"outer_radius", 0, 0.1, "m", nullptr, &P::outer_radius, true},
    RegionFigure{"pressure", 0, 1e6, "Pa", nullptr, &P::pressure},
    RegionFigure{"max_flow", 0, 1, "m3/s", nullptr, &P::max_flow},
    RegionFigure{"viscosity", 1e-6, 1e3, "Pa s", nullptr, &P::viscosity},
    RegionFigure{"fluid_density", 1, 1e5, "kg/m3", nullptr, &P::fluid_density},
};

}  // namespace

std::span<const RegionFigure> region_figures() {
  return figures;
}

const RegionFigure* region_figure(std::string_view key) {
  for (const RegionFigure& figure : figures)
    if (key == figure.key) return &figure;
  return nullptr;
}

}  // namespace calot::detail
