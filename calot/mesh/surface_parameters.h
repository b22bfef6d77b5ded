// What a renderer needs of a surface beside its triangles, kept right through cuts.
#pragma once
#include <cstdint>
#include <vector>

#include "calot/mesh/surface.h"
#include "calot/mesh/topology_edit.h"

namespace calot {

/// Triplanar parameters: a texture is projected along the three axes of the rest shape and blended by the rest normal.
/// They belong to places in the rest shape, not to a chart of the skin, so a face that a cut lays open has them at
/// once.
struct TexturedSurface {
  Surface surface;                    ///< of one region, or of all (outer boundary)
  std::vector<Vec3> rest;             ///< n, rest positions: the texture coordinates [m]
  std::vector<Vec3> normals;          ///< n, unit, of the rest shape
  std::vector<Vec3> weights;          ///< n, triplanar weights ≥ 0 that sum to 1
  std::vector<std::uint8_t> exposed;  ///< k, 1 where an edit laid the face open: the renderer shows the inside's look
};

/// @param region     which region's boundary; 0: the outer boundary of all
/// @param sharpness  exponent k of the weights |n|^k, ≥ 1
/// Throws InputError for another sharpness.
TexturedSurface textured_surface(const TetMesh& mesh, std::int32_t region, double sharpness);

/// The same surface after an edit. Vertices that stay on it keep rest position, normal and weights bit for bit; a split
/// vertex hands its own to its copy; a vertex that an edit moves along the surface, or puts on an edge or face of it,
/// takes them from there by interpolation; what lies open for the first time gets them from the rest shape. A face is
/// exposed when it neither was on the surface before nor is a piece of one that was; pieces inherit the flag. Where two
/// regions come apart along the face between them, that face was on the surface of each and stays unflagged.
/// @param before  of the mesh before the edit
/// @param mesh    after it
TexturedSurface after_edit(const TexturedSurface& before, const TetMesh& mesh, const Remap& remap, std::int32_t region,
                           double sharpness);

}  // namespace calot
