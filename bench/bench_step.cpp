// A step of the simulation: an operation at real pace, where its time goes, and what the preconditioner saves.
#include <algorithm>
#include <cmath>

#include "bench/benchmarks.h"
#include "bench/simulation_rows.h"
#include "calot/base/error.h"

namespace calot::bench {
namespace {

constexpr std::size_t base_age = 10;  // steps: between the youngest and the oldest that a step works with

/// A step's system, and the tissue as it was when the factor was begun that the step would use.
struct System {
  Model model;
  TissueState before, now;
  std::vector<Spring> springs_before, springs_now;
};

Corotational turned(const Model& model, const TissueState& state) {
  Corotational tissue(model);
  for (int k = 0; k < 20 && tissue.update_rotations(state.positions) > 1e-9; ++k) {
  }
  return tissue;
}

// The inverse of Â's diagonal blocks, each turned with its vertex.
class BlockJacobi {
 public:
  BlockJacobi(const Model& model, const Corotational& tissue, std::span<const Spring> springs) {
    const BlockMatrix matrix = model.step_stiffness();
    const std::vector<Eigen::Quaterniond> turn = vertex_rotations(vertex_tets(model.mesh()), tissue.rotations());
    for (std::size_t v = 0; v < turn.size(); ++v) {
      const Mat3 r = turn[v].toRotationMatrix();
      inverse_.push_back(r * *matrix.find(v, v) * r.transpose());
    }
    for (const Spring& spring : springs) {
      const Mat3 block = (1 + spring.damping / model.dynamics().time_step) * spring.stiffness;
      inverse_[spring.vertex.index()] += block;
      if (spring.other.valid()) inverse_[spring.other.index()] += block;
    }
    for (Mat3& block : inverse_) block = block.inverse().eval();
  }
  void apply(std::span<const Vec3> r, std::span<Vec3> z) const {
    for (std::size_t v = 0; v < r.size(); ++v) z[v] = inverse_[v] * r[v];
  }

 private:
  std::vector<Mat3> inverse_;
};

struct Solves {
  std::vector<double> milliseconds, iterations;
};

// The first solve of a system touches memory for the first time; the second is measured.
void measure(Motion& motion, const Preconditioner& preconditioner, Solves& solves) {
  std::vector<Vec3> d(motion.masses().size());
  const SolverOptions options{.tolerance = WorldOptions{}.solver.tolerance, .iterations = 20000};
  (void)motion.solve_free(preconditioner, options, d);
  SolverReport report;
  solves.milliseconds.push_back(1e3 * seconds_of([&] { report = motion.solve_free(preconditioner, options, d); }));
  solves.iterations.push_back(report.iterations);
  if (!report.converged) throw FailedError("bench step", "conjugate gradients didn't converge in 20000 iterations", "");
}

void compare(const System& system, Solves& ours, Solves& jacobi, Solves& plain) {
  const Corotational before = turned(system.model, system.before), now = turned(system.model, system.now);
  const BaseRequest request{system.model, before.rotations(), system.springs_before, {}, nullptr};
  WarpedCompliance compliance(request);
  compliance.set_base(make_base(request));
  compliance.set_springs(system.springs_now);
  compliance.settle();
  compliance.turn(vertex_rotations(vertex_tets(system.model.mesh()), now.rotations()));
  Motion motion(system.model);
  motion.begin(now, system.now, Vec3(0, -9.81, 0), system.springs_now, {});
  measure(motion, {[&](auto r, auto z) { compliance.apply(r, z); }}, ours);
  const BlockJacobi blocks(system.model, now, system.springs_now);
  measure(motion, {[&](auto r, auto z) { blocks.apply(r, z); }}, jacobi);
  measure(motion, {[](auto r, auto z) { std::copy(r.begin(), r.end(), z.begin()); }}, plain);
}

Row solver_row(const std::string& name, const Solves& solves, const Solves& baseline, const std::string& words) {
  Row row = distribution_row(name, "ms", solves.milliseconds);
  row.value = *row.p50;
  row.baseline = words + ", " + std::to_string(static_cast<int>(distribution(baseline.iterations).p50)) +
                 " iterations (p50) where this takes " +
                 std::to_string(static_cast<int>(distribution(solves.iterations).p50));
  row.ratio = *row.p50 / distribution(baseline.milliseconds).p50;
  return row;
}

void add_solver_rows(const std::string& name, const std::vector<System>& systems, std::vector<Row>& rows) {
  Solves ours, jacobi, plain;
  for (const System& system : systems) compare(system, ours, jacobi, plain);
  rows.push_back(solver_row(name + ".solve", ours, plain, "plain conjugate gradients on the same systems"));
  rows.push_back(
      solver_row(name + ".solve.block_jacobi", jacobi, plain, "plain conjugate gradients on the same systems"));
  rows.push_back(distribution_row(name + ".solve.iterations", "1", ours.iterations));
}

}  // namespace

std::vector<Row> step_rows(const std::string& name, const Organ& organ, const Stiffness& stiffness, double goal_ms,
                           std::size_t steps) {
  Operation operation(organ, stiffness);
  warm_up(operation);
  std::vector<System> systems;
  std::vector<double> contacts, acting;
  std::optional<System> begun;
  const std::size_t every = std::max<std::size_t>(2 * base_age, steps / 12);
  const PacedRun run = run_paced(operation, steps, [&] {
    contacts.push_back(static_cast<double>(operation.world().contacts().size()));
    acting.push_back(static_cast<double>(operation.acting_contacts()));
    if (!operation.world().changes().empty()) begun.reset();
    const std::size_t k = contacts.size() % every;
    if (k == 0) {
      begun = System{operation.world().model(), operation.world().state(), {}, operation.springs(), {}};
    } else if (k == base_age && begun) {
      begun->now = operation.world().state();
      begun->springs_now = operation.springs();
      systems.push_back(std::move(*begun));
      begun.reset();
    }
  });
  check_hold(operation);
  std::vector<Row> rows = paced_rows(name, run, goal_ms);
  rows.push_back(distribution_row(name + ".contacts", "1", contacts));
  rows.push_back(distribution_row(name + ".contacts.acting", "1", acting));
  if (systems.empty()) throw FailedError("bench step", "no system was recorded", "give it more steps");
  add_solver_rows(name, systems, rows);
  // What the whole step would have to wait for without the factor.
  const auto plain =
      std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.name == name + ".solve"; });
  rows.front().baseline = "solving its motion alone by plain conjugate gradients (p50); " + words_of(organ, stiffness);
  rows.front().ratio = *rows.front().p50 / (plain->value / *plain->ratio);
  return rows;
}

std::vector<Row> bench_step(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto add = [&](std::vector<Row> more) { rows.insert(rows.end(), more.begin(), more.end()); };
  for (const auto& [tets, name, goal] : {std::tuple{10000, "step.10k", 8.0}, std::tuple{20000, "step.20k", 16.7}}) {
    const Organ organ = make_organ_of_tets(options, static_cast<std::size_t>(tets), 1.0 / 60);
    if (options.progress) options.progress->phase("operating at real pace");
    Stiffness soft;
    soft.tears = tets < 15000;
    add(step_rows(name, organ, soft, goal, 480));
    add(step_rows(std::string(name) + ".1MPa", organ, as_in_the_paper, goal, 300));
  }
  return rows;
}

}  // namespace calot::bench
