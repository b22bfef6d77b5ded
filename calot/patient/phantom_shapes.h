// Signed distances [m] of the bodies that a phantom is made of: negative inside.
#pragma once
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "calot/patient/sweep.h"

namespace calot {

/// The smaller of two, rounded where they differ by less than `blend`; of two bodies: their union with a filled seam.
double smooth_min(double a, double b, double blend);
/// The larger of two, rounded likewise; of two bodies: their intersection with a rounded edge.
double smooth_max(double a, double b, double blend);

/// |x/a|^power + |y/b|^power + |z/c|^power = 1: an ellipsoid at power 2, a box with round edges above.
struct Superellipsoid {
  Vec3 centre, radii;
  double power = 2;
  /// First order: exact at the surface, of the right sign everywhere.
  [[nodiscard]] double distance(const Vec3& p) const;
};

double distance_to_triangle(const Vec3& p, const std::array<Vec3, 3>& corners);
/// Distance from the nearest ball's surface, negative inside.
double distance_to(const BallChain& balls, const Vec3& p);
/// Distance from a tube's wall.
double distance_to_tube(const Curve& curve, double radius, const Vec3& p);

/// Part of one slice of a grid: columns and rows first … last−1.
struct Window {
  std::array<std::size_t, 2> first{}, last{};
  [[nodiscard]] bool empty() const { return first[0] >= last[0] || first[1] >= last[1]; }
  [[nodiscard]] std::size_t width() const { return last[0] - first[0]; }
  [[nodiscard]] std::size_t count() const { return empty() ? 0 : width() * (last[1] - first[1]); }
};
/// The voxels of slice k whose centres lie in the box; the grid must be axis-parallel.
Window window_of(const VoxelGrid& grid, std::size_t k, const Eigen::AlignedBox3d& box);
/// The grid that consists of the window's columns and rows and of all slices.
VoxelGrid grid_of(const VoxelGrid& grid, const Window& window);

/// A function of space kept as samples on a cubic lattice, linear between them: evaluating an organ of many smooth
/// parts once each 2 mm instead of at each voxel. Off by step²/8 times the curvature, 0.05 mm at a bend of radius 10
/// mm.
class SampledField {
 public:
  SampledField() = default;
  SampledField(const Eigen::AlignedBox3d& box, double step, const std::function<double(const Vec3&)>& f);

  [[nodiscard]] double at(const Vec3& p) const;  ///< clamped to the box
  /// Values at the window's voxels in slice k, row by row.
  void fill(const VoxelGrid& grid, std::size_t k, const Window& window, std::span<float> values) const;
  [[nodiscard]] const Eigen::AlignedBox3d& box() const { return box_; }

  /// Where the function is negative: extents along x, y, z, and volume.
  struct Measure {
    Eigen::AlignedBox3d extent;
    double volume = 0;
  };
  [[nodiscard]] Measure measure_inside() const;
  [[nodiscard]] const std::array<std::size_t, 3>& size() const { return size_; }
  [[nodiscard]] float value(std::size_t i, std::size_t j, std::size_t k) const {
    return values_[i + size_[0] * (j + size_[1] * k)];
  }
  [[nodiscard]] Vec3 place(std::size_t i, std::size_t j, std::size_t k) const {
    return box_.min() + step_ * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
  }

 private:
  Eigen::AlignedBox3d box_;
  double step_ = 1;
  std::array<std::size_t, 3> size_{};
  std::vector<float> values_;
};

}  // namespace calot
