#include "calot/sim/haptic_contact.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <span>

#include "calot/sim/haptic_twist.h"

namespace calot {
namespace {

/// More than this between hand and tool is none that a set for this place could mean.
constexpr double longest_offset = 0.1, largest_turn = 1.5;  // m, rad

Vector6 within_reach(const Vector6& offset) {
  if (!offset.allFinite()) return Vector6::Zero();
  Vector6 near = offset;
  const double length = offset.head<3>().stableNorm(), turn = offset.tail<3>().stableNorm();
  if (length > longest_offset) near.head<3>() *= longest_offset / length;
  if (turn > largest_turn) near.tail<3>() *= largest_turn / turn;
  return near;
}

bool is_sound(const HapticConstraints& set) {
  const auto rows = static_cast<Eigen::Index>(3 * set.problem.size());
  const bool sizes = set.problem.delassus.rows() == rows && set.problem.delassus.cols() == rows &&
                     set.problem.free_motion.size() == rows && set.motion.rows() == rows && set.wrench.cols() == rows;
  return sizes && is_finite(set.pose) && set.problem.delassus.allFinite() && set.problem.free_motion.allFinite() &&
         set.motion.allFinite() && set.wrench.allFinite() && set.held_wrench.allFinite() &&
         set.held_stiffness.allFinite() &&
         std::all_of(set.problem.friction.begin(), set.problem.friction.end(),
                     [](double mu) { return std::isfinite(mu) && mu >= 0; });
}

/// Back into the cones: an iteration that ended early shows no force that friction could not.
void keep_in_cones(Eigen::VectorXd& forces, const std::vector<double>& friction) {
  for (std::size_t c = 0; c < friction.size(); ++c) {
    auto force = forces.segment<3>(static_cast<Eigen::Index>(3 * c));
    if (!force.allFinite() || force[0] <= 0) {
      force.setZero();
      continue;
    }
    const double tangent = force.tail<2>().norm(), most = friction[c] * force[0];
    if (tangent > most) force.tail<2>() *= most / tangent;
  }
}

}  // namespace

void HapticContact::clear() {
  empty_ = true;
  problem_.friction.clear();
  forces_.resize(0);
}

bool HapticContact::take(const HapticConstraints& set, const Coupling& coupling) {
  clear();
  if (!is_sound(set)) return false;
  stiffness_.setZero();
  stiffness_.diagonal() << Vec3::Constant(coupling.stiffness), Vec3::Constant(coupling.turning_stiffness);
  const Matrix6 balance = stiffness_ + 0.5 * (set.held_stiffness + set.held_stiffness.transpose());
  const Eigen::LDLT<Matrix6> solver(balance);
  if (solver.info() != Eigen::Success || !solver.isPositive() || solver.vectorD().minCoeff() <= 0) return false;
  give_ = solver.solve(Matrix6::Identity());
  if (!give_.allFinite()) return false;
  pose_ = set.pose;
  pose_.rotation.normalize();
  held_ = set.held_wrench;
  motion_ = set.motion;
  wrench_ = set.wrench;
  free_ = set.problem.free_motion;
  motion_give_.noalias() = motion_ * give_;
  problem_.friction = set.problem.friction;
  problem_.delassus.noalias() = motion_give_ * wrench_;
  problem_.delassus = (0.5 * (problem_.delassus + problem_.delassus.transpose())).eval();
  problem_.delassus += set.problem.delassus;
  problem_.free_motion.resize(free_.size());
  forces_.setZero(free_.size());
  empty_ = false;
  return true;
}

HapticContact::Answer HapticContact::solve(const Pose& tool_wanted, int iterations) {
  Answer answer;
  if (empty_) return answer;
  const Vector6 wanted = twist_between(pose_, tool_wanted);
  const Vector6 pull = stiffness_ * wanted + held_;
  Vector6 tool = give_ * pull;
  if (problem_.size() > 0) {
    problem_.free_motion.noalias() = free_ + motion_ * tool;
    const std::span<const double> start(forces_.data(), static_cast<std::size_t>(forces_.size()));
    const FrictionSolution solution = solve_friction(problem_, start, {.tolerance = 1e-6, .iterations = iterations});
    forces_ = solution.forces;
    answer.residual = solution.residual;
    keep_in_cones(forces_, problem_.friction);
    tool.noalias() += give_ * (wrench_ * forces_);
  }
  answer.offset = within_reach(tool - wanted);
  return answer;
}

}  // namespace calot
