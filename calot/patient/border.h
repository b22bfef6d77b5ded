// Where the volume's border cuts structures.
#pragma once
#include <set>

#include "calot/patient/completion.h"

namespace calot {

/// "upper (superior)", "left" …: the side of the body that a face of the grid looks to.
std::string side_name(const VoxelGrid& grid, int axis, bool upper);

/// The faces of the volume that cut structures: the liver, fat, the bed. Throws InputError, naming structure and face,
/// where one cuts a structure that must be whole: the gallbladder with its wall, ducts and arteries.
/// @param redrawn  structures whose label doesn't matter, because a centreline replaces it
std::vector<BorderCut> border_cuts(const LabelMap& labels, const std::set<Structure>& redrawn);

}  // namespace calot
