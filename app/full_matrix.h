// The whole matrix used as it stands, without the exact machinery: for the paper's update and for files from elsewhere.
#pragma once
#include <filesystem>

#include "calot/compliance/compliance.h"

namespace calot {

/// Reads C.h5 as a whole matrix, whichever form it is stored in.
FullCompliance load_whole_matrix(const std::filesystem::path& path, const Model& model);

/// ‖Â(Cz) − z‖/‖z‖ over the free dofs of vertices with tets, z pseudo-random there and zero elsewhere: 0 for the
/// inverse.
double probe_residual(const FullCompliance& compliance, const Model& model);

}  // namespace calot
