// Inside this room only: items checked and flattened into triangles that are ready to draw.
#pragma once
#include <array>
#include <vector>

#include "calot/picture/camera.h"
#include "calot/picture/picture.h"

namespace calot::detail {

/// A triangle with everything its pixels need.
struct SceneTriangle {
  std::array<Vec3, 3> point;     ///< [m]
  std::array<Vec3, 3> normal;    ///< unit, outwards
  std::array<Vec3, 3> screen;    ///< pixel x, y and 1/depth
  std::array<double, 3> scalar;  ///< 0 … 1 of the colour map's range
  Vec3 color;                    ///< linear light
  bool mapped = false;           ///< colour from the scalar
  bool edges = false;
  std::uint32_t layer = 0;  ///< 0: opaque; k: the k-th transparent item
};

struct Scene {
  std::vector<SceneTriangle> triangles;
  std::vector<double> layer_opacity;  ///< [0] is 1
  std::pair<double, double> scalar_range{0, 1};
  bool has_scalars = false;
};

/// The place of each surface vertex under an item's override.
std::vector<Vec3> item_positions(const PictureItem& item);
/// Throws InputError for anything wrong with an item.
void check_items(const std::vector<PictureItem>& items);
Scene make_scene(const std::vector<PictureItem>& items, const PictureOptions& options);
void project(Scene& scene, const Camera& camera);

}  // namespace calot::detail
