// Inside this room only: how thin layers and small lenses of blood and bile behave.
#pragma once
#include "calot/sim/tissue_properties.h"

namespace calot::detail {

struct Liquid {
  double viscosity = 3.5e-3;  ///< [Pa s]
  double density = 1060;      ///< [kg/m³]
  double tension = 0.056;     ///< against gas [N/m], [Hrncir1997]
};

/// Mean speed of a film of this thickness [m] under an acceleration along the surface [m/s²]: ρ a h² / (3 μ).
/// Source: [Nusselt1916].
double film_speed(const Liquid& liquid, double thickness, double acceleration);
/// Time in which it gets there, ρ h² / (3 μ): what that speed is per acceleration [s].
double film_time(const Liquid& liquid, double thickness);

struct LensShape {
  double radius = 0, depth = 0;  ///< [m]
  [[nodiscard]] double mean_thickness(double volume) const;
};
/// A liquid lens of some volume [m³] on a level surface that it meets at an angle [rad]: a cap of a ball, or, once that
/// would be deeper than a puddle is, 2 √(γ/ρg) sin(angle/2), a cap of that depth. Source: [deGennes2004], 2.2.
LensShape lens_shape(const Liquid& liquid, double volume, double angle);

/// What holds a lens of this radius on a slope [N]: share · γ · width. Source: [Furmidge1962].
double holding_force(const Liquid& liquid, double radius, double share);

/// What hangs from a round neck before it falls [m³], with the part that stays subtracted. Source: [Tate1864].
double drip_volume(const Liquid& liquid, double neck_radius);

}  // namespace calot::detail
