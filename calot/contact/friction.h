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
  int iterations = 200;     ///< at most, sweeps and Newton steps together
};

struct FrictionSolution {
  Eigen::VectorXd forces;     ///< λ, 3k [N]
  double residual = 0;        ///< `friction_residual` of `forces`
  int iterations = 0;         ///< sweeps and Newton steps
  int newton_steps = 0;       ///< how many of them were Newton's
  std::size_t immovable = 0;  ///< contacts whose own block of W is zero: nothing can move there, no force is given
  bool converged = false;     ///< residual ≤ tolerance
};

/// Solves from `start` (3k forces, or empty). Block Gauss–Seidel, each contact solved exactly; where it is slow,
/// semi-smooth Newton on all contacts. Deterministic; one thread. If it doesn't converge, the best forces met.
/// Values that aren't finite: zero forces, an infinite residual. Throws InputError where the sizes don't fit or μ < 0.
/// Source: [Jean1999], [Alart1991], [Acary2018]; docs/simulation.md.
FrictionSolution solve_friction(const FrictionProblem& problem, std::span<const double> start,
                                const FrictionOptions& options);

/// How far λ is from a solution, without unit: the largest natural map of a contact,
/// ‖λ − P(λ − ũ/w)‖·w with P the projection onto its friction cone, ũ = u + (μ‖u_t‖, 0, 0), w a third of the trace of
/// its block of W, divided by the largest free motion ‖q‖ of the contacts that close (q_n < 0). Zero where none closes
/// and λ = 0. Immovable contacts don't count. Source: [DeSaxce1998], [Acary2018].
double friction_residual(const FrictionProblem& problem, const Eigen::VectorXd& forces);

/// One contact alone: λ with u = W λ + q that fulfils the conditions above, exactly. W is definite.
Eigen::Vector3d solve_one_contact(const Eigen::Matrix3d& delassus, const Eigen::Vector3d& free_motion, double friction);

}  // namespace calot
