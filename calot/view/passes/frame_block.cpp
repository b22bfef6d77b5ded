#include "calot/view/passes/frame_block.h"

#include <cmath>

namespace calot::detail {
namespace {

constexpr float lens_barrel = 0.045F, lens_fringe = 0.0016F;
constexpr float lamp_field = 1.75F;  // [rad]
constexpr float usual_exposure = 1.25F;
/// Light that walls and organs throw at each other: reddened, a few hundredths of the lamp's.
const Eigen::Vector3f ambient_color{0.060F, 0.040F, 0.036F};

Eigen::Vector4f four(const Eigen::Vector3f& v, float w) {
  return {v.x(), v.y(), v.z(), w};
}

/// The lamp as a camera of its own, beside the lens.
Camera lamp_camera(const Camera& camera) {
  Camera lamp = camera;
  lamp.eye += camera.lamp.x() * camera.right() + camera.lamp.y() * camera.up + camera.lamp.z() * camera.forward;
  lamp.scope = false;
  lamp.field = lamp_field;
  return lamp;
}

}  // namespace

FrameBlock frame_block(const Camera& camera, const FrameSettings& s) {
  const float aspect = static_cast<float>(s.width) / static_cast<float>(s.height);
  const Camera lamp = lamp_camera(camera);
  const auto w = static_cast<float>(s.width), h = static_cast<float>(s.height);
  const float radius = camera.scope ? round_field_radius * h : 4 * (w + h);
  FrameBlock block;
  block.view_projection = view_projection(camera, aspect);
  block.light_view_projection = view_projection(lamp, 1);
  const float power = s.distance * s.distance;  // lit surfaces at that distance get 1
  block.eye = four(camera.eye, usual_exposure * camera.exposure);
  block.right = four(camera.right(), half_height(camera) * aspect);
  block.up = four(camera.up, half_height(camera));
  block.forward = four(camera.forward, camera.nearest);
  block.light = four(lamp.eye, power);
  block.light_axis = four(lamp.forward, camera.farthest);
  block.viewport = {w, h, 1 / w, 1 / h};
  block.ambient = four(ambient_color, 2.0F / static_cast<float>(s.shadow_size));
  block.gas = {s.haze, 0, 0, 0};
  const bool lens = s.lens && camera.scope;
  block.scope = {radius, 1 / radius, lens ? lens_barrel : 0.0F, lens ? lens_fringe : 0.0F};
  return block;
}

void FrameUniforms::upload(const FrameBlock& block) {
  if (!buffer_) buffer_ = GlBuffer::make();
  glBindBuffer(GL_UNIFORM_BUFFER, buffer_.number());
  glBufferData(GL_UNIFORM_BUFFER, sizeof block, &block, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, buffer_.number());
}

}  // namespace calot::detail
