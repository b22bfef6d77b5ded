// What a blade destroys where cutting removes tissue: the tets that it crosses.
#pragma once
#include <span>
#include <vector>

#include "calot/cut/split.h"

namespace calot {

/// The tets with vertices strictly on both sides of the swept patch's plane that have an edge crossed within the patch,
/// ascending. For cuts by removal; `split` parts the mesh without loss.
/// @param current  n, where each vertex is while the blade passes [m]
/// Throws InputError where sizes don't fit.
std::vector<TetId> crossed_tets(const TetMesh& mesh, std::span<const Vec3> current, const Sweep& sweep);

}  // namespace calot
