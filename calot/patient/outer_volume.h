// Inside this room only: the last per cent of a region's volume.
#pragma once
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// Moves the outer surface along its normals until each region that has much of its boundary there has its volume: flat
/// facets between vertices on a curved surface enclose less than the organ does, by per cents where facets are large.
/// Vertices move by a tenth of their shortest edge at most; a move that would take an angle out of the given range is
/// left out.
/// @param volumes  wanted, one a region, from region 1 [m³]
void fit_outer_volumes(TetMesh& mesh, const std::vector<double>& volumes, double min_dihedral, double max_dihedral);

}  // namespace calot::detail
