// Inside this room only: how a point of tissue looks.
#pragma once
#include "calot/picture/camera.h"

namespace calot::detail {

/// A visible point.
struct SurfacePoint {
  Vec3 position, normal;  ///< [m]; unit, outwards
  Vec3 albedo;            ///< linear light
  bool mapped = false;    ///< the colour carries a value: light it evenly
};

/// Light that reaches the camera, linear: a key light over the left shoulder, a weaker one from the right, light from
/// above and below, a moist highlight, and edges that darken as they turn away.
Vec3 shade(const SurfacePoint& point, const Camera& camera);

}  // namespace calot::detail
