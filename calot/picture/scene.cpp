#include "calot/picture/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/picture/color.h"

namespace calot::detail {
namespace {

constexpr double crease_cosine = 0.6;  // edges sharper than about 53° stay sharp

[[noreturn]] void wrong(std::size_t item, const std::string& what) {
  throw InputError("picture item " + std::to_string(item), what, "see calot/picture/picture.h");
}

/// Whether values numbered like this many things belong to the surface's vertices or, through it, to the mesh's.
bool fits(const Surface& surface, std::size_t count) {
  if (count == surface.positions.size()) return true;
  if (surface.vertex_of_mesh.empty()) return false;
  return std::all_of(surface.vertex_of_mesh.begin(), surface.vertex_of_mesh.end(),
                     [&](VertexId v) { return v.index() < count; });
}

template <class T>
T of_vertex(const Surface& surface, std::span<const T> values, std::size_t vertex) {
  const bool own = values.size() == surface.positions.size();
  return own ? values[vertex] : values[surface.vertex_of_mesh[vertex].index()];
}

void check_item(const PictureItem& item, std::size_t number) {
  if (item.surface == nullptr) wrong(number, "there is no surface");
  const Surface& s = *item.surface;
  for (const Triangle& triangle : s.triangles)
    for (const std::uint32_t v : triangle)
      if (v >= s.positions.size())
        wrong(number, "a triangle names vertex " + std::to_string(v) + ", which isn't there");
  if (!item.positions.empty() && !fits(s, item.positions.size())) wrong(number, "the positions don't fit the surface");
  if (!item.scalar.empty() && !fits(s, item.scalar.size())) wrong(number, "the scalars don't fit the surface");
  if (!item.cut_faces.empty() && item.cut_faces.size() != s.triangles.size())
    wrong(number, "there must be one cut-face flag a triangle");
  if (!(item.opacity >= 0 && item.opacity <= 1)) wrong(number, "the opacity is outside 0 … 1");
  for (std::size_t v = 0; v < s.positions.size(); ++v) {
    const Vec3 p = item.positions.empty() ? s.positions[v] : of_vertex(s, item.positions, v);
    if (!p.allFinite()) wrong(number, "vertex " + std::to_string(v) + " is not at a finite place");
    if (!item.scalar.empty() && !std::isfinite(of_vertex(s, item.scalar, v)))
      wrong(number, "the scalar of vertex " + std::to_string(v) + " is not finite");
  }
}

/// Twice the area times the unit normal of each triangle.
std::vector<Vec3> area_normals(const Surface& surface, const std::vector<Vec3>& positions) {
  std::vector<Vec3> normals;
  normals.reserve(surface.triangles.size());
  for (const auto& [a, b, c] : surface.triangles)
    normals.push_back((positions[b] - positions[a]).cross(positions[c] - positions[a]));
  return normals;
}

/// Normals at each corner: the mean of the triangles around the vertex that bend less than a crease from this one.
std::vector<std::array<Vec3, 3>> corner_normals(const Surface& surface, const std::vector<Vec3>& positions) {
  const std::vector<Vec3> flat = area_normals(surface, positions);
  std::vector<std::vector<std::uint32_t>> around(positions.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t v : surface.triangles[t]) around[v].push_back(static_cast<std::uint32_t>(t));
  std::vector<std::array<Vec3, 3>> normals(surface.triangles.size());
  parallel_blocks(normals.size(), 1024, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t t = begin; t < end; ++t)
      for (int corner = 0; corner < 3; ++corner) {
        Vec3 sum = Vec3::Zero();
        for (const std::uint32_t other : around[surface.triangles[t][corner]])
          if (flat[other].dot(flat[t]) >= crease_cosine * flat[other].norm() * flat[t].norm()) sum += flat[other];
        normals[t][corner] = sum.norm() > 0 ? sum.normalized().eval() : Vec3::UnitZ();
      }
  });
  return normals;
}

std::pair<double, double> range_of(const std::vector<PictureItem>& items) {
  std::pair<double, double> range{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  for (const PictureItem& item : items)
    for (std::size_t v = 0; !item.scalar.empty() && v < item.surface->positions.size(); ++v) {
      const double value = of_vertex(*item.surface, item.scalar, v);
      range = {std::min(range.first, value), std::max(range.second, value)};
    }
  if (range.first > range.second) return {0, 1};
  if (range.first == range.second) range.second = range.first + std::max(1e-12, std::abs(range.first));
  return range;
}

Vec3 triangle_color(const PictureItem& item, std::size_t t) {
  if (!item.cut_faces.empty() && item.cut_faces[t] != 0) return item.cut_color;
  if (!item.surface->regions.empty()) {
    const auto found = item.region_colors.find(item.surface->regions[t]);
    if (found != item.region_colors.end()) return found->second;
  }
  return item.color;
}

void add_item(Scene& scene, const PictureItem& item) {
  const Surface& surface = *item.surface;
  const std::vector<Vec3> positions = item_positions(item);
  const std::vector<std::array<Vec3, 3>> normals = corner_normals(surface, positions);
  std::uint32_t layer = 0;
  if (item.opacity < 1) {
    layer = static_cast<std::uint32_t>(scene.layer_opacity.size());
    scene.layer_opacity.push_back(item.opacity);
  }
  const auto [low, high] = scene.scalar_range;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    SceneTriangle& triangle = scene.triangles.emplace_back();
    triangle.normal = normals[t];
    triangle.color = linear_of(triangle_color(item, t).cwiseMax(0.0).cwiseMin(1.0));
    const bool is_cut = !item.cut_faces.empty() && item.cut_faces[t] != 0;
    triangle.mapped = !item.scalar.empty() && !is_cut;
    triangle.edges = item.edges;
    triangle.layer = layer;
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = surface.triangles[t][corner];
      triangle.point[corner] = positions[v];
      triangle.scalar[corner] = item.scalar.empty() ? 0 : (of_vertex(surface, item.scalar, v) - low) / (high - low);
    }
  }
}

}  // namespace

std::vector<Vec3> item_positions(const PictureItem& item) {
  if (item.positions.empty()) return item.surface->positions;
  std::vector<Vec3> positions(item.surface->positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = of_vertex(*item.surface, item.positions, v);
  return positions;
}

void check_items(const std::vector<PictureItem>& items) {
  for (std::size_t i = 0; i < items.size(); ++i) check_item(items[i], i);
}

Scene make_scene(const std::vector<PictureItem>& items, const PictureOptions& options) {
  Scene scene;
  scene.layer_opacity = {1};
  scene.has_scalars = std::any_of(items.begin(), items.end(), [](const auto& item) { return !item.scalar.empty(); });
  scene.scalar_range = options.scalar_range.value_or(range_of(items));
  if (!(scene.scalar_range.second > scene.scalar_range.first))
    throw InputError("picture", "the scalar range is empty", "give a low end and a higher one");
  for (const PictureItem& item : items) add_item(scene, item);
  return scene;
}

void project(Scene& scene, const Camera& camera) {
  for (SceneTriangle& triangle : scene.triangles)
    for (int corner = 0; corner < 3; ++corner) triangle.screen[corner] = camera.project(triangle.point[corner]);
}

}  // namespace calot::detail
