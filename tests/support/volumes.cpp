#include "tests/support/volumes.h"

namespace calot::test {

VoxelGrid oblique_grid(std::array<std::size_t, 3> size, const Eigen::Vector3d& spacing) {
  VoxelGrid grid;
  grid.size = size;
  grid.to_world = Eigen::Translation3d(-0.031, 0.0425, 0.1175) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()) *
                  Eigen::Scaling(spacing);
  return grid;
}

LabelMap map_of(const VoxelGrid& grid, const std::function<Label(int, int, int)>& label) {
  LabelMap map;
  map.grid = grid;
  map.voxels.resize(grid.count());
  for (std::size_t k = 0; k < grid.size[2]; ++k)
    for (std::size_t j = 0; j < grid.size[1]; ++j)
      for (std::size_t i = 0; i < grid.size[0]; ++i)
        map.voxels[grid.index(i, j, k)] = label(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k));
  return map;
}

LabelMap half_balls(int radius, const VoxelGrid& like) {
  VoxelGrid grid = like;
  const int centre = radius + 1;
  grid.size.fill(static_cast<std::size_t>(2 * centre + 1));
  LabelMap map = map_of(grid, [&](int i, int j, int k) -> Label {
    const int x = i - centre, y = j - centre, z = k - centre;
    if (x * x + y * y + z * z > radius * radius) return 0;
    return x < 0 ? 1 : 2;
  });
  map.names = {{1, "left half"}, {2, "right half"}};
  return map;
}

}  // namespace calot::test
