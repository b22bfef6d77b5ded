// Blocks and tubes as one tetrahedral mesh, for scenes without a patient.
#pragma once
#include <vector>

#include "calot/scene/scene.h"

namespace calot {

struct ShapeMesh {
  TetMesh mesh;  ///< each shape a part of its own; regions by name: a patient's numbers, else from 100 on
  std::vector<std::uint8_t> fixed;  ///< n flags
};

/// Throws InputError naming the shape where it would have no volume, fold onto itself, or make too many tets.
ShapeMesh mesh_of_shapes(const std::vector<BlockShape>& blocks, const std::vector<TubeShape>& tubes);

}  // namespace calot
