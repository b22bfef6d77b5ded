#include "calot/contact/friction.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calot/base/error.h"

namespace calot {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

void check_sizes(const FrictionProblem& problem, std::size_t start) {
  const auto rows = static_cast<Index>(3 * problem.size());
  if (problem.delassus.rows() != rows || problem.delassus.cols() != rows || problem.free_motion.size() != rows)
    throw InputError("friction problem",
                     "W and q don't have three rows for each of the " + std::to_string(problem.size()) + " contacts");
  if (start != 0 && start != 3 * problem.size())
    throw InputError(
        "friction problem",
        "the start has " + std::to_string(start) + " values for " + std::to_string(problem.size()) + " contacts",
        "give three for each contact, or none");
  for (const double mu : problem.friction)
    if (mu < 0) throw InputError("friction problem", "a coefficient of friction is negative");
}

/// The nearest point of the cone ‖t‖ ≤ μ n.
Vector3d onto_cone(const Vector3d& x, double mu) {
  const double tangent = x.tail<2>().norm();
  if (tangent <= mu * x(0)) return x;
  if (mu * tangent <= -x(0)) return Vector3d::Zero();
  const double normal = (x(0) + mu * tangent) / (1 + mu * mu), scale = tangent > 0 ? mu * normal / tangent : 0;
  return {normal, scale * x(1), scale * x(2)};
}

/// What the sweeps and Newton's steps share: the forces, the motion they cause, and how wrong they are.
class Solver {
 public:
  explicit Solver(const FrictionProblem& problem)
      : p_(problem), k_(static_cast<Index>(problem.size())), size_(problem.size()), block_(problem.size()) {
    double closing = 0;
    for (Index i = 0; i < k_; ++i) {
      size_[i] = p_.delassus.block<3, 3>(3 * i, 3 * i).trace() / 3;
      if (p_.free_motion(3 * i) < 0) closing = std::max(closing, p_.free_motion.segment<3>(3 * i).norm());
    }
    scale_ = closing;
    largest_ = k_ > 0 ? *std::max_element(size_.begin(), size_.end()) : 0;
    for (Index i = 0; i < k_; ++i) {
      block_[i] = p_.delassus.block<3, 3>(3 * i, 3 * i);
      block_[i].diagonal().array() += 1e-13 * size_[i];  // definite, so that it can be inverted
    }
  }

  [[nodiscard]] bool movable(Index i) const { return size_[i] > 1e-14 * largest_; }
  [[nodiscard]] std::size_t immovable() const {
    std::size_t count = 0;
    for (Index i = 0; i < k_; ++i) count += movable(i) ? 0 : 1;
    return count;
  }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] const VectorXd& forces() const { return forces_; }

  void take_forces(const VectorXd& forces) {
    forces_ = forces;
    motion_.noalias() = p_.delassus * forces_;
    motion_ += p_.free_motion;
  }
  /// The same, each force moved to the nearest that friction allows.
  void take_allowed(VectorXd forces) {
    for (Index i = 0; i < k_; ++i) {
      const Vector3d allowed = onto_cone(forces.segment<3>(3 * i), p_.friction[i]);
      forces.segment<3>(3 * i) = movable(i) ? allowed : Vector3d(Vector3d::Zero());
    }
    take_forces(forces);
  }

  /// The natural map of contact i, as a motion [m].
  [[nodiscard]] double violation(Index i) const {
    if (!movable(i)) return 0;
    const Vector3d force = forces_.segment<3>(3 * i);
    Vector3d shifted = motion_.segment<3>(3 * i);
    shifted(0) += p_.friction[i] * shifted.tail<2>().norm();
    return size_[i] * (force - onto_cone(force - shifted / size_[i], p_.friction[i])).norm();
  }

  [[nodiscard]] double residual() const {
    double worst = 0;
    for (Index i = 0; i < k_; ++i) {
      const double v = violation(i);
      if (!(v <= worst)) worst = v;
    }
    if (worst == 0) return 0;
    return scale_ > 0 && std::isfinite(worst) ? worst / scale_ : std::numeric_limits<double>::infinity();
  }

  void sweep() {
    for (Index i = 0; i < k_; ++i) {
      if (!movable(i)) continue;
      const Vector3d before = forces_.segment<3>(3 * i);
      const Vector3d free = motion_.segment<3>(3 * i) - block_[i] * before;
      const Vector3d change = solve_one_contact(block_[i], free, p_.friction[i]) - before;
      if (change.isZero(0)) continue;
      forces_.segment<3>(3 * i) += change;
      motion_.noalias() += change(0) * p_.delassus.col(3 * i);
      motion_.noalias() += change(1) * p_.delassus.col(3 * i + 1);
      motion_.noalias() += change(2) * p_.delassus.col(3 * i + 2);
    }
  }

  /// All violations together.
  [[nodiscard]] double merit() const {
    double sum = 0;
    for (Index i = 0; i < k_; ++i) {
      const double v = violation(i);
      sum += v * v;
    }
    return std::sqrt(sum);
  }
  bool newton_step();

 private:
  /// Three rows of Newton's system: what must vanish at contact i, and its derivative by the active contacts' forces.
  void linearise(Index i, Index row, const std::vector<Index>& active);

  const FrictionProblem& p_;
  Index k_;
  double scale_ = 0, largest_ = 0;
  std::vector<double> size_;     // k, a third of the trace of each block of W
  std::vector<Matrix3d> block_;  // k, blocks of W on the diagonal
  VectorXd forces_, motion_;     // λ, u = Wλ + q
  MatrixXd jacobian_;
  VectorXd value_;
};

void Solver::linearise(Index i, Index row, const std::vector<Index>& active) {
  const Vector3d force = forces_.segment<3>(3 * i), motion = motion_.segment<3>(3 * i);
  const double mu = p_.friction[i], w = size_[i];
  // A little of the identity keeps W definite where contacts are redundant; as the step starts from the present
  // forces, the solution stays the same (a proximal point step).
  const double lift = 1e-9 * w;
  const Vector2d aim = force.tail<2>() - motion.tail<2>() / w;
  const double length = aim.norm(), limit = mu * force(0);
  const bool slides = length > limit;
  const Vector2d direction = slides && length > 0 ? Vector2d(aim / length) : Vector2d(Vector2d::Zero());
  const double ratio = slides && length > 0 ? limit / length : 0;
  const Eigen::Matrix2d across = ratio * (Eigen::Matrix2d::Identity() - direction * direction.transpose());
  for (std::size_t a = 0; a < active.size(); ++a) {
    const Index j = active[a];
    Matrix3d w_ij = p_.delassus.block<3, 3>(3 * i, 3 * j);
    if (i == j) w_ij.diagonal().array() += lift;
    auto out = jacobian_.block<3, 3>(row, 3 * static_cast<Index>(a));
    out.row(0) = w_ij.row(0);
    if (!slides) {
      out.bottomRows<2>() = w_ij.bottomRows<2>();
      continue;
    }
    out.bottomRows<2>() = across * w_ij.bottomRows<2>();
    if (i != j) continue;
    out.bottomRightCorner<2, 2>() += w * (Eigen::Matrix2d::Identity() - across);
    out.bottomLeftCorner<2, 1>() -= w * mu * direction;
  }
  value_(row) = motion(0);
  value_.segment<2>(row + 1) =
      slides ? Vector2d(w * (force.tail<2>() - limit * direction)) : Vector2d(motion.tail<2>());
}

/// One step of semi-smooth Newton on the Alart–Curnier function. It is shortened while that helps, and taken even where
/// nothing helps: the function is not smooth, and going uphill once is the way out of a corner. Forces may leave their
/// cones on the way. @return false if there is no step
bool Solver::newton_step() {
  const double before = merit();
  const VectorXd from = forces_;
  std::vector<Index> active;
  VectorXd pressed = VectorXd::Zero(from.size());
  for (Index i = 0; i < k_; ++i) {
    if (!movable(i) || forces_(3 * i) - motion_(3 * i) / size_[i] <= 0) continue;
    active.push_back(i);
    pressed.segment<3>(3 * i) = from.segment<3>(3 * i);
  }
  take_forces(pressed);  // the others let go
  const auto n = static_cast<Index>(3 * active.size());
  jacobian_.resize(n, n);
  value_.resize(n);
  for (std::size_t a = 0; a < active.size(); ++a) linearise(active[a], 3 * static_cast<Index>(a), active);
  const VectorXd step = n > 0 ? VectorXd(jacobian_.partialPivLu().solve(value_)) : VectorXd();
  for (std::size_t a = 0; a < active.size(); ++a)
    pressed.segment<3>(3 * active[a]) -= step.segment<3>(3 * static_cast<Index>(a));
  if (!pressed.allFinite()) {
    take_forces(from);
    return false;
  }
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (double share = 1; share > 0.05 && !(least < 0.9 * before); share *= 0.5) {
    take_forces(from + share * (pressed - from));
    if (const double now = merit(); now < least) {
      least = now;
      best = forces_;
    }
  }
  if (best.size() == 0) best = from;
  take_forces(best);
  return true;
}

}  // namespace

FrictionSolution solve_friction(const FrictionProblem& problem, std::span<const double> start,
                                const FrictionOptions& options) {
  check_sizes(problem, start.size());
  FrictionSolution solution;
  solution.forces = VectorXd::Zero(static_cast<Index>(3 * problem.size()));
  if (!problem.delassus.allFinite() || !problem.free_motion.allFinite()) {
    solution.residual = std::numeric_limits<double>::infinity();
    return solution;
  }
  Solver solver(problem);
  solution.immovable = solver.immovable();
  VectorXd forces = solution.forces;
  if (!start.empty() && solver.scale() > 0) forces = VectorXd::Map(start.data(), forces.size());
  if (!forces.allFinite()) forces.setZero();
  solver.take_allowed(forces);
  solution.residual = solver.residual();
  solution.forces = solver.forces();
  const auto keep_best = [&] {
    if (const double residual = solver.residual(); residual < solution.residual) {
      solution.residual = residual;
      solution.forces = solver.forces();
    }
  };
  constexpr int sweeps_before_newton = 12, newton_steps_in_a_row = 30;
  int sweeps = 0, until = sweeps_before_newton;
  while (solution.residual > options.tolerance && solution.iterations < options.iterations) {
    solver.sweep();
    ++solution.iterations;
    keep_best();
    if (++sweeps < until) continue;
    sweeps = 0;
    for (int n = 0;
         n < newton_steps_in_a_row && solution.residual > options.tolerance && solution.iterations < options.iterations;
         ++n) {
      ++solution.iterations;
      ++solution.newton_steps;
      if (!solver.newton_step()) break;
      keep_best();
    }
    until = std::min(2 * until, 48);
  }
  // Newton's forces may lie outside their cones by as much as the tolerance; inside is better where it costs nothing.
  solver.take_allowed(solution.forces);
  if (solver.residual() <= std::max(options.tolerance, solution.residual)) solution.forces = solver.forces();
  // The motion was kept up to date by differences: judge what is returned from the start.
  solution.residual = friction_residual(problem, solution.forces);
  solution.converged = solution.residual <= options.tolerance;
  return solution;
}

double friction_residual(const FrictionProblem& problem, const Eigen::VectorXd& forces) {
  check_sizes(problem, static_cast<std::size_t>(forces.size()));
  if (!forces.allFinite() || !problem.delassus.allFinite() || !problem.free_motion.allFinite())
    return std::numeric_limits<double>::infinity();
  Solver solver(problem);
  solver.take_forces(forces);
  return solver.residual();
}

}  // namespace calot
