#include "calot/image/volume.h"

#include <cmath>
#include <cstdio>

#include "calot/base/error.h"

namespace calot {
namespace {

std::string text(const char* format, auto... values) {
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

/// Largest distance [voxels of a] between where the two affines put a corner of the grid.
double corner_distance(const VoxelGrid& a, const Eigen::Affine3d& other) {
  const Eigen::Affine3d to_a = a.to_world.inverse() * other;
  double worst = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at(corner & 1 ? static_cast<double>(a.size[0] - 1) : 0,
                             corner & 2 ? static_cast<double>(a.size[1] - 1) : 0,
                             corner & 4 ? static_cast<double>(a.size[2] - 1) : 0);
    worst = std::max(worst, (to_a * at - at).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

void check_axes(const Eigen::Affine3d& to_world, const std::string& where) {
  const Eigen::Matrix3d axes = to_world.linear();
  const Eigen::Vector3d lengths = axes.colwise().norm();
  if (!to_world.matrix().allFinite() || lengths.minCoeff() <= 0 || lengths.maxCoeff() > 1)
    throw InputError(where, "its orientation matrix has axes of no or absurd length",
                     "export the file again with its orientation");
  const Eigen::Matrix3d unit = axes * lengths.cwiseInverse().asDiagonal();
  if (std::abs(unit.determinant()) < 1e-3)
    throw InputError(where, "its orientation matrix is singular", "export the file again with its orientation");
  if (((unit.transpose() * unit) - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-3)
    throw InputError(where, "its voxel axes are sheared, not at right angles", "resample it onto a rectangular grid");
}

std::string grid_difference(const VoxelGrid& a, const VoxelGrid& b) {
  if (a.size != b.size)
    return text("%zu x %zu x %zu voxels against %zu x %zu x %zu", a.size[0], a.size[1], a.size[2], b.size[0], b.size[1],
                b.size[2]);
  const Eigen::Vector3d s = 1e3 * a.spacing(), t = 1e3 * b.spacing();
  if ((s - t).cwiseQuotient(s).cwiseAbs().maxCoeff() > 1e-3)
    return text("spacing %.4g x %.4g x %.4g mm against %.4g x %.4g x %.4g mm", s[0], s[1], s[2], t[0], t[1], t[2]);
  if (corner_distance(a, b.to_world) <= 0.01) return {};
  Eigen::Affine3d shifted = b.to_world;
  shifted.translation() = a.to_world.translation();
  if (corner_distance(a, shifted) > 0.01) return "their axes are turned against each other";
  const Eigen::Vector3d moved = 1e9 * (b.to_world.translation() - a.to_world.translation());
  const Eigen::Vector3d d = 1e-6 * (moved.array().round() + 0.0).matrix();  // no rounding errors, no −0
  return text("the second is moved by (%.3g, %.3g, %.3g) mm", d[0], d[1], d[2]);
}

std::optional<std::array<std::ptrdiff_t, 3>> offset_in(const VoxelGrid& whole, const VoxelGrid& part) {
  const Eigen::Vector3d first = whole.to_world.inverse() * part.to_world.translation();
  VoxelGrid moved = part;
  std::array<std::ptrdiff_t, 3> offset{};
  for (int d = 0; d < 3; ++d) {
    const double at = std::round(first[d]), room = static_cast<double>(whole.size[static_cast<std::size_t>(d)]);
    if (!(std::abs(first[d] - at) <= 0.01) ||
        !(at >= 0 && at + static_cast<double>(part.size[static_cast<std::size_t>(d)]) <= room))
      return {};
    offset[static_cast<std::size_t>(d)] = static_cast<std::ptrdiff_t>(at);
  }
  moved.to_world = whole.to_world * Eigen::Translation3d(first.array().round().matrix());
  if (!grid_difference(moved, part).empty()) return {};
  return offset;
}

}  // namespace calot
