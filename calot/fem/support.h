// Whether every part of a static model is held.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// The part of a static model that nothing holds, and how it can move, in one sentence; empty when all is held.
/// Face-connected parts are taken as rigid bodies joined at the vertices they share and held at their fixed vertices; a
/// velocity that no joint resists is a free motion. Nothing is read off a factorisation, which often succeeds on a
/// hinge.
/// @param fixed  n flags
std::string unsupported_part(const TetMesh& mesh, const std::vector<std::uint8_t>& fixed);

}  // namespace calot
