// Inside this room only: triangles to pixels.
#pragma once
#include <vector>

#include "calot/picture/scene.h"

namespace calot::detail {

/// What the camera saw, before the background: linear light times coverage, coverage, and depth.
struct Film {
  int width = 0, height = 0;
  std::vector<Vec3> light;      ///< premultiplied
  std::vector<float> coverage;  ///< 0 … 1
  std::vector<float> depth;     ///< [m], mean over the covered samples of opaque things; 0 where there are none
};

/// Draws a projected scene, `samples`² samples a pixel.
Film draw(const Scene& scene, const Camera& camera, int width, int height, int samples);

}  // namespace calot::detail
