// A full transection of the duct, by removal and by splitting: how soon the exact answer is usable, beside the paper's
// ways.
#include <thread>

#include "bench/accuracy.h"
#include "bench/benchmarks.h"
#include "bench/organ.h"
#include "bench/simulation_rows.h"
#include "bench/three_ways.h"
#include "calot/base/error.h"
#include "calot/cut/split.h"
#include "calot/mesh/parts.h"

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

// query_dofs, five of them added vertices where there are any.
std::vector<DofId> dofs_to_ask(const StiffnessChange& change, std::size_t vertices_after) {
  std::vector<DofId> dofs = query_dofs(change, vertices_after);
  const std::size_t added = std::min<std::size_t>(5, change.added.size());
  for (std::size_t k = 0; k < added; ++k)
    for (int axis = 0; axis < 3; ++axis)
      dofs[3 * k + static_cast<std::size_t>(axis)] = dof_of(change.added[k * change.added.size() / added], axis);
  return dofs;
}

struct CutDone {
  Compliance compliance;
  std::vector<DofId> dofs;  // that were asked for
};

CutDone measure(const Organ& organ, const TopologyEdit& edit, bool check, CutTimes& times) {
  CutDone done{precompute(organ.model), {}};
  Compliance& compliance = done.compliance;
  compliance.reserve_fold();
  Model model = organ.model;
  StiffnessChange change;
  UpdateReport report;
  Eigen::MatrixXd block;
  times.usable.push_back(seconds_of([&] {
    change = model.apply(edit);
    report = compliance.update(change);
    done.dofs = dofs_to_ask(change, model.mesh().vertex_count());
    block = compliance.block(done.dofs, done.dofs);
  }));
  times.rank = std::max(times.rank, report.rank);
  times.tets = std::max(times.tets, edit.removed.size());
  times.eigenvalue = std::min(times.eigenvalue, report.smallest_eigenvalue);
  if (check) {
    std::vector<DofId> asked = done.dofs;
    for (const VertexId v : change.added)
      for (int axis = 0; axis < 3; ++axis) asked.push_back(dof_of(v, axis));
    const Compliance reference = precompute(model, {Backend::sparse});
    times.error = std::max(times.error, worst_column(compliance, reference, asked));
    times.block_error = std::max(times.block_error, worst_block(block, reference, done.dofs));
    times.bound = std::max(times.bound, error_bound(reference));
  }
  return done;
}

// Splits of the duct where `transections` cuts it, each into two parts.
std::vector<SplitEdit> split_transections(const Organ& organ, std::size_t count) {
  std::vector<SplitEdit> splits;
  const std::size_t parts = face_connected_parts(organ.model.mesh()).count();
  for (std::size_t k = 0; k < count; ++k) {
    const double along = (0.3 + 0.4 * (static_cast<double>(k) + 0.5) / static_cast<double>(count) - 0.5) * organ.length;
    SplitEdit edit = split(organ.model.mesh(), Plane{organ.middle + along * organ.axis, organ.axis},
                           {.region = organ.duct, .fixed = organ.model.fixed()});
    TetMesh after = organ.model.mesh();
    apply(after, edit);
    if (face_connected_parts(after).count() > parts) splits.push_back(std::move(edit));
  }
  if (splits.empty()) throw FailedError("", "no plane across the duct's axis parts it", "use another mesh");
  return splits;
}

// PREFIXerror, of answers refined, and PREFIXblock_error, of those given at once.
void add_error_rows(const std::string& prefix, const CutTimes& times, const std::string& words,
                    std::vector<Row>& rows) {
  rows.push_back({.name = prefix + "error",
                  .value = times.error,
                  .unit = "1",
                  .baseline = "a refined recomputation, worst column, " + words,
                  .goal = times.bound});
  rows.push_back({.name = prefix + "block_error",
                  .value = times.block_error,
                  .unit = "1",
                  .baseline = "the same, for the block answered at once, not refined"});
}

// The same transections by splitting; `removing` has the times of removal.
std::vector<Row> split_rows(const Organ& organ, const BenchOptions& options, const CutTimes& removing) {
  const std::vector<SplitEdit> splits = split_transections(organ, 24);
  CutTimes times;
  std::size_t added = 0;
  if (options.progress) options.progress->phase("splitting");
  for (std::size_t k = 0; k < splits.size(); ++k) {
    measure(organ, splits[k], k % 4 == 0, times);
    added = std::max(added, splits[k].vertices.size());
    if (options.progress) options.progress->at(static_cast<double>(k + 1) / static_cast<double>(splits.size()));
  }
  Row usable = distribution_row("cut.split_usable", "ms", milliseconds(times.usable));
  usable.baseline = "cut.usable, which removes (" + std::to_string(times.tets) + " tets in pieces, " +
                    std::to_string(added) + " vertices more, rank " + std::to_string(times.rank) + ")";
  usable.ratio = *usable.p99 / (1e3 * distribution(removing.usable).p99);
  std::vector<Row> rows{usable};
  add_error_rows("cut.split_", times, "added vertices among them; the bound as above", rows);
  return rows;
}

}  // namespace

std::vector<Row> bench_cut(const BenchOptions& options) {
  const Organ organ = make_organ(options);
  const std::vector<Edit> cuts = transections(organ, 24);
  CutTimes times;
  if (options.progress) options.progress->phase("cutting");
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    CutDone done = measure(organ, cuts[k], k % 4 == 0, times);
    fold_under_queries(done.compliance, done.dofs, times);
    if (options.progress) options.progress->at(static_cast<double>(k + 1) / static_cast<double>(cuts.size()));
  }
  const std::vector<Row> of_splits = split_rows(organ, options, times);
  std::vector<double> in_memory;
  for (int k = 0; k < 3; ++k) in_memory.push_back(paper_in_memory(organ.model, cuts[cuts.size() / 2]));
  const double through_files = paper_through_files(organ.model, cuts[cuts.size() / 2]);

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
  Row eigenvalue = {.name = "cut.smallest_eigenvalue", .value = times.eigenvalue, .unit = "1"};
  std::vector<Row> rows{usable, fold, query, files};
  add_error_rows("cut.", times, "the bound is max(1e-9, 10 eps kappa)", rows);
  rows.push_back(eigenvalue);
  rows.insert(rows.end(), of_splits.begin(), of_splits.end());
  if (!options.model.empty()) return rows;
  const Organ small = make_organ_of_tets(options, 10000, 1.0 / 60);
  if (options.progress) options.progress->phase("cutting while simulating");
  const std::vector<Row> simulated = cut_rows(small, {0.3, 0.4, 0.5});
  rows.insert(rows.end(), simulated.begin(), simulated.end());
  return rows;
}

}  // namespace calot::bench
