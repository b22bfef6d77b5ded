#include "calot/view/passes/surface_programs.h"

namespace calot::detail {
namespace {

/// A number for everything that decides a program.
std::uint32_t number_of(const Drawable& d, const SurfaceVariant& v) {
  const bool plain = v.pass != SurfacePass::color;
  std::uint32_t number = static_cast<std::uint32_t>(d.kind) * 4 + static_cast<std::uint32_t>(v.pass);
  if (plain) return number;
  const bool tissue = d.kind == SurfaceKind::tissue;
  number = number * 32 + (tissue ? 2 * static_cast<std::uint32_t>(d.look) + (d.cut ? 1U : 0U) : 0);
  return 1024 + number * 4 + (v.lite ? 2U : 0U) + (tissue && v.mask ? 1U : 0U);
}

}  // namespace

ProgramKey surface_program(const Drawable& d, const SurfaceVariant& v) {
  ProgramKey key{"surface_vertex.glsl", "depth_fragment.glsl", {}};
  if (d.kind == SurfaceKind::instrument) key.definitions.emplace_back("INSTRUMENT");
  if (v.pass == SurfacePass::shadow) key.definitions.emplace_back("SHADOW");
  if (v.pass != SurfacePass::color) return key;
  key.fragment = "surface_fragment.glsl";
  if (v.lite) key.definitions.emplace_back("LITE");
  if (d.kind == SurfaceKind::cavity) key.definitions.emplace_back("CAVITY");
  if (d.kind != SurfaceKind::tissue) return key;
  key.definitions.emplace_back("TISSUE");
  key.definitions.emplace_back("LOOK " + std::to_string(static_cast<int>(d.look)));
  key.definitions.emplace_back(d.cut ? "CUT true" : "CUT false");
  if (v.mask) key.definitions.emplace_back("MASK");
  return key;
}

std::vector<ProgramKey> all_surface_programs() {
  std::vector<ProgramKey> keys;
  Drawable d;
  for (const SurfaceKind kind : {SurfaceKind::tissue, SurfaceKind::instrument, SurfaceKind::cavity}) {
    d.kind = kind;
    for (const SurfacePass pass : {SurfacePass::shadow, SurfacePass::depth})
      keys.push_back(surface_program(d, {pass, false, false}));
    for (const bool lite : {false, true})
      for (int look = 0; look < (kind == SurfaceKind::tissue ? 8 : 1); ++look)
        for (int bits = 0; bits < (kind == SurfaceKind::tissue ? 4 : 1); ++bits) {
          d.look = static_cast<TissueLook>(look);
          d.cut = (bits & 1) != 0;
          keys.push_back(surface_program(d, {SurfacePass::color, lite, (bits & 2) != 0}));
        }
  }
  return keys;
}

const Program& SurfaceDrawer::program(const Drawable& drawable, const SurfaceVariant& variant) {
  const Number number = number_of(drawable, variant);
  const auto found = programs_.find(number);
  if (found != programs_.end()) return found->second;
  return programs_.emplace(number, Program(surface_program(drawable, variant))).first->second;
}

void SurfaceDrawer::draw(std::span<const Drawable> drawables, const SurfaceVariant& variant,
                         const std::function<void(const Program&)>& set_up) {
  const Program* current = nullptr;
  for (const Drawable& d : drawables) {
    if (variant.pass == SurfacePass::shadow && !d.casts_shadow) continue;
    const Program& wanted = program(d, variant);  // made here, it comes into use
    if (&wanted != current) {
      current = &wanted;
      current->use();
      if (set_up && variant.pass == SurfacePass::color) set_up(*current);
    }
    if (d.kind == SurfaceKind::instrument) {
      current->set("pose", d.pose);
      current->set("substance", d.substance);
    }
    if (d.two_sided)
      glDisable(GL_CULL_FACE);
    else
      glEnable(GL_CULL_FACE);
    glBindVertexArray(d.vertices);
    glDrawElements(GL_TRIANGLES, d.count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(4 * d.first));
  }
}

}  // namespace calot::detail
