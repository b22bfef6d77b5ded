// A constraint set made ready for solving against one pose after the other.
#pragma once
#include "calot/sim/haptic_constraints.h"

namespace calot {

/// The spring between the device and the simulated tool.
struct Coupling {
  double stiffness = 1000;         ///< > 0 [N/m]
  double turning_stiffness = 1.0;  ///< > 0 [N·m/rad]
};

/// Where the tool stays while the device pulls at it through the coupling: a massless tool in balance between the
/// coupling, what its jaws hold, and the contacts, which solve the friction problem with the tool's give added,
///   (W + M A⁻¹ Wr) λ + q + M A⁻¹ (S d + w),   A = S + held stiffness,   t = A⁻¹ (S d + w + Wr λ),
/// d and t the twists of device and tool from the set's pose, S the coupling, M and Wr the set's motion and wrench.
/// Source: docs/simulation.md, "Haptics".
class HapticContact {
 public:
  /// Nothing touches.
  void clear();
  /// @return false, and nothing touches, where sizes or numbers are wrong or the balance has no stable solution
  bool take(const HapticConstraints& set, const Coupling& coupling);

  struct Answer {
    Vector6 offset = Vector6::Zero();  ///< twist from the device to the tool; 0.1 m and 1.5 rad at most
    double residual = 0;               ///< of the friction problem, see `friction_residual`
  };
  /// At most `iterations` from the last solution of this set. Every force stays in its cone, converged or not.
  Answer solve(const Pose& tool_wanted, int iterations);

  [[nodiscard]] const Eigen::VectorXd& forces() const { return forces_; }  ///< λ, 3k [N]
  [[nodiscard]] std::size_t size() const { return problem_.size(); }

 private:
  Pose pose_;
  Matrix6 stiffness_ = Matrix6::Zero();  // S
  Matrix6 give_ = Matrix6::Zero();       // A⁻¹
  Vector6 held_ = Vector6::Zero();
  bool empty_ = true;
  FrictionProblem problem_;                                        // with the tool's give
  Eigen::VectorXd free_;                                           // q
  Eigen::Matrix<double, Eigen::Dynamic, 6> motion_, motion_give_;  // M, M A⁻¹
  Eigen::Matrix<double, 6, Eigen::Dynamic> wrench_;
  Eigen::VectorXd forces_;
};

}  // namespace calot
