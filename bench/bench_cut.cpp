// A full transection of the duct: how soon the exact answer is usable, beside the paper's ways.
#include <thread>

#include "bench/accuracy.h"
#include "bench/benchmarks.h"
#include "bench/organ.h"
#include "bench/three_ways.h"

namespace calot::bench {
namespace {

constexpr std::chrono::microseconds frame{16667};

struct CutTimes {
  std::vector<double> usable, fold, query;  // [s]
  double error = 0, bound = 0, block_error = 0, eigenvalue = 1;
  std::size_t rank = 0, tets = 0;
};

// 60 Hz queries while the fold runs; each query's time.
void fold_under_queries(Compliance& compliance, const std::vector<DofId>& dofs, CutTimes& times) {
  const Stopwatch watch;
  compliance.start_fold();
  auto next = std::chrono::steady_clock::now();
  double done = 0;
  while (done == 0) {
    times.query.push_back(seconds_of([&] { (void)compliance.block(dofs, dofs); }));
    next += frame;
    while (std::chrono::steady_clock::now() < next && done == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (compliance.fold_ready()) done = watch.seconds();
    }
  }
  compliance.adopt_fold();
  times.fold.push_back(done);
}

void measure(const Organ& organ, const Edit& edit, bool check, CutTimes& times) {
  Compliance compliance = precompute(organ.model);
  compliance.reserve_fold();
  Model model = organ.model;
  StiffnessChange change;
  UpdateReport report;
  std::vector<DofId> dofs;
  Eigen::MatrixXd block;
  times.usable.push_back(seconds_of([&] {
    change = model.apply(edit);
    report = compliance.update(change);
    dofs = query_dofs(change, model.mesh().vertex_count());
    block = compliance.block(dofs, dofs);
  }));
  times.rank = std::max(times.rank, report.rank);
  times.tets = std::max(times.tets, edit.removed.size());
  times.eigenvalue = std::min(times.eigenvalue, report.smallest_eigenvalue);
  if (check) {
    const Compliance reference = precompute(model, {Backend::sparse});
    times.error = std::max(times.error, worst_column(compliance, reference, dofs));
    times.block_error = std::max(times.block_error, worst_block(block, reference, dofs));
    times.bound = std::max(times.bound, error_bound(reference));
  }
  fold_under_queries(compliance, dofs, times);
}

// Algorithms 1 and 2 on the same matrix in memory [s].
double paper_in_memory(const Organ& organ, const Edit& edit) {
  FullCompliance full = precompute(organ.model).full();
  Model model = organ.model;
  const StiffnessChange change = model.apply(edit);
  return seconds_of([&] { paper_update(full, change.struck, model.mesh()); });
}

}  // namespace

std::vector<Row> bench_cut(const BenchOptions& options) {
  const Organ organ = make_organ(options);
  const std::vector<Edit> cuts = transections(organ, 24);
  CutTimes times;
  if (options.progress) options.progress->phase("cutting");
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    measure(organ, cuts[k], k % 4 == 0, times);
    if (options.progress) options.progress->at(static_cast<double>(k + 1) / static_cast<double>(cuts.size()));
  }
  std::vector<double> in_memory;
  for (int k = 0; k < 3; ++k) in_memory.push_back(paper_in_memory(organ, cuts[cuts.size() / 2]));
  const double through_files = paper_through_files(organ.model, cuts[cuts.size() / 2]);

  const auto milliseconds = [](std::vector<double> seconds) {
    for (double& s : seconds) s *= 1e3;
    return seconds;
  };
  const std::string size = std::to_string(times.tets) + " tets, rank " + std::to_string(times.rank);
  Row usable = distribution_row("cut.usable", "ms", milliseconds(times.usable));
  usable.baseline = "the paper's Algorithms 1 and 2 in memory on the same matrix (" + size + ")";
  usable.ratio = *usable.p99 / (1e3 * distribution(in_memory).p50);
  usable.goal = 10;
  usable.goal_ratio = 0.2;
  Row fold = distribution_row("cut.fold", "s", times.fold);
  fold.value = *fold.p50;
  fold.baseline = "recomputing from the mesh (precompute.dense does the ordering too)";
  fold.ratio = fold.value / distribution({seconds_of([&] { (void)precompute(organ.model); })}).p50;
  fold.goal = 0.25;
  Row query = distribution_row("cut.query_while_folding", "ms", milliseconds(times.query));
  query.goal = 16.7;
  Row files = {.name = "cut.rewrite_reload",
               .value = through_files,
               .unit = "s",
               .baseline = "cut.usable",
               .ratio = through_files / (*usable.p99 / 1e3)};
  Row error = {.name = "cut.error",
               .value = times.error,
               .unit = "1",
               .baseline = "a refined recomputation, worst column; the bound is max(1e-9, 10 eps kappa)",
               .goal = times.bound};
  Row block = {.name = "cut.block_error",
               .value = times.block_error,
               .unit = "1",
               .baseline = "the same, for the block answered at once, not refined"};
  Row eigenvalue = {.name = "cut.smallest_eigenvalue", .value = times.eigenvalue, .unit = "1"};
  return {usable, fold, query, files, error, block, eigenvalue};
}

}  // namespace calot::bench
