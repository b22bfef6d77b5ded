// What the haptic loop knows of the world: the last constraint set of one instrument, immutable once published.
#pragma once
#include <cstdint>

#include "calot/contact/friction.h"
#include "calot/contact/rigid_shape.h"

namespace calot {

using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< force, then torque; or displacement, then rotation vector
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Tissue as seen from one instrument, linear around the pose it was computed for. A twist is a displacement of
/// `pose.position` [m] and a rotation vector about it [rad], both along world axes.
struct HapticConstraints {
  std::uint64_t step = 0;   ///< of the world
  Pose pose;                ///< of the instrument then
  FrictionProblem problem;  ///< the contacts with this instrument; its free motion q is that at `pose`
  Eigen::Matrix<double, Eigen::Dynamic, 6> motion;  ///< 3k×6: q at another pose is q + motion · twist
  Eigen::Matrix<double, 6, Eigen::Dynamic>
      wrench;                                ///< 6×3k: force and torque about pose.position on the instrument from λ
  Vector6 held_wrench = Vector6::Zero();     ///< of what the jaws hold, on the instrument, at `pose`
  Matrix6 held_stiffness = Matrix6::Zero();  ///< at another pose it is held_wrench − held_stiffness · twist
};

}  // namespace calot
