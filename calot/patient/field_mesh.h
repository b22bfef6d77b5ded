// The mesh of an operating field: fine where the surgeon cuts, coarse where the liver only lends its weight.
#pragma once
#include "calot/patient/mesher.h"
#include "calot/patient/structure.h"

namespace calot {

/// Mesher options for an anatomy.
/// @param labels  Structure numbers; all that have voxels are meshed
/// @param tets    how many, met within 4 % from below: never more; 4000 … 2000000
MesherOptions field_mesh_options(const LabelMap& labels, std::size_t tets);

/// Edge length [m] that a structure gets in a mesh of about 20 000 tets; others scale all alike.
double usual_edge(Structure s);

}  // namespace calot
