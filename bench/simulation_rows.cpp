#include "bench/simulation_rows.h"

#include <algorithm>
#include <cstdio>

#include "calot/base/error.h"

namespace calot::bench {

void warm_up(Operation& operation) {
  while (operation.steps() < Operation::warm_up) operation.step();
  check_hold(operation);
}

void check_hold(const Operation& operation) {
  if (!operation.holds())
    throw FailedError("the benchmark's scene", "the grasper lost the body at step " + std::to_string(operation.steps()),
                      "this is not the scene that was to be measured");
}

std::string words_of(const Organ& organ, const Stiffness& stiffness) {
  std::array<char, 100> words{};
  std::snprintf(words.data(), words.size(), "%zu tets, body %g kPa, ducts %g kPa", organ.model.mesh().tet_count(),
                stiffness.body / 1e3, stiffness.ducts / 1e3);
  return std::string(words.data()) + (stiffness.tears ? "" : ", nothing tears");
}

std::vector<double> milliseconds(std::vector<double> seconds) {
  for (double& s : seconds) s *= 1e3;
  return seconds;
}

std::vector<Row> paced_rows(const std::string& name, const PacedRun& run, double goal_ms) {
  const auto of = [&](const auto& value) {
    std::vector<double> values;
    for (const StepReport& report : run.reports) values.push_back(static_cast<double>(value(report)));
    return values;
  };
  Row step = distribution_row(name, "ms", milliseconds(of([](const StepReport& r) { return r.total(); })));
  if (goal_ms > 0) step.goal = goal_ms;
  std::vector<Row> rows{step};
  rows.push_back(distribution_row(name + ".frame", "ms", milliseconds(run.frames)));
  rows.push_back({.name = name + ".late_frames",
                  .value = static_cast<double>(run.late()),
                  .unit = "1",
                  .baseline = "all frames",
                  .ratio = static_cast<double>(run.late()) / static_cast<double>(run.frames.size())});
  for (std::size_t k = 0; k < phase_count; ++k) {
    std::string phase(name_of(static_cast<Phase>(k)));
    std::replace(phase.begin(), phase.end(), ' ', '_');
    std::vector<double> values = milliseconds(of([&](const StepReport& r) { return r.seconds[k]; }));
    Row row = distribution_row(name + "." + phase, "ms", values);
    row.baseline = "the whole step, means";
    row.ratio =
        distribution(values).mean / distribution(milliseconds(of([](const StepReport& r) { return r.total(); }))).mean;
    rows.push_back(std::move(row));
  }
  std::size_t away = 0, inverted = 0;
  for (const StepReport& report : run.reports) {
    away += report.ran_away ? 1 : 0;
    inverted = std::max(inverted, report.inverted);
  }
  rows.push_back({.name = name + ".ran_away", .value = static_cast<double>(away), .unit = "1", .goal = 0});
  rows.push_back({.name = name + ".inverted_tets", .value = static_cast<double>(inverted), .unit = "1"});
  const auto unitless = [&](const std::string& what, const auto& value) {
    rows.push_back(distribution_row(name + "." + what, "1", of(value)));
  };
  unitless("iterations", [](const StepReport& r) { return r.free_motion.iterations; });
  unitless("response_iterations", [](const StepReport& r) { return r.response.iterations; });
  unitless("residual", [](const StepReport& r) { return std::max(r.free_motion.residual, r.response.residual); });
  unitless("friction_residual", [](const StepReport& r) { return r.friction.residual; });
  unitless("nonlinear_residual", [](const StepReport& r) { return r.nonlinear_residual; });
  return rows;
}

}  // namespace calot::bench
