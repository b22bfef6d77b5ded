// Inside this room only: whether vertices hold a part against turning.
#pragma once
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// Three points off one line hold a part; fewer, or a row of them, leave a hinge.
bool spans_an_area(const TetMesh& mesh, const std::vector<VertexId>& vertices);

}  // namespace calot::detail
