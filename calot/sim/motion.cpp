#include "calot/sim/motion.h"

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

double dot(std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) sum += a[v].dot(b[v]);
  return sum;
}

}  // namespace

Motion::Motion(const Model& model) {
  follow(model);
}

void Motion::follow(const Model& model) {
  dynamics_ = model.dynamics();
  masses_ = model.vertex_masses();
  fixed_ = model.fixed();
  for (std::vector<Vec3>* v : {&b_, &r_, &z_, &p_, &q_, &response_, &elastic_}) v->assign(masses_.size(), Vec3::Zero());
  tissue_ = nullptr;
  elastic_is_fresh_ = false;
}

void Motion::multiply(std::span<const Vec3> x, std::span<Vec3> y) const {
  tissue_->multiply(x, y);
  const double stiffness = dynamics_.stiffness_factor(), inertia = dynamics_.mass_factor();
  for (std::size_t v = 0; v < y.size(); ++v) y[v] = stiffness * y[v] + inertia * masses_[v] * x[v];
  for (const Spring& spring : springs_) {
    const std::size_t a = spring.vertex.index();
    Vec3 pull = x[a];
    if (spring.other.valid()) pull -= x[spring.other.index()];
    pull = (1 + spring.damping / dynamics_.time_step) * (spring.stiffness * pull);
    y[a] += pull;
    if (spring.other.valid()) y[spring.other.index()] -= pull;
  }
  for (std::size_t v = 0; v < y.size(); ++v)
    if (fixed_[v]) y[v].setZero();
}

void Motion::add_springs(const TissueState& state) {
  for (const Spring& spring : springs_) {
    const std::size_t a = spring.vertex.index();
    Vec3 target = spring.anchor;
    if (spring.other.valid()) target += state.positions[spring.other.index()];
    const Vec3 pull = spring.stiffness * (target - state.positions[a] + spring.damping * spring.velocity);
    b_[a] += pull;
    if (spring.other.valid()) b_[spring.other.index()] -= pull;
  }
}

void Motion::begin(const Corotational& tissue, const TissueState& state, const Vec3& gravity,
                   std::span<const Spring> springs, std::span<const Vec3> external) {
  tissue_ = &tissue;
  springs_ = springs;
  gravity_ = gravity;
  external_.assign(external.begin(), external.end());
  if (!elastic_is_fresh_) tissue.force(state.positions, elastic_);
  elastic_is_fresh_ = false;
  b_ = elastic_;
  const double h = dynamics_.time_step;
  for (std::size_t v = 0; v < b_.size(); ++v) {
    b_[v] += masses_[v] * (state.velocities[v] / h + gravity);
    if (!external.empty()) b_[v] += external[v];
  }
  add_springs(state);
  for (std::size_t v = 0; v < b_.size(); ++v)
    if (fixed_[v]) b_[v].setZero();
}

SolverReport Motion::conjugate_gradients(std::span<const Vec3> b, const Preconditioner& preconditioner,
                                         const SolverOptions& options, double scale, bool from_zero,
                                         std::span<Vec3> d) {
  SolverReport report;
  if (from_zero) {
    std::fill(d.begin(), d.end(), Vec3::Zero());
    std::copy(b.begin(), b.end(), r_.begin());
  } else {
    multiply(d, q_);
    for (std::size_t v = 0; v < r_.size(); ++v) r_[v] = b[v] - q_[v];
  }
  report.residual = scale > 0 ? std::sqrt(dot(r_, r_)) / scale : 0;
  double before = 0;
  while (report.residual > options.tolerance && report.iterations < options.iterations) {
    preconditioner(r_, z_);
    const double now = dot(r_, z_);
    if (!(now > 0)) break;  // the preconditioner lost its definiteness: stop with what there is, and say so
    const double beta = report.iterations == 0 ? 0 : now / before;
    for (std::size_t v = 0; v < p_.size(); ++v) p_[v] = z_[v] + beta * p_[v];
    multiply(p_, q_);
    const double curvature = dot(p_, q_);
    if (!(curvature > 0)) break;
    const double along = now / curvature;
    for (std::size_t v = 0; v < p_.size(); ++v) {
      d[v] += along * p_[v];
      r_[v] -= along * q_[v];
    }
    before = now;
    ++report.iterations;
    report.residual = std::sqrt(dot(r_, r_)) / scale;
  }
  report.converged = report.residual <= options.tolerance;
  return report;
}

SolverReport Motion::solve_free(const Preconditioner& preconditioner, const SolverOptions& options, std::span<Vec3> d) {
  return conjugate_gradients(b_, preconditioner, options, std::sqrt(dot(b_, b_)), true, d);
}

SolverReport Motion::add_response(std::span<const Vec3> f, std::span<const Vec3> guess,
                                  const Preconditioner& preconditioner, const SolverOptions& options,
                                  std::span<Vec3> d) {
  std::copy(guess.begin(), guess.end(), response_.begin());
  const SolverReport report = conjugate_gradients(f, preconditioner, options, std::sqrt(dot(f, f)), false, response_);
  for (std::size_t v = 0; v < d.size(); ++v) d[v] += response_[v];
  return report;
}

double Motion::finish(const TissueState& before, const TissueState& after, std::span<const Vec3> contact) {
  const double h = dynamics_.time_step;
  tissue_->force(after.positions, elastic_);
  elastic_is_fresh_ = true;
  tissue_->multiply(after.velocities, q_);
  std::vector<Vec3>& missing = r_;
  for (std::size_t v = 0; v < missing.size(); ++v) {
    const Vec3& velocity = after.velocities[v];
    missing[v] = masses_[v] * ((velocity - before.velocities[v]) / h - gravity_ + dynamics_.rayleigh_mass * velocity) -
                 elastic_[v] + dynamics_.rayleigh_stiffness * q_[v];
    if (!external_.empty()) missing[v] -= external_[v];
    if (!contact.empty()) missing[v] -= contact[v];
  }
  for (const Spring& spring : springs_) {
    const std::size_t a = spring.vertex.index();
    Vec3 target = spring.anchor, speed = spring.velocity - after.velocities[a];
    if (spring.other.valid()) {
      target += after.positions[spring.other.index()];
      speed += after.velocities[spring.other.index()];
    }
    const Vec3 pull = spring.stiffness * (target - after.positions[a] + spring.damping * speed);
    missing[a] -= pull;
    if (spring.other.valid()) missing[spring.other.index()] += pull;
  }
  double sum = 0;
  for (std::size_t v = 0; v < missing.size(); ++v)
    if (!fixed_[v]) sum += missing[v].squaredNorm();
  const double scale = dot(b_, b_);
  return scale > 0 ? std::sqrt(sum / scale) : 0;
}

}  // namespace calot
