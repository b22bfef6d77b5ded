// Inside this room only: blood, bile, smoke and sparks on the graphics card. effects_state.h says how they look.
#pragma once
#include <functional>

#include "calot/view/camera.h"
#include "calot/view/effects/effects_state.h"
#include "calot/view/gl/program.h"
#include "calot/view/gl/targets.h"

namespace calot::detail {

std::vector<ProgramKey> all_effect_programs();

/// The mask's voxels as a texture.
class MaskTexture {
 public:
  void upload(const MaskVolume& mask);
  /// Whether there is anything on it.
  [[nodiscard]] bool painted() const { return painted_; }
  /// Binds it and tells a program where it lies.
  void set(const Program& program) const;

 private:
  GlTexture texture_;
  std::array<int, 3> size_{};
  Vec3f origin_ = Vec3f::Zero(), scale_ = Vec3f::Zero();
  std::uint64_t version_ = 0;
  bool painted_ = false;
};

class EffectsDrawn {
 public:
  explicit EffectsDrawn(bool lite) : lite_(lite) {}
  void upload(const EffectsState& effects, const Camera& camera);
  /// With the picture's depths as depth buffer, which it leaves as they are.
  void draw_liquids();
  /// With them as a texture, so that smoke ends softly where it meets tissue.
  void draw_smoke();
  [[nodiscard]] const MaskTexture& mask() const { return mask_; }

 private:
  void send_pools(const EffectsState& effects);
  void send_sprites(const EffectsState& effects, const Camera& camera);
  void use(const ProgramKey& key);

  bool lite_;
  ProgramCache programs_;
  MaskTexture mask_;
  GlVertexArray pools_, sprites_;
  StreamBuffer pool_buffer_, sprite_buffer_;
  GlBuffer pool_indices_;
  GLsizei pool_count_ = 0, drops_ = 0, sparks_ = 0, puffs_ = 0;  // of indices, of sprites
};

}  // namespace calot::detail
