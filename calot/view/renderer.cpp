#include "calot/view/renderer.h"

#include <epoxy/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "calot/base/error.h"
#include "calot/view/passes/effects_drawn.h"
#include "calot/view/passes/frame_block.h"
#include "calot/view/passes/models_drawn.h"
#include "calot/view/passes/screen_passes.h"
#include "calot/view/passes/surface_programs.h"
#include "calot/view/passes/tissue_drawn.h"
#include "calot/view/textures.h"

namespace calot {

using namespace detail;

namespace {

constexpr float no_tissue_distance = 0.08F;  // [m]

/// The distance at which the lamp gives tissue as much light as it has here, the near and well lit counting most: an
/// endoscope's iris turns to that. Triangles count by the angle at which they are seen.
float metered_distance(const Snapshot& snapshot, const Camera& camera) {
  const std::size_t count = snapshot.skin.triangles.size(), stride = 1 + count / 4000;
  const double usual = 1 / (no_tissue_distance * no_tissue_distance);
  double weights = 0.1, light = weights * usual * usual;  // little tissue in view: as if some were where it usually is
  for (std::size_t t = 0; t < count; t += stride) {
    const auto& [i, j, k] = snapshot.skin.triangles[t];
    const Vec3f a = snapshot.positions[i] - camera.eye, b = snapshot.positions[j] - camera.eye,
                c = snapshot.positions[k] - camera.eye;
    const Vec3f middle = (a + b + c) / 3;
    const float d2 = middle.squaredNorm(), ahead = middle.dot(camera.forward);
    const float facing = -0.5F * middle.dot((b - a).cross(c - a));
    if (!(ahead > camera.nearest) || !(facing > 0)) continue;
    const float off_axis = d2 / (ahead * ahead) - 1;  // tan² of the angle
    const double lit = 1 / std::max(d2, 4e-4F);
    const double weight = static_cast<double>(stride) * std::exp(-off_axis / 0.4F) * facing * lit / std::sqrt(d2);
    light += weight * lit * lit;
    weights += weight;
  }
  return static_cast<float>(std::pow(weights / light, 0.25));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::string_view name_of(PictureQuality quality) {
  switch (quality) {
    case PictureQuality::full:
      return "full";
    case PictureQuality::lite:
      return "lite";
    case PictureQuality::none:
      break;
  }
  return "none";
}

struct Renderer::Parts {
  explicit Parts(PictureQuality q)
      : quality(q), textures(q == PictureQuality::lite), liquids(q == PictureQuality::lite) {}
  void fit(const Canvas& canvas);
  void gather(const Snapshot& snapshot, const EffectsState& effects, const Camera& camera);
  void draw_shadow();
  void bind_lamp();
  void draw_surfaces();
  void draw_effects();
  void finish(const Canvas& canvas);

  PictureQuality quality;
  std::optional<PictureTargets> targets;
  FrameUniforms frame;
  TissueDrawn tissue;
  TissueTextures textures;
  ModelsDrawn models;
  SurfaceDrawer drawer;
  ScreenPasses screen;
  EffectsDrawn liquids;
  std::vector<Drawable> drawables;
  RenderStatistics statistics;
};

Renderer::Renderer(PictureQuality quality) : parts_(std::make_unique<Parts>(quality)) {}
Renderer::~Renderer() = default;
PictureQuality Renderer::quality() const {
  return parts_->quality;
}
const RenderStatistics& Renderer::statistics() const {
  return parts_->statistics;
}
void Renderer::set_surroundings(std::span<const Surface> surfaces) {
  parts_->models.set_surroundings(surfaces);
}

void Renderer::Parts::fit(const Canvas& canvas) {
  if (canvas.width < 16 || canvas.height < 16 || canvas.width > 8192 || canvas.height > 8192)
    throw InputError("picture", "its size is out of range", "give 16 ... 8192 pixels each way");
  if (targets && targets->width == canvas.width && targets->height == canvas.height) return;
  targets.reset();
  targets.emplace(canvas.width, canvas.height, quality == PictureQuality::full ? 1024 : 512,
                  quality == PictureQuality::lite);
}

void Renderer::Parts::gather(const Snapshot& snapshot, const EffectsState& effects, const Camera& camera) {
  const auto start = std::chrono::steady_clock::now();
  tissue.upload(snapshot);
  statistics.upload = seconds_since(start);
  liquids.upload(effects, camera);
  drawables.clear();
  models.add_to(snapshot, drawables);
  tissue.add_to(drawables);
  // Instruments lie before the tissue, the cavity's wall behind it.
  std::stable_sort(drawables.begin(), drawables.end(), [](const Drawable& a, const Drawable& b) {
    const auto rank = [](const Drawable& d) {
      return d.kind == SurfaceKind::instrument ? 0 : d.kind == SurfaceKind::tissue ? 1 : 2;
    };
    return rank(a) < rank(b);
  });
  statistics.tissue_vertices = tissue.vertex_count();
  statistics.index_uploads = tissue.index_uploads();
  statistics.drawables = drawables.size();
  const bool lite = quality == PictureQuality::lite;
  frame.upload(frame_block(camera, {targets->width, targets->height, targets->shadow_size,
                                    metered_distance(snapshot, camera), effects.haze, !lite}));
}

void Renderer::Parts::draw_shadow() {
  glBindFramebuffer(GL_FRAMEBUFFER, targets->shadow_target.number());
  glViewport(0, 0, targets->shadow_size, targets->shadow_size);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5F, 2.0F);
  glCullFace(GL_FRONT);  // far sides: what the lamp sees is never in its own shadow
  drawer.draw(drawables, {SurfacePass::shadow, false, false});
  glCullFace(GL_BACK);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glViewport(0, 0, targets->width, targets->height);
}

/// The lamp's map, to compare with and as it is.
void Renderer::Parts::bind_lamp() {
  bind_texture(unit_of_shadow, GL_TEXTURE_2D, targets->shadow.number());
  bind_texture(unit_of_lamp_depth, GL_TEXTURE_2D, targets->shadow.number());
  glBindSampler(unit_of_lamp_depth, targets->plain_depth.number());
}

void Renderer::Parts::draw_surfaces() {
  const bool lite = quality == PictureQuality::lite;
  glBindFramebuffer(GL_FRAMEBUFFER, lite ? targets->color_target.number() : targets->depth_target.number());
  glClear(GL_DEPTH_BUFFER_BIT);
  if (lite) glClear(GL_COLOR_BUFFER_BIT);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  screen.blind();
  drawer.draw(drawables, {SurfacePass::depth, lite, false});
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  if (!lite) {
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    bind_lamp();
    screen.ambient(*targets);
    bind_texture(unit_of_ambient, GL_TEXTURE_2D, targets->ambient_smooth.number());
    glEnable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, targets->color_target.number());
    glClear(GL_COLOR_BUFFER_BIT);
  }
  textures.bind();
  bind_lamp();
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LEQUAL);
  const bool painted = liquids.mask().painted();
  drawer.draw(drawables, {SurfacePass::color, lite, painted}, [&](const Program& program) {
    if (painted) liquids.mask().set(program);
  });
  glDisable(GL_CULL_FACE);
}

void Renderer::Parts::draw_effects() {
  liquids.draw_liquids();
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets->light_target.number());
  bind_texture(unit_of_depth, GL_TEXTURE_2D, targets->depth.number());
  liquids.draw_smoke();
  glBindSampler(unit_of_lamp_depth, 0);
}

void Renderer::Parts::finish(const Canvas& canvas) {
  if (quality == PictureQuality::full) {
    screen.tone(*targets);
    screen.lens(*targets, canvas.framebuffer);
    return;
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets->color_target.number());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, canvas.framebuffer);
  glBlitFramebuffer(0, 0, canvas.width, canvas.height, 0, 0, canvas.width, canvas.height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
}

void Renderer::render(const Snapshot& snapshot, const EffectsState& effects, const Camera& camera, const Canvas& canvas,
                      const std::function<void()>& interface) {
  Parts& p = *parts_;
  glClearColor(0, 0, 0, 1);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  if (p.quality == PictureQuality::none) {
    glBindFramebuffer(GL_FRAMEBUFFER, canvas.framebuffer);
    glClear(GL_COLOR_BUFFER_BIT);
  } else {
    p.fit(canvas);
    p.gather(snapshot, effects, camera);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    p.draw_shadow();
    p.draw_surfaces();
    p.draw_effects();
    p.finish(canvas);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, canvas.framebuffer);
  glViewport(0, 0, canvas.width, canvas.height);
  if (interface) interface();
  p.statistics.programs = p.drawer.program_count();
}

void Renderer::prepare(const Snapshot& snapshot) {
  Parts& p = *parts_;
  Drawable d;
  for (const SkinVertex& v : snapshot.skin.vertices)
    for (const bool cut : {false, true}) {
      d.look = v.look;
      d.cut = cut;
      (void)p.drawer.program(d, {SurfacePass::color, p.quality == PictureQuality::lite, false});
    }
}

std::size_t compile_all_shaders() {
  std::vector<ProgramKey> keys = all_surface_programs();
  for (const ProgramKey& key : all_screen_programs()) keys.push_back(key);
  for (const ProgramKey& key : all_effect_programs()) keys.push_back(key);
  for (const ProgramKey& key : keys) const Program program(key);
  return keys.size();
}

PictureCanvas::PictureCanvas(int width, int height) {
  canvas_ = {0, width, height};
  glGenTextures(1, &color_);
  glBindTexture(GL_TEXTURE_2D, color_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glGenFramebuffers(1, &canvas_.framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, canvas_.framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color_, 0);
}

PictureCanvas::~PictureCanvas() {
  glDeleteFramebuffers(1, &canvas_.framebuffer);
  glDeleteTextures(1, &color_);
}

Image PictureCanvas::read() const {
  const auto width = static_cast<std::size_t>(canvas_.width), height = static_cast<std::size_t>(canvas_.height);
  std::vector<std::uint8_t> rgba(4 * width * height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, canvas_.framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, canvas_.width, canvas_.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  Image image{canvas_.width, canvas_.height, std::vector<std::uint8_t>(3 * width * height)};
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        image.rgb[3 * (y * width + x) + c] = rgba[4 * ((height - 1 - y) * width + x) + c];
  return image;
}

}  // namespace calot
