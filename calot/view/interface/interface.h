// What is written and pressed over the picture: step, instruments, forces, fluids, time; settings and keys.
#pragma once
#include <memory>

#include "calot/view/interface/interface_state.h"
#include "calot/view/interface/text.h"

namespace calot {

/// What was laid out last, for tests and reports.
struct InterfaceLayout {
  float text_height = 0;  ///< of the usual text [pixels]
  std::size_t vertices = 0, triangles = 0;
};

/// Knows nothing of windows and the world; writes no files. Once it has drawn, it ends (or `release`s) while its OpenGL
/// context is current. All interfaces of a program belong to one thread.
class Interface {
 public:
  explicit Interface(TextTable text);
  ~Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  /// Opens the page of keys, as on the first run.
  void show_help();
  /// Lays everything out. Needs no context.
  /// @param width, height  of the picture [pixels], 64 … 8192
  /// @param pixel_ratio    pixels per point of the screen: 1, on HiDPI screens 1.5 or 2
  InterfaceActions lay_out(const InterfaceState& state, const InterfaceInput& input, int width, int height,
                           double pixel_ratio = 1);
  /// Draws what was laid out last into the framebuffer that is bound. Needs an OpenGL context, the same each time.
  void draw();
  /// Frees what is in the context, while it is current; `draw` makes it anew.
  void release();
  [[nodiscard]] InterfaceLayout layout() const;
  /// Corners of all triangles laid out, as x, y, and opacity 0 … 1, in threes.
  [[nodiscard]] std::vector<std::array<float, 3>> corners() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace calot
