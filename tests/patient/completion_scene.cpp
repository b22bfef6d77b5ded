#include "tests/patient/completion_scene.h"

#include <algorithm>
#include <cmath>

#include "calot/patient/random.h"

namespace calot::test {
namespace {

constexpr double bed = 2.5, slab_bottom = 6;  // mm
const Vec3 mouth(-37.5, 0, -22), neck(-13, 0, -4);
constexpr double bile_x = -40, bile_low = -40, bile_high = 3;

double from_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - t * along).norm();
}

/// Between bile duct, cystic duct, gallbladder and liver, 9 mm thick.
bool in_triangle(const Vec3& p) {
  if (std::abs(p[1]) > 4.5 || p[0] < bile_x || p[2] > slab_bottom) return false;
  const double t = (p[0] - mouth[0]) / (neck[0] - mouth[0]);
  return t < 1.05 && p[2] > mouth[2] + t * (neck[2] - mouth[2]);
}

Eigen::Affine3d scene_to_world(bool oblique) {
  if (!oblique) return Eigen::Affine3d(Eigen::Scaling(1e-3));
  return Eigen::Translation3d(0.02, -0.11, 0.3) * Eigen::AngleAxisd(0.3, Vec3::UnitX()) *
         Eigen::AngleAxisd(-0.4, Vec3::UnitZ()) * Eigen::Scaling(1e-3);
}

double hounsfield(Structure s) {
  switch (s) {
    case Structure::liver:
      return 50;
    case Structure::hepatocystic_fat:
      return -80;
    case Structure::gallbladder_bed:
      return 10;
    case Structure::none:
      return 110;
    default:
      return 3;
  }
}

}  // namespace

Structure scene_truth(const Vec3& p) {
  if (from_segment(p, {bile_x, 0, bile_low}, {bile_x, 0, bile_high}) < scene_bile_radius)
    return Structure::common_bile_duct;
  if (p.norm() < scene_sac_radius) return Structure::gallbladder;
  if (from_segment(p, mouth, neck) < scene_cystic_radius) return Structure::cystic_duct;
  const bool in_rim = std::pow(p[0] / 45, 4) + std::pow(p[1] / 22, 4) < 1;
  if (in_rim && p[2] > slab_bottom && p[2] < 28 + 0.08 * p[0] + 0.05 * p[1])  // no wall along the voxels
    return p.norm() < scene_sac_radius + bed ? Structure::gallbladder_bed : Structure::liver;
  return in_triangle(p) ? Structure::hepatocystic_fat : Structure::none;
}

Vec3 to_scene(const Vec3& world, bool oblique) {
  return scene_to_world(oblique).inverse() * world;
}

Vec3 from_scene(const Vec3& mm, bool oblique) {
  return scene_to_world(oblique) * mm;
}

Scene make_scene(const Vec3& spacing_mm, bool oblique, const std::function<bool(Structure)>& keep) {
  const Vec3 low(-50, -26, -43.2), high(50, 26, 34);
  Scene scene;
  VoxelGrid& grid = scene.labels.grid;
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    grid.size[d] = static_cast<std::size_t>((high[axis] - low[axis]) / spacing_mm[axis]) + 1;
  }
  grid.to_world = scene_to_world(oblique) * Eigen::Translation3d(low) * Eigen::Scaling(spacing_mm);
  scene.ct.grid = grid;
  std::size_t v = 0;
  for (std::size_t k = 0; k < grid.size[2]; ++k)
    for (std::size_t j = 0; j < grid.size[1]; ++j)
      for (std::size_t i = 0; i < grid.size[0]; ++i, ++v) {
        const Vec3 at(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const Structure s = scene_truth(low + at.cwiseProduct(spacing_mm));
        scene.labels.voxels.push_back(keep(s) ? label_of(s) : Label{0});
        Random random(v);
        scene.ct.hounsfield.push_back(static_cast<std::int16_t>(std::lround(hounsfield(s) + 11 * random.normal())));
      }
  const auto line = [&](const char* name, std::vector<Vec3> points, double radius) {
    for (Vec3& p : points) p = from_scene(p, oblique);
    const std::vector<double> radii(points.size(), 1e-3 * radius);
    scene.lines.push_back({name, points, radii});
  };
  line("common bile duct", {{bile_x, 0, bile_low}, {bile_x, 0, mouth[2]}, {bile_x, 0, bile_high}}, scene_bile_radius);
  line("cystic duct", {neck, (neck + mouth) / 2, mouth}, scene_cystic_radius);
  return scene;
}

}  // namespace calot::test
