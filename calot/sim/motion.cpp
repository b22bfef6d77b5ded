#include "calot/sim/motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calot/mesh/parts.h"

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
  for (std::vector<Vec3>* v : {&b_, &r_, &z_, &p_, &q_, &inertia_, &response_, &elastic_, &masked_, &answer_})
    v->assign(masses_.size(), Vec3::Zero());
  tissue_ = nullptr;
  elastic_is_fresh_ = false;
  group_ = vertex_connected_groups(model.mesh());
  group_count_ = group_.empty() ? 0 : 1 + *std::max_element(group_.begin(), group_.end());
  part_ = group_;
  part_count_ = group_count_;
}

void Motion::join_parts() {
  std::vector<std::uint32_t> root(group_count_);
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t g) {
    while (root[g] != g) g = root[g] = root[root[g]];
    return g;
  };
  for (const Spring& spring : springs_) {
    if (!spring.other.valid()) continue;
    const std::uint32_t a = find(group_[spring.vertex.index()]), b = find(group_[spring.other.index()]);
    root[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::uint32_t> number(group_count_);
  part_count_ = 0;
  for (std::uint32_t g = 0; g < group_count_; ++g)
    number[g] = root[g] == g ? static_cast<std::uint32_t>(part_count_++) : number[find(g)];
  for (std::size_t v = 0; v < part_.size(); ++v) part_[v] = number[group_[v]];
  // Below this force a part counts as at rest: a billionth of its weight.
  weight_of_part_.assign(part_count_, 0.0);
  for (std::size_t v = 0; v < part_.size(); ++v) weight_of_part_[part_[v]] += 9.81e-9 * masses_[v];
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
  join_parts();
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
  for (std::size_t v = 0; v < b_.size(); ++v)
    inertia_[v] = fixed_[v] ? Vec3(Vec3::Zero()) : Vec3(h * state.velocities[v]);
}

void Motion::sum_by_part(std::span<const Vec3> a, std::span<const Vec3> b, std::vector<double>& sums) const {
  sums.assign(part_count_, 0.0);
  for (std::size_t v = 0; v < a.size(); ++v) sums[part_[v]] += a[v].dot(b[v]);
}

// z = P r; part by part where the preconditioner would mix them.
void Motion::precondition(const Preconditioner& preconditioner) {
  const auto active =
      std::count_if(state_of_part_.begin(), state_of_part_.end(), [](const PartState& s) { return s.active; });
  if (!preconditioner.mixes_parts || part_count_ == 1) {
    preconditioner.apply(r_, z_);
    return;
  }
  if (active == 0) return;
  for (std::uint32_t part = 0; part < part_count_; ++part) {
    if (!state_of_part_[part].active) continue;
    for (std::size_t v = 0; v < r_.size(); ++v) masked_[v] = part_[v] == part ? r_[v] : Vec3(Vec3::Zero());
    preconditioner.apply(masked_, answer_);
    for (std::size_t v = 0; v < r_.size(); ++v)
      if (part_[v] == part) z_[v] = answer_[v];
  }
}

// Where the preconditioner lost its definiteness to rounding, a part goes on without it: slower, never wrong.
void Motion::go_plain_where_lost() {
  const auto take_residual = [&] {
    for (std::size_t v = 0; v < z_.size(); ++v)
      if (state_of_part_[part_[v]].plain) z_[v] = r_[v];
  };
  take_residual();
  sum_by_part(r_, z_, sums_);
  bool lost = false;
  for (std::size_t k = 0; k < part_count_; ++k) {
    PartState& part = state_of_part_[k];
    if (!part.active || sums_[k] > 0) continue;
    part.plain = lost = true;
    part.before = 0;
  }
  if (lost) {
    take_residual();
    sum_by_part(r_, z_, sums_);
  }
  for (std::size_t k = 0; k < part_count_; ++k) state_of_part_[k].descent = sums_[k];
}

// From d, whose residual is in r_.
SolverReport Motion::conjugate_gradients(std::span<const Vec3> b, const Preconditioner& preconditioner,
                                         const SolverOptions& options, std::span<Vec3> d) {
  SolverReport report;
  state_of_part_.assign(part_count_, {});
  sum_by_part(b, b, sums_);
  for (std::size_t k = 0; k < part_count_; ++k)
    state_of_part_[k].scale = std::max(std::sqrt(sums_[k]), weight_of_part_[k]);
  const auto judge = [&] {
    sum_by_part(r_, r_, sums_);
    bool any = false;
    report.residual = 0;
    for (std::size_t k = 0; k < part_count_; ++k) {
      PartState& part = state_of_part_[k];
      part.residual = std::sqrt(sums_[k]) / part.scale;
      part.active = !(part.residual <= options.tolerance);  // a residual that isn't a number counts
      any = any || part.active;
      if (!(part.residual <= report.residual)) report.residual = part.residual;
    }
    return any;
  };
  while (judge() && std::isfinite(report.residual) && report.iterations < options.iterations) {
    precondition(preconditioner);
    go_plain_where_lost();
    for (std::size_t v = 0; v < p_.size(); ++v) {
      const PartState& part = state_of_part_[part_[v]];
      if (!part.active)
        p_[v].setZero();
      else
        p_[v] = part.before > 0 ? Vec3(z_[v] + part.descent / part.before * p_[v]) : z_[v];
    }
    multiply(p_, q_);
    sum_by_part(p_, q_, sums_);
    for (std::size_t v = 0; v < p_.size(); ++v) {
      const PartState& part = state_of_part_[part_[v]];
      if (!part.active || !(sums_[part_[v]] > 0)) continue;
      const double along = part.descent / sums_[part_[v]];
      d[v] += along * p_[v];
      r_[v] -= along * q_[v];
    }
    for (PartState& part : state_of_part_) part.before = part.active ? part.descent : 0;
    ++report.iterations;
  }
  report.converged = report.residual <= options.tolerance;
  return report;
}

// From the motion that goes on, part by part as much of it as lowers ½ dᵀ Â d − bᵀ d most: never above rest.
SolverReport Motion::solve_free(const Preconditioner& preconditioner, const SolverOptions& options, std::span<Vec3> d) {
  std::copy(inertia_.begin(), inertia_.end(), d.begin());
  multiply(d, q_);
  std::vector<double>& gain = sums_;
  sum_by_part(inertia_, b_, gain);
  std::vector<double> cost;
  sum_by_part(inertia_, q_, cost);
  for (std::size_t k = 0; k < part_count_; ++k) gain[k] = gain[k] > 0 && cost[k] > 0 ? gain[k] / cost[k] : 0;
  for (std::size_t v = 0; v < d.size(); ++v) {
    const double share = gain[part_[v]];
    d[v] *= share;
    r_[v] = b_[v] - share * q_[v];
  }
  return conjugate_gradients(b_, preconditioner, options, d);
}

SolverReport Motion::add_response(std::span<const Vec3> f, const Preconditioner& preconditioner,
                                  const SolverOptions& options, std::span<Vec3> d) {
  std::fill(response_.begin(), response_.end(), Vec3::Zero());
  std::copy(f.begin(), f.end(), r_.begin());
  const SolverReport report = conjugate_gradients(f, preconditioner, options, response_);
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
  double sum = 0, elastic = 0, weight = 0;
  for (std::size_t v = 0; v < missing.size(); ++v) {
    if (fixed_[v]) continue;
    sum += missing[v].squaredNorm();
    elastic += elastic_[v].squaredNorm();
    weight += (masses_[v] * gravity_).squaredNorm();
  }
  const double scale = std::max({dot(b_, b_), elastic, weight});
  return scale == 0 ? 0 : std::sqrt(sum / scale);
}

}  // namespace calot
