// Inside this room only: which tets a hot instrument touches, and how its power is shared among them.
#pragma once
#include <span>
#include <vector>

#include "calot/sim/heat.h"

namespace calot::detail {

/// Tets with a part within `radius` of `place`, ascending; empty where there is none. Power per volume falls off as
/// 1 − (r/radius)² and goes with `conductance` (m, ≥ 0). The integral is taken at 20 points a tet; where none of them
/// is near enough, the tet nearest to the place takes all at the point nearest to it.
void heated_tets(const TetMesh& mesh, std::span<const Vec3> positions, const Vec3& place, double radius,
                 std::span<const double> conductance, std::vector<HeatedTet>& out);

}  // namespace calot::detail
