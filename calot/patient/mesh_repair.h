// Small repairs of a fresh mesh, so that every region is one piece and the outside a closed surface.
#pragma once
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Gives the tets of every region's smaller face-connected parts to the region they share most faces with (dropped
/// where there is none), drops tets that make the outer surface non-manifold, and unused vertices. Regions count
/// from 1.
/// @return what was done, in words
std::vector<std::string> repair_regions(TetMesh& mesh, std::size_t regions);

}  // namespace calot
