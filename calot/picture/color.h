// Inside this room only: colours.
#pragma once
#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// sRGB (0 … 1) to linear light, and back.
Vec3 linear_of(const Vec3& srgb);
Vec3 srgb_of(const Vec3& linear);

/// The colour map at t (clamped to 0 … 1), in linear light: deep blue over teal to light yellow. A straight line of
/// lightness through OKLab [Ottosson2020], so that equal steps look equal; blue to yellow is seen with any colour
/// vision.
Vec3 colormap(double t);

}  // namespace calot::detail
