#include "calot/picture/raster.h"

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/picture/color.h"
#include "calot/picture/shading.h"

namespace calot::detail {
namespace {

constexpr int tile_size = 32;  // pixels
constexpr std::uint32_t nothing = 0xffffffffu;
// Where surfaces coincide, a transparent one counts as the nearer by this part of the depth: an even overlay, no
// speckle.
constexpr double overlay_bias = 1e-4;

/// The nearest triangle of one sample in one layer.
struct Hit {
  double inverse_depth = 0;
  std::uint32_t triangle = nothing;
  float weight_b = 0, weight_c = 0;  // on the screen
};

/// The tiles a triangle's bounding box meets.
struct Bins {
  int across, down;
  std::vector<std::vector<std::uint32_t>> triangles;
};

struct Bounds {
  double left, right, top, bottom;
};

Bounds bounds_of(const SceneTriangle& t) {
  const auto [left, right] = std::minmax({t.screen[0].x(), t.screen[1].x(), t.screen[2].x()});
  const auto [top, bottom] = std::minmax({t.screen[0].y(), t.screen[1].y(), t.screen[2].y()});
  return {left, right, top, bottom};
}

int tile_of(double pixel, int tiles) {
  return static_cast<int>(std::clamp(std::floor(pixel / tile_size), -1.0, static_cast<double>(tiles)));
}

Bins make_bins(const Scene& scene, int width, int height) {
  Bins bins{(width + tile_size - 1) / tile_size, (height + tile_size - 1) / tile_size, {}};
  bins.triangles.resize(static_cast<std::size_t>(bins.across) * static_cast<std::size_t>(bins.down));
  for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
    const auto& screen = scene.triangles[t].screen;
    if (screen[0].z() <= 0 || screen[1].z() <= 0 || screen[2].z() <= 0) continue;  // behind the eye
    const Bounds b = bounds_of(scene.triangles[t]);
    for (int y = std::max(0, tile_of(b.top, bins.down)); y <= std::min(bins.down - 1, tile_of(b.bottom, bins.down));
         ++y)
      for (int x = std::max(0, tile_of(b.left, bins.across));
           x <= std::min(bins.across - 1, tile_of(b.right, bins.across)); ++x)
        bins.triangles[static_cast<std::size_t>(y * bins.across + x)].push_back(static_cast<std::uint32_t>(t));
  }
  return bins;
}

double cross(const Vec3& a, const Vec3& b, double x, double y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

/// One tile's samples, layer by layer.
class Tile {
 public:
  Tile(const Scene& scene, const Camera& camera, Film& film, int samples, int left, int top)
      : scene_(scene),
        camera_(camera),
        film_(film),
        samples_(samples),
        left_(left),
        top_(top),
        width_(std::min(tile_size, film.width - left) * samples),
        height_(std::min(tile_size, film.height - top) * samples),
        hits_(scene.layer_opacity.size() * sample_count()) {}

  void cover(std::uint32_t number);
  void resolve();

 private:
  [[nodiscard]] std::size_t sample_count() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  [[nodiscard]] double sample_x(int column) const { return left_ + (column + 0.5) / samples_; }
  [[nodiscard]] double sample_y(int row) const { return top_ + (row + 0.5) / samples_; }
  [[nodiscard]] Vec3 look(const Hit& hit, double x, double y) const;
  void blend(std::size_t sample, double x, double y, Vec3& light, double& seen) const;

  const Scene& scene_;
  const Camera& camera_;
  Film& film_;
  int samples_, left_, top_, width_, height_;  // width and height in samples
  std::vector<Hit> hits_;                      // layer by layer, row by row
};

void Tile::cover(std::uint32_t number) {
  const SceneTriangle& t = scene_.triangles[number];
  const auto& [a, b, c] = t.screen;
  const double area = cross(a, b, c.x(), c.y());
  if (area == 0 || (t.layer > 0 && area > 0)) return;  // y points down: an outer face has a negative area
  const Bounds box = bounds_of(t);
  const auto index = [&](double pixel, int origin, int limit) {
    return static_cast<int>(std::clamp((pixel - origin) * samples_ - 0.5, -1.0, static_cast<double>(limit)));
  };
  const int last_row = std::min(height_ - 1, index(box.bottom, top_, height_) + 1);
  const int last_column = std::min(width_ - 1, index(box.right, left_, width_) + 1);
  for (int row = std::max(0, index(box.top, top_, height_)); row <= last_row; ++row)
    for (int column = std::max(0, index(box.left, left_, width_)); column <= last_column; ++column) {
      const double x = sample_x(column), y = sample_y(row);
      const double wa = cross(b, c, x, y) / area, wb = cross(c, a, x, y) / area, wc = 1 - wa - wb;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const double inverse = wa * a.z() + wb * b.z() + wc * c.z();
      Hit& hit = hits_[t.layer * sample_count() + static_cast<std::size_t>(row * width_ + column)];
      if (inverse > hit.inverse_depth) hit = {inverse, number, static_cast<float>(wb), static_cast<float>(wc)};
    }
}

/// Distance in pixels from a screen point to the nearest edge of a triangle.
double edge_distance(const SceneTriangle& t, double x, double y) {
  double nearest = 1e9;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = t.screen[i], &b = t.screen[(i + 1) % 3];
    nearest = std::min(nearest, std::abs(cross(a, b, x, y)) / std::max(1e-9, std::hypot(b.x() - a.x(), b.y() - a.y())));
  }
  return nearest;
}

Vec3 Tile::look(const Hit& hit, double x, double y) const {
  const SceneTriangle& t = scene_.triangles[hit.triangle];
  // Linear on the screen is linear in space after dividing by depth.
  Vec3 w{(1.0 - hit.weight_b - hit.weight_c) * t.screen[0].z(), hit.weight_b * t.screen[1].z(),
         hit.weight_c * t.screen[2].z()};
  w /= w.sum();
  SurfacePoint point;
  point.position = w[0] * t.point[0] + w[1] * t.point[1] + w[2] * t.point[2];
  point.normal = (w[0] * t.normal[0] + w[1] * t.normal[1] + w[2] * t.normal[2]).normalized();
  point.mapped = t.mapped;
  point.albedo = t.mapped ? colormap(w[0] * t.scalar[0] + w[1] * t.scalar[1] + w[2] * t.scalar[2]) : t.color;
  const Vec3 light = shade(point, camera_);
  return t.edges ? Vec3(light * (1 - 0.55 * std::clamp(1.1 - edge_distance(t, x, y), 0.0, 1.0))) : light;
}

/// Blends a sample's layers from the nearest on.
void Tile::blend(std::size_t sample, double x, double y, Vec3& light, double& seen) const {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t layer = 0; layer < scene_.layer_opacity.size(); ++layer) {
    const Hit& hit = hits_[layer * sample_count() + sample];
    if (hit.triangle != nothing)
      order.emplace_back(-hit.inverse_depth * (1 + overlay_bias * static_cast<double>(layer)), layer);
  }
  std::sort(order.begin(), order.end());
  double through = 1;
  for (const auto& [depth, layer] : order) {
    const double opacity = scene_.layer_opacity[layer];
    light += through * opacity * look(hits_[layer * sample_count() + sample], x, y);
    through *= 1 - opacity;
    if (through == 0) break;
  }
  seen += 1 - through;
}

void Tile::resolve() {
  for (int py = 0; py < height_ / samples_; ++py)
    for (int px = 0; px < width_ / samples_; ++px) {
      Vec3 light = Vec3::Zero();
      double seen = 0, depth = 0;
      int solid = 0;
      for (int s = 0; s < samples_ * samples_; ++s) {
        const int row = py * samples_ + s / samples_, column = px * samples_ + s % samples_;
        const auto sample = static_cast<std::size_t>(row * width_ + column);
        blend(sample, sample_x(column), sample_y(row), light, seen);
        if (hits_[sample].triangle == nothing) continue;
        depth += 1 / hits_[sample].inverse_depth;
        ++solid;
      }
      const std::size_t pixel = static_cast<std::size_t>(top_ + py) * static_cast<std::size_t>(film_.width) +
                                static_cast<std::size_t>(left_ + px);
      film_.light[pixel] = light / (samples_ * samples_);
      film_.coverage[pixel] = static_cast<float>(seen / (samples_ * samples_));
      film_.depth[pixel] = solid == 0 ? 0.0f : static_cast<float>(depth / solid);
    }
}

}  // namespace

Film draw(const Scene& scene, const Camera& camera, int width, int height, int samples) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  Film film{width, height, std::vector<Vec3>(pixels, Vec3::Zero()), std::vector<float>(pixels),
            std::vector<float>(pixels)};
  const Bins bins = make_bins(scene, width, height);
  parallel_for(bins.triangles.size(), [&](std::size_t number) {
    if (bins.triangles[number].empty()) return;
    const int left = static_cast<int>(number) % bins.across * tile_size,
              top = static_cast<int>(number) / bins.across * tile_size;
    Tile tile(scene, camera, film, samples, left, top);
    for (const std::uint32_t triangle : bins.triangles[number]) tile.cover(triangle);
    tile.resolve();
  });
  return film;
}

}  // namespace calot::detail
