#include "calot/view/passes/effects_drawn.h"

#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

constexpr float spark_time = 0.004F;  // that a streak lasts on the picture [s]
constexpr float shutter = 0.008F;     // that a drop is smeared over [s]

/// One square that faces the camera, or lies along `along`.
struct Sprite {
  std::array<float, 3> position;
  std::array<float, 3> along;  // from the middle to the end [m]; zero for round ones
  float radius;
  std::array<float, 4> look;  // drops: bile; sparks: heat; puffs: depth, turn, seed, steam
};

std::array<float, 3> three(const Vec3f& v) {
  return {v.x(), v.y(), v.z()};
}

const ProgramKey pool_key{"pool_vertex.glsl", "pool_fragment.glsl", {}};
const ProgramKey drop_key{"sprite_vertex.glsl", "drop_fragment.glsl", {}};
const ProgramKey spark_key{"sprite_vertex.glsl", "spark_fragment.glsl", {}};
const ProgramKey smoke_key{"sprite_vertex.glsl", "smoke_fragment.glsl", {}};

}  // namespace

std::vector<ProgramKey> all_effect_programs() {
  std::vector<ProgramKey> keys;
  for (ProgramKey key : {pool_key, drop_key, spark_key, smoke_key}) {
    keys.push_back(key);
    key.definitions.emplace_back("LITE");
    keys.push_back(key);
  }
  return keys;
}

void MaskTexture::upload(const MaskVolume& mask) {
  painted_ = mask.bytes() > 0 && !mask.used_bricks().empty();
  if (!painted_ || (texture_ && version_ == mask.version() && size_ == mask.size())) return;
  const bool fresh = !texture_ || size_ != mask.size() || origin_ != mask.origin();
  const auto [w, h, d] = mask.size();
  if (fresh) {
    texture_ = GlTexture::make();
    size_ = mask.size();
    origin_ = mask.origin();
    scale_ = mask.texture_scale();
  }
  bind_texture(unit_of_mask, GL_TEXTURE_3D, texture_.number());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (fresh) {
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, w, h, d, 0, GL_RGBA, GL_UNSIGNED_BYTE, mask.data());
    for (const GLenum side : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
      glTexParameteri(GL_TEXTURE_3D, side, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, 0);
  } else {
    glPixelStorei(GL_UNPACK_ROW_LENGTH, w);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, h);
    for (const VoxelBlock& box : mask.dirty_boxes(version_)) {
      const auto [x, y, z] = box.first;
      const auto [nx, ny, nz] = box.size;
      if (nx > 0 && ny > 0 && nz > 0)
        glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, nx, ny, nz, GL_RGBA, GL_UNSIGNED_BYTE, mask.at(x, y, z));
    }
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
  }
  version_ = mask.version();
}

void MaskTexture::set(const Program& program) const {
  bind_texture(unit_of_mask, GL_TEXTURE_3D, texture_.number());
  program.set("mask_origin", origin_);
  program.set("mask_scale", scale_);
}

void EffectsDrawn::use(const ProgramKey& key) {
  ProgramKey wanted = key;
  if (lite_) wanted.definitions.emplace_back("LITE");
  programs_.get(wanted).use();
}

void EffectsDrawn::send_pools(const EffectsState& effects) {
  pool_count_ = static_cast<GLsizei>(effects.pool_indices.size());
  if (pool_count_ == 0 || effects.pool_vertices.empty()) return;
  if (!pools_) pools_ = GlVertexArray::make();
  const std::size_t size = effects.pool_vertices.size() * sizeof(PoolVertex);
  do {
    auto* out = static_cast<PoolVertex*>(pool_buffer_.map(size));
    std::copy(effects.pool_vertices.begin(), effects.pool_vertices.end(), out);
  } while (!pool_buffer_.unmap());
  glBindVertexArray(pools_.number());
  attribute(0, 3, GL_FLOAT, false, sizeof(PoolVertex), offsetof(PoolVertex, position));
  attribute(1, 3, GL_FLOAT, false, sizeof(PoolVertex), offsetof(PoolVertex, normal));
  attribute(2, 3, GL_FLOAT, false, sizeof(PoolVertex), offsetof(PoolVertex, thickness));
  if (!pool_indices_) pool_indices_ = GlBuffer::make();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, pool_indices_.number());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * effects.pool_indices.size()),
               effects.pool_indices.data(), GL_STREAM_DRAW);
}

void EffectsDrawn::send_sprites(const EffectsState& effects, const Camera& camera) {
  std::vector<Sprite> sprites;
  for (const DropState& drop : effects.drops)
    sprites.push_back({three(drop.position),
                       three(0.5F * shutter * drop.velocity),
                       drop.radius,
                       {drop.fluid == Fluid::bile ? 1.0F : 0.0F, 0, 0, 0}});
  for (const SparkState& spark : effects.sparks)
    sprites.push_back({three(spark.position - 0.5F * spark_time * spark.velocity),
                       three(0.5F * spark_time * spark.velocity),
                       0.00012F,
                       {spark.heat, 0, 0, 0}});
  std::vector<const PuffState*> far_first;
  for (const PuffState& puff : effects.puffs) far_first.push_back(&puff);
  const auto depth = [&](const PuffState* puff) { return (puff->position - camera.eye).dot(camera.forward); };
  std::stable_sort(far_first.begin(), far_first.end(),
                   [&](const PuffState* a, const PuffState* b) { return depth(a) > depth(b); });
  for (const PuffState* puff : far_first)
    sprites.push_back({three(puff->position),
                       {0, 0, 0},
                       puff->radius,
                       {puff->depth, puff->turn, puff->seed, puff->kind == PuffKind::steam ? 1.0F : 0.0F}});
  drops_ = static_cast<GLsizei>(effects.drops.size());
  sparks_ = static_cast<GLsizei>(effects.sparks.size());
  puffs_ = static_cast<GLsizei>(effects.puffs.size());
  if (sprites.empty()) return;
  if (!sprites_) sprites_ = GlVertexArray::make();
  const std::size_t size = sprites.size() * sizeof(Sprite);
  do {
    std::copy(sprites.begin(), sprites.end(), static_cast<Sprite*>(sprite_buffer_.map(size)));
  } while (!sprite_buffer_.unmap());
}

void EffectsDrawn::upload(const EffectsState& effects, const Camera& camera) {
  mask_.upload(effects.mask);
  send_pools(effects);
  send_sprites(effects, camera);
}

namespace {

/// Four corners for each sprite from number `first` on.
void draw_sprites(const GlVertexArray& array, GLuint buffer, GLsizei first, GLsizei count) {
  if (count == 0) return;
  glBindVertexArray(array.number());
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  const std::size_t start = static_cast<std::size_t>(first) * sizeof(Sprite);
  attribute(0, 3, GL_FLOAT, false, sizeof(Sprite), start + offsetof(Sprite, position));
  attribute(1, 3, GL_FLOAT, false, sizeof(Sprite), start + offsetof(Sprite, along));
  attribute(2, 1, GL_FLOAT, false, sizeof(Sprite), start + offsetof(Sprite, radius));
  attribute(3, 4, GL_FLOAT, false, sizeof(Sprite), start + offsetof(Sprite, look));
  for (GLuint k = 0; k < 4; ++k) glVertexAttribDivisor(k, 1);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);
}

}  // namespace

void EffectsDrawn::draw_liquids() {
  if (pool_count_ + drops_ + sparks_ == 0) return;
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (pool_count_ > 0) {
    use(pool_key);
    glBindVertexArray(pools_.number());
    glDrawElements(GL_TRIANGLES, pool_count_, GL_UNSIGNED_INT, nullptr);
  }
  if (drops_ > 0) use(drop_key);
  draw_sprites(sprites_, sprite_buffer_.number(), 0, drops_);
  glBlendFunc(GL_ONE, GL_ONE);
  if (sparks_ > 0) use(spark_key);
  draw_sprites(sprites_, sprite_buffer_.number(), drops_, sparks_);
  glDisable(GL_BLEND);
}

void EffectsDrawn::draw_smoke() {
  if (puffs_ == 0) return;
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  use(smoke_key);
  draw_sprites(sprites_, sprite_buffer_.number(), drops_ + sparks_, puffs_);
  glDisable(GL_BLEND);
}

}  // namespace calot::detail
