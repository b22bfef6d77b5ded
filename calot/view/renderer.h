// Draws a moment of the world with OpenGL 3.3. docs/view.md has the passes.
#pragma once
#include <functional>
#include <memory>
#include <span>

#include "calot/picture/picture.h"
#include "calot/view/camera.h"
#include "calot/view/effects/effects_state.h"
#include "calot/view/snapshot.h"

namespace calot {

enum class PictureQuality : std::uint8_t {
  full,  ///< light in half floats, ambient light, smoothed edges, lens
  lite,  ///< for processors that draw by themselves
  none,  ///< nothing but the interface
};
std::string_view name_of(PictureQuality quality);

/// Where a picture goes: a framebuffer object, or 0 for a window's.
struct Canvas {
  unsigned framebuffer = 0;
  int width = 0, height = 0;  ///< pixels, 16 … 8192
};

/// A framebuffer to draw pictures into that are read back.
class PictureCanvas {
 public:
  PictureCanvas(int width, int height);
  ~PictureCanvas();
  PictureCanvas(const PictureCanvas&) = delete;
  PictureCanvas& operator=(const PictureCanvas&) = delete;
  [[nodiscard]] const Canvas& canvas() const { return canvas_; }
  [[nodiscard]] Image read() const;

 private:
  Canvas canvas_;
  unsigned color_ = 0;
};

/// What the last picture was made of.
struct RenderStatistics {
  std::size_t tissue_vertices = 0, index_uploads = 0, drawables = 0, programs = 0;
  double upload = 0;  ///< time to compute normals and send the tissue [s]
};

/// Needs a current context from its making to its end; one thread.
class Renderer {
 public:
  explicit Renderer(PictureQuality quality);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Walls and organs that don't move. Without any there is a dim cavity around the tissue.
  void set_surroundings(std::span<const Surface> surfaces);
  /// Compiles what this scene will need, cut faces too, so that no picture waits for it later.
  void prepare(const Snapshot& snapshot);

  /// One picture. `interface` draws over it, into the canvas that is bound then; it may be empty.
  void render(const Snapshot& snapshot, const EffectsState& effects, const Camera& camera, const Canvas& canvas,
              const std::function<void()>& interface = {});
  [[nodiscard]] PictureQuality quality() const;
  [[nodiscard]] const RenderStatistics& statistics() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Compiles every variant of every shader in the current context. @return how many programs; throws FailedError
std::size_t compile_all_shaders();

}  // namespace calot
