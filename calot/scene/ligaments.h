// Inside this room only: bodies that hang on ligaments instead of being held in place.
#pragma once
#include <set>
#include <vector>

#include "calot/fem/model.h"
#include "calot/sim/spring.h"

namespace calot::detail {

/// How far a body moves under a force as large as its own weight [m]; assumed: a liver of 1.3 kg then hangs on 320 N/m,
/// so that a few newtons lift its edge by 30 mm.
inline constexpr double ligament_give = 0.04;
/// Of the body's swinging on them, as a share of the critical damping; assumed: it comes to rest at once.
inline constexpr double ligament_damping = 0.7;

/// Springs from vertices to where they are, in all directions alike, equally stiff for each body, which is all that
/// hangs together. They carry its weight, so that as a rigid whole it stays where the model has it: each is stretched
/// by a shift and a small turn common to all, found from the balance of forces and torques.
/// @param held  free vertices, ascending
/// @param carried  regions whose weight their surroundings carry
std::vector<Spring> hang(const Model& model, const std::vector<VertexId>& held, const std::set<std::int32_t>& carried,
                         const Vec3& gravity);

}  // namespace calot::detail
