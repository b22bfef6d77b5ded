// Inside this room only. Closed surfaces made into voxels.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calot/image/volume.h"
#include "calot/mesh/surface.h"

namespace calot {

struct SurfaceVoxels {
  std::vector<std::uint8_t> inside;  ///< grid.count(), 1 where the centre lies inside
  bool cut = false;                  ///< the surface reaches beyond the grid
};

/// The voxels whose centres lie inside a surface: a line along i through each (j, k) is inside after an odd number of
/// crossings. Vertices are rounded to 2⁻¹⁶ voxel and everything after that is exact, so a centre on a face, an edge or
/// a vertex is settled alike for every line: on a face, the side of larger coordinates is out. Triangles may wind
/// either way. Throws InputError, beginning with `where`, for a surface that isn't closed (an edge with an odd number
/// of triangles) or lies outside the grid (says where both are).
SurfaceVoxels voxels_inside(const Surface& surface, const VoxelGrid& grid, const std::string& where);

}  // namespace calot
