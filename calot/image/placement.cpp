#include "calot/image/placement.h"

#include <cmath>

#include "calot/base/parallel.h"

namespace calot {
namespace {

std::ptrdiff_t stride(const VoxelGrid& grid, Eigen::Index axis) {
  const auto n = [&](std::size_t d) { return static_cast<std::ptrdiff_t>(grid.size[d]); };
  return axis == 0 ? 1 : axis == 1 ? n(0) : n(0) * n(1);
}

Eigen::Vector3d corner_of(const VoxelGrid& grid, int corner) {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int d = 0; d < 3; ++d)
    if (corner >> d & 1) at[d] = static_cast<double>(grid.size[static_cast<std::size_t>(d)] - 1);
  return at;
}

/// The nearest map that takes axes to axes; empty where two axes go to one.
std::optional<Eigen::Affine3d> nearest_axis_map(const Eigen::Affine3d& map) {
  Eigen::Affine3d nearest = Eigen::Affine3d::Identity();
  nearest.linear() = map.linear().array().round().matrix();
  nearest.translation() = map.translation().array().round().matrix();
  const Eigen::Matrix3d squares = nearest.linear().cwiseAbs2();
  if (squares.rowwise().sum() != Eigen::Vector3d::Ones()) return {};
  if (squares.colwise().sum().transpose() != Eigen::Vector3d::Ones()) return {};
  return nearest;
}

}  // namespace

bool Placement::is_identity(const VoxelGrid& whole, const VoxelGrid& part) const {
  if (whole.size != part.size || first != 0) return false;
  for (int d = 0; d < 3; ++d)
    if (part.size[static_cast<std::size_t>(d)] > 1 && step[static_cast<std::size_t>(d)] != stride(whole, d))
      return false;
  return true;
}

std::optional<Placement> placement_in(const VoxelGrid& whole, const VoxelGrid& part) {
  const Eigen::Affine3d map = whole.to_world.inverse() * part.to_world;
  const auto nearest = nearest_axis_map(map);
  if (!nearest) return {};
  Placement placement;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at = corner_of(part, corner), here = *nearest * at;
    placement.off = std::max(placement.off, (map * at - here).cwiseAbs().maxCoeff());
    for (int d = 0; d < 3; ++d)
      if (!(here[d] >= 0 && here[d] < static_cast<double>(whole.size[static_cast<std::size_t>(d)]))) return {};
  }
  if (!(placement.off <= 0.1)) return {};
  for (int to = 0; to < 3; ++to) {
    placement.first += static_cast<std::ptrdiff_t>(nearest->translation()[to]) * stride(whole, to);
    for (int d = 0; d < 3; ++d)
      placement.step[static_cast<std::size_t>(d)] +=
          static_cast<std::ptrdiff_t>(nearest->linear()(to, d)) * stride(whole, to);
  }
  return placement;
}

template <class T>
std::vector<T> resampled(const std::vector<T>& values, const VoxelGrid& from, const VoxelGrid& to) {
  const Eigen::Affine3d map = from.to_world.inverse() * to.to_world;
  const Eigen::Array3d size(static_cast<double>(from.size[0]), static_cast<double>(from.size[1]),
                            static_cast<double>(from.size[2]));
  std::vector<T> result(to.count());
  parallel_for(to.size[2], [&](std::size_t k) {
    std::size_t v = to.index(0, 0, k);
    for (std::size_t j = 0; j < to.size[1]; ++j)
      for (std::size_t i = 0; i < to.size[0]; ++i, ++v) {
        const Eigen::Vector3d here(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const Eigen::Array3d at = ((map * here).array() + 0.5).floor();
        if ((at >= 0).all() && (at < size).all())
          result[v] = values[from.index(static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]),
                                        static_cast<std::size_t>(at[2]))];
      }
  });
  return result;
}

template std::vector<std::uint8_t> resampled(const std::vector<std::uint8_t>&, const VoxelGrid&, const VoxelGrid&);
template std::vector<std::uint16_t> resampled(const std::vector<std::uint16_t>&, const VoxelGrid&, const VoxelGrid&);

}  // namespace calot
