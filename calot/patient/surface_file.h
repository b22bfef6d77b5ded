// Inside this room only: surfaces for the renderer.
#pragma once
#include <filesystem>

#include "calot/mesh/surface_parameters.h"

namespace calot::detail {

/// Writes a binary .ply: x y z [mm, double], the rest shape's normals nx ny nz and triplanar weights wx wy wz (float)
/// of every vertex, and the region (int) of every triangle.
void write_textured_surface(const std::filesystem::path& path, const TexturedSurface& textured);

}  // namespace calot::detail
