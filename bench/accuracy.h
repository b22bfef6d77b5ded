// Errors as DESIGN counts them.
#pragma once
#include "calot/compliance/compliance.h"

namespace calot::bench {

/// The worst column of ‖c − c*‖∞/‖c*‖∞, both refined.
double worst_column(const Compliance& compliance, const Compliance& reference, const std::vector<DofId>& dofs);
/// The same for a block C_JJ that was answered at once.
double worst_block(const Eigen::MatrixXd& block, const Compliance& reference, const std::vector<DofId>& dofs);
/// max(1e-9, 10 ε κ₁) of the reference.
double error_bound(const Compliance& reference);

}  // namespace calot::bench
