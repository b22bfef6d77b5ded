// Inside this room only: what all shaders of one picture share, as shaders/frame.glsl declares it.
#pragma once
#include "calot/view/camera.h"
#include "calot/view/gl/objects.h"

namespace calot::detail {

struct FrameBlock {
  Eigen::Matrix4f view_projection, light_view_projection;
  Eigen::Vector4f eye, right, up, forward, light, light_axis, viewport, ambient, gas, scope;
};

struct FrameSettings {
  int width = 0, height = 0;  ///< pixels
  int shadow_size = 0;        ///< of the lamp's map
  float distance = 0.08F;     ///< at which tissue is well lit [m]
  float haze = 0;             ///< of the gas [1/m]
  bool lens = false;          ///< bends the picture and fringes its colours
};

FrameBlock frame_block(const Camera& camera, const FrameSettings& settings);

/// The block on the graphics card, at binding point 0.
class FrameUniforms {
 public:
  void upload(const FrameBlock& block);

 private:
  GlBuffer buffer_;
};

}  // namespace calot::detail
