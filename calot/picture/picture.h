// Pictures of surfaces, drawn on the processor without a window: the same bytes on any number of threads.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calot/mesh/surface.h"

namespace calot {

/// Pixels, rows from the top, three bytes (sRGB) each.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 × width × height
};

/// One surface in a picture. The spans and the surface must outlive the call that draws them.
struct PictureItem {
  const Surface* surface = nullptr;
  std::span<const Vec3> positions = {};  ///< [m], of the surface's vertices or of the mesh's; empty: the surface's own
  Vec3 color{0.80, 0.48, 0.42};          ///< sRGB, each 0 … 1
  double opacity = 1;  ///< 0 … 1; below 1 the nearest layer of the item is blended over what lies behind
  std::span<const double> scalar = {};  ///< numbered like `positions`; when given, the colour map replaces the colour
  std::string label = {};               ///< for the legend; empty: none
  std::map<std::int32_t, Vec3> region_colors = {};  ///< colour of the triangles of a region, where it differs
  std::span<const std::uint8_t> cut_faces = {};     ///< a flag a triangle: drawn in `cut_color`; empty: none
  Vec3 cut_color{0.93, 0.78, 0.62};
  bool edges = false;  ///< draws the triangles' edges
};

enum class Background { white, dark };

/// Points [m] that a picture shows; give several pictures the same ones and they share a camera.
struct PictureFrame {
  std::vector<Vec3> points;
};

struct PictureOptions {
  int width = 1280, height = 960;  ///< pixels, 16 … 16384
  Vec3 direction{-0.35, -1,
                 -0.3};  ///< the camera looks along it; RAS: by default from the front, a little from the right
  Vec3 up{0, 0, 1};      ///< not along `direction`
  std::string title = {}, caption = {};  ///< above and below; empty: none
  Background background = Background::white;
  std::optional<PictureFrame> frame = {};                      ///< what to show; default: all items
  std::optional<std::pair<double, double>> scalar_range = {};  ///< of the colour map; default: of all scalars
  std::string scalar_label = {};                               ///< over the colour bar: "displacement [mm]"
  bool scale_bar = true;                                       ///< [mm], right at the depth of the middle
  int samples = 3;                                             ///< 1 … 8, squared: rays a pixel
};

/// Draws items as one picture. Throws InputError for sizes out of range, a null surface, spans of a wrong length, a
/// non-finite position or scalar, and a view direction of no length or along `up`.
Image render_picture(const std::vector<PictureItem>& items, const PictureOptions& options = {});

/// Several pictures in a row, on one canvas as high as the highest.
Image beside(const std::vector<Image>& images, Background background = Background::white);

/// Writes a PNG, without time stamps, whole or not at all.
void write_png(const std::filesystem::path& path, const Image& image);

/// `render_picture` and `write_png` in one.
void write_picture(const std::filesystem::path& path, const std::vector<PictureItem>& items,
                   const PictureOptions& options = {});

/// Every vertex of the items: a frame that fits them closely.
PictureFrame frame_of(const std::vector<PictureItem>& items);

/// Flags the triangles of `after` that were not on the surface before an edit: the faces that a cut laid open.
/// @param vertex_to_old  of the edit's Remap: old number of each vertex of the mesh after it
std::vector<std::uint8_t> exposed_faces(const Surface& before, const Surface& after,
                                        std::span<const VertexId> vertex_to_old);

/// An arrow from a point to a point [m]; shaft of this radius.
Surface arrow_surface(const Vec3& from, const Vec3& to, double radius);
/// A cylinder with round ends between two points [m]; a ball where they meet.
Surface capsule_surface(const Vec3& from, const Vec3& to, double radius);
/// Balls of one radius around points [m].
Surface ball_surface(std::span<const Vec3> centres, double radius);

}  // namespace calot
