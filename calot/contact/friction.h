// Coulomb friction as a complementarity problem on the Delassus operator W = J C Jᵀ.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

namespace calot {

/// k contacts, three rows each: normal, then two tangents, all orthonormal.
/// u = W λ + q; 0 ≤ λ_n ⊥ u_n ≥ 0 (u_n is the gap at the step's end), ‖λ_t‖ ≤ μ λ_n, and λ_t opposes u_t, of full
/// size where the contact slides.
struct FrictionProblem {
  Eigen::MatrixXd delassus;      ///< W, 3k×3k, symmetric positive semidefinite [m/N]
  Eigen::VectorXd free_motion;   ///< q, 3k [m]
  std::vector<double> friction;  ///< μ ≥ 0, k
  [[nodiscard]] std::size_t size() const { return friction.size(); }
};

struct FrictionOptions {
  double tolerance = 1e-6;  ///< of the residual
  int iterations = 200;     ///< at most
};

struct FrictionSolution {
  Eigen::VectorXd forces;  ///< λ, 3k [N]
  double residual = 0;     ///< largest violation of the conditions, relative; see `friction_residual`
  int iterations = 0;
  bool converged = false;
};

/// Solves from `start` (3k, or empty). Deterministic; one thread.
FrictionSolution solve_friction(const FrictionProblem& problem, std::span<const double> start,
                                const FrictionOptions& options);

/// How far λ is from a solution, without unit: the natural map of the second-order cones, scaled by the problem's size.
double friction_residual(const FrictionProblem& problem, const Eigen::VectorXd& forces);

}  // namespace calot
