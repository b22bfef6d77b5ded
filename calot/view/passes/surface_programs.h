// Inside this room only: the programs that draw surfaces, one for each kind, look and pass.
#pragma once
#include <functional>
#include <span>

#include "calot/view/gl/program.h"
#include "calot/view/passes/drawable.h"

namespace calot::detail {

enum class SurfacePass : std::uint8_t { shadow, depth, color };

/// What decides a program, beside the drawable.
struct SurfaceVariant {
  SurfacePass pass = SurfacePass::color;
  bool lite = false, mask = false;
};

ProgramKey surface_program(const Drawable& drawable, const SurfaceVariant& variant);
/// Every one that there is.
std::vector<ProgramKey> all_surface_programs();

/// Draws surfaces one after the other.
class SurfaceDrawer {
 public:
  /// @param set_up  sets a program's own uniforms, each time it comes into use
  void draw(std::span<const Drawable> drawables, const SurfaceVariant& variant,
            const std::function<void(const Program&)>& set_up = {});
  [[nodiscard]] const Program& program(const Drawable& drawable, const SurfaceVariant& variant);
  [[nodiscard]] std::size_t program_count() const { return programs_.size(); }

 private:
  using Number = std::uint32_t;
  std::map<Number, Program> programs_;
};

}  // namespace calot::detail
