// The whole matrix used as it stands, without the exact machinery: for the paper's update and for files from elsewhere.
#pragma once
#include "calot/compliance/compliance.h"

namespace calot {

/// u = C f [m], not refined. Throws InputError for a vertex out of range.
Displacements multiply(const FullCompliance& compliance, const std::vector<PointForce>& forces);

/// ‖Â(Cz) − z‖/‖z‖ over the free dofs of vertices with tets, z pseudo-random there and zero elsewhere: 0 for the
/// inverse.
double probe_residual(const FullCompliance& compliance, const Model& model);

}  // namespace calot
