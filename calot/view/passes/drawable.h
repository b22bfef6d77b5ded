// Inside this room only: something to draw, the same for depth, shadow and colour.
#pragma once
#include <Eigen/Core>

#include "calot/view/gl/objects.h"
#include "calot/view/snapshot.h"

namespace calot::detail {

enum class SurfaceKind : std::uint8_t { tissue, instrument, cavity };

struct Drawable {
  SurfaceKind kind = SurfaceKind::tissue;
  TissueLook look = TissueLook::soft;
  bool cut = false;
  bool two_sided = false;
  bool casts_shadow = true;
  GLuint vertices = 0;    ///< vertex array, with its index buffer
  GLsizei count = 0;      ///< of indices
  std::size_t first = 0;  ///< of them
  int substance = 0;      ///< of an instrument: ModelMaterial
  Eigen::Matrix4f pose = Eigen::Matrix4f::Identity();
  float distance = 0;  ///< from the camera [m]: near ones are drawn first
};

}  // namespace calot::detail
