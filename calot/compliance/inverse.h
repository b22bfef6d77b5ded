// The whole inverse from the sparse factor.
#pragma once
#include "calot/compliance/sparse_factor.h"

namespace calot {

/// Writes Â⁻¹, rows and columns in the factor's order, into `inverse` (N×N, N = factor.size(), both triangles).
/// Goes through the supernodes s from the root, r its rows below, H = L_rs L_ss⁻¹: C(later, s) = −C(later, r) H,
/// C(s, s) = L_ss⁻ᵀ L_ss⁻¹ − Hᵀ C(r, s). The result is exactly symmetric and independent of the number of threads.
/// Source: docs/math.md §3; the recurrence is Takahashi's (1973), taken over all entries.
void invert(const SparseFactor& factor, double* inverse, Progress* progress = nullptr);

}  // namespace calot
