// Linear springs on tissue vertices: how jaws, clips and ligaments hold tissue. The motion takes them in implicitly.
#pragma once
#include "calot/fem/block_matrix.h"

namespace calot {

/// Pulls `vertex` towards `anchor`, or, where `other` is valid, towards x_other + anchor:
/// f = −stiffness (x_vertex − target) − damping (v_vertex − v_target); `other` feels the opposite.
struct Spring {
  VertexId vertex, other;         ///< `other` is none for a spring to a place
  Vec3 anchor = Vec3::Zero();     ///< place at the end of the step, or offset from `other` [m]
  Vec3 velocity = Vec3::Zero();   ///< of the target [m/s]
  Mat3 stiffness = Mat3::Zero();  ///< symmetric positive semidefinite [N/m]
  double damping = 0;             ///< ≥ 0, along all directions of `stiffness`, as a share of it [s]
};

}  // namespace calot
