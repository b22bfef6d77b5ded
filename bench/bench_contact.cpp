// Contact with friction: the problems that an operation poses, solved by us and by Siconos to the same residual.
#include <algorithm>
#include <map>

#include "bench/benchmarks.h"
#include "bench/simulation_rows.h"
#include "calot/base/error.h"
#ifdef CALOT_BENCH_SICONOS
#include "oracle/siconos_solver.h"
#endif

namespace calot::bench {
namespace {

struct Recorded {
  FrictionProblem problem;
  std::vector<double> start;  // the last step's forces
};

struct Answers {
  std::vector<double> milliseconds, iterations, residuals;
};

Answers ours(const std::vector<Recorded>& problems, const FrictionOptions& options) {
  Answers answers;
  for (const Recorded& recorded : problems) {
    (void)solve_friction(recorded.problem, recorded.start, options);  // so that both find their data in the cache
    FrictionSolution solution;
    answers.milliseconds.push_back(
        1e3 * seconds_of([&] { solution = solve_friction(recorded.problem, recorded.start, options); }));
    answers.iterations.push_back(solution.iterations);
    answers.residuals.push_back(solution.residual);
  }
  return answers;
}

#ifdef CALOT_BENCH_SICONOS
// Its tolerance is of another kind than ours: the loosest that reaches our residual counts.
Answers siconos(const std::vector<Recorded>& problems, oracle::SiconosMethod method, double residual) {
  Answers answers;
  for (const Recorded& recorded : problems) {
    const Eigen::VectorXd start =
        Eigen::VectorXd::Map(recorded.start.data(), static_cast<Eigen::Index>(recorded.start.size()));
    oracle::SiconosResult result;
    double seconds = 0, reached = 1;
    for (double tolerance = 1e-3; tolerance > 1e-13 && !(reached <= residual); tolerance *= 0.1) {
      seconds = seconds_of([&] { result = solve_with_siconos(recorded.problem, start, method, tolerance, 10000); });
      reached = friction_residual(recorded.problem, result.forces);
    }
    answers.milliseconds.push_back(1e3 * seconds);
    answers.iterations.push_back(result.iterations);
    answers.residuals.push_back(reached);
  }
  return answers;
}
#endif

void add_rows(const std::string& name, const Answers& answers, std::vector<Row>& rows) {
  rows.push_back(distribution_row(name, "ms", answers.milliseconds));
  rows.push_back(distribution_row(name + ".iterations", "1", answers.iterations));
  rows.push_back(distribution_row(name + ".residual", "1", answers.residuals));
}

// Every few steps one problem, with the forces that the world would begin from.
class Recorder {
 public:
  explicit Recorder(std::size_t wanted) : wanted_(wanted) {}
  void look_at(const World& world) {
    const FrictionProblem& problem = world.friction_problem();
    const bool full = problems_.size() == wanted_;
    if (!full && problem.size() > 0 && ++steps_ % 3 == 0) {
      std::vector<double> start(3 * problem.size(), 0.0);
      for (std::size_t k = 0; k < problem.size(); ++k)
        if (const auto force = last_.find(world.contacts()[k].key); force != last_.end())
          std::copy_n(force->second.data(), 3, start.begin() + static_cast<std::ptrdiff_t>(3 * k));
      problems_.push_back({problem, std::move(start)});
    }
    last_.clear();
    for (std::size_t k = 0; k < problem.size(); ++k)
      last_[world.contacts()[k].key] = world.report().friction.forces.segment<3>(3 * static_cast<Eigen::Index>(k));
  }
  [[nodiscard]] const std::vector<Recorded>& problems() const { return problems_; }

 private:
  std::size_t wanted_, steps_ = 0;
  std::vector<Recorded> problems_;
  std::map<std::uint64_t, Vec3> last_;
};

}  // namespace

std::vector<Row> contact_rows(const Organ& organ, std::size_t problems) {
  Operation operation(organ, {});
  warm_up(operation);
  Recorder recorder(problems);
  const PacedRun run = run_paced(operation, 3 * problems, [&] { recorder.look_at(operation.world()); });
  check_hold(operation);
  if (recorder.problems().empty()) throw FailedError("bench contact", "the tubes touched nothing", "");
  const FrictionOptions options = operation.world().options().friction;
  std::vector<Row> rows;
  add_rows("contact.solve", ours(recorder.problems(), options), rows);
  rows.front().baseline = "(Siconos isn't in this build)";
#ifdef CALOT_BENCH_SICONOS
  std::vector<Row> theirs;
  add_rows("contact.siconos_nsgs", siconos(recorder.problems(), oracle::SiconosMethod::gauss_seidel, options.tolerance),
           theirs);
  const std::size_t newton = theirs.size();
  add_rows("contact.siconos_newton", siconos(recorder.problems(), oracle::SiconosMethod::newton, options.tolerance),
           theirs);
  const bool sweeps = *theirs[0].p50 <= *theirs[newton].p50;
  const double quicker = *theirs[sweeps ? 0 : newton].p50;
  rows.front().baseline = std::string("Siconos ") + (sweeps ? "NSGS" : "NSN_AC") +
                          ", the quicker of its two, on the same problems to the same residual, p50";
  rows.front().ratio = *rows.front().p50 / quicker;
  rows.insert(rows.end(), theirs.begin(), theirs.end());
#endif
  std::vector<double> contacts, detection, whole;
  for (const Recorded& recorded : recorder.problems()) contacts.push_back(static_cast<double>(recorded.problem.size()));
  for (const StepReport& report : run.reports) {
    detection.push_back(1e3 * report.seconds[static_cast<std::size_t>(Phase::detection)]);
    whole.push_back(1e3 * report.seconds[static_cast<std::size_t>(Phase::contact)]);
  }
  rows.push_back(distribution_row("contact.contacts", "1", contacts));
  rows.push_back(distribution_row("contact.detection", "ms", detection));
  Row phase = distribution_row("contact.phase", "ms", whole);
  phase.baseline = "contact.solve; the rest is W = J C Jᵀ, means";
  double mean = 0;
  for (const double ms : whole) mean += ms / static_cast<double>(whole.size());
  phase.ratio = mean / std::max(1e-6, *rows.front().p50);
  rows.push_back(std::move(phase));
  return rows;
}

std::vector<Row> bench_contact(const BenchOptions& options) {
  const Organ organ = make_organ_of_tets(options, 10000, 1.0 / 60);
  if (options.progress) options.progress->phase("operating at real pace");
  return contact_rows(organ, 120);
}

}  // namespace calot::bench
