// The rigid motion nearest to a deformation.
#pragma once
#include <span>

#include "calot/contact/rigid_shape.h"

namespace calot {

/// The pose that takes `from` to `to` with the least sum of squared distances; as many points each, at least one. Where
/// they leave the rotation open (fewer than three points, or points in line) any of the best is given.
/// Source: [Kabsch1976].
Pose fit_rigid(std::span<const Vec3> from, std::span<const Vec3> to);

}  // namespace calot
