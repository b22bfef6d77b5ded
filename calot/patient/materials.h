// What each structure is made of, for a start: published stiffnesses with their sources.
#pragma once
#include <string>

#include "calot/patient/structure.h"

namespace calot {

/// Linear elastic tissue.
struct TissueMaterial {
  double young = 0;    ///< E [Pa]
  double poisson = 0;  ///< ν
  double density = 0;  ///< [kg/m³]
  std::string source;  ///< where the number is from, and what was assumed
};

/// E = 3 G of the published shear modulus where there is one (docs/patient.md has the table).
TissueMaterial material_of(Structure s);

/// How a structure looks, for the renderer: base colour (sRGB) and the size of its texture.
struct Appearance {
  double red, green, blue;  ///< 0 … 1
  double texture_size;      ///< [m] of one repeat of a triplanar texture
  double blend_sharpness;   ///< exponent k of the triplanar weights |n|^k, ≥ 1
};
Appearance appearance_of(Structure s);

}  // namespace calot
