// Transections while everything goes on: what a frame costs in which the mesh is cut, beside the paper's pause.
#include <algorithm>

#include "bench/accuracy.h"
#include "bench/simulation_rows.h"
#include "bench/three_ways.h"
#include "calot/base/error.h"
#include "calot/mesh/parts.h"

namespace calot::bench {
namespace {

constexpr std::size_t before = 10, after = 40;  // paced steps around the cut

struct Transection {
  PacedRun run;
  std::vector<double> with_cut, from_first_cut;  // frames [s]
  std::vector<double> follow;                    // Compliance::update for a step's changes [s]
  double error = 0, bound = 0;
  bool severed = false;
  std::size_t tets = 0;  // removed, or replaced by their pieces
};

// The body and what is held lie in different parts.
bool severed(const Operation& operation) {
  const TetMesh& mesh = operation.world().model().mesh();
  const Parts parts = face_connected_parts(mesh);
  std::vector<std::uint8_t> held(mesh.vertex_count(), 0);
  for (const std::vector<VertexId>& part : parts.vertices)
    if (std::any_of(part.begin(), part.end(), [&](VertexId v) { return operation.world().model().is_fixed(v); }))
      for (const VertexId v : part) held[v.index()] = 1;
  const std::vector<VertexId>& body = operation.body_vertices();
  return std::none_of(body.begin(), body.end(), [&](VertexId v) { return held[v.index()] != 0; });
}

// The exact compliance, led through everything that the world did, against a recomputation.
void follow_exactly(const Model& uncut, const std::vector<std::vector<StiffnessChange>>& changes, const Model& cut,
                    Transection& result) {
  Compliance compliance = precompute(uncut);
  const StiffnessChange* last = nullptr;
  for (const std::vector<StiffnessChange>& step : changes) {
    if (step.empty()) continue;
    result.follow.push_back(seconds_of([&] {
      for (const StiffnessChange& change : step) compliance.update(change);
    }));
    last = &step.back();
    if (compliance.pending_rank() > 400) compliance.fold();
  }
  if (!last) return;
  const Compliance reference = precompute(cut, {Backend::sparse});
  result.error = worst_column(compliance, reference, query_dofs(*last, cut.mesh().vertex_count()));
  result.bound = error_bound(reference);
}

Transection transect(const Organ& organ, double share) {
  Transection result;
  Operation operation(organ, {}, true);
  warm_up(operation);
  const Model uncut = operation.world().model();
  std::vector<std::vector<StiffnessChange>> changes;
  std::vector<std::uint8_t> cuts;
  const auto look = [&] {
    changes.push_back(operation.world().changes());
    bool cut = false;
    for (const WorldEvent& event : operation.world().events()) cut = cut || event.kind == EventKind::cut;
    cuts.push_back(cut ? 1 : 0);
  };
  const auto append = [&](const PacedRun& more) {
    result.run.frames.insert(result.run.frames.end(), more.frames.begin(), more.frames.end());
    result.run.reports.insert(result.run.reports.end(), more.reports.begin(), more.reports.end());
  };
  append(run_paced(operation, before, look));
  constexpr int most_strokes = 3;  // what slipped past the blades is cut by the next
  for (int stroke = 0; stroke < most_strokes && !severed(operation); ++stroke) {
    operation.begin_cut(share);
    append(run_paced(operation, Operation::approach + Operation::closing + after, look));
  }
  bool begun = false;
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    begun = begun || cuts[k];
    if (cuts[k]) result.with_cut.push_back(result.run.frames[k]);
    if (begun) result.from_first_cut.push_back(result.run.frames[k]);
    for (const StiffnessChange& change : changes[k])
      result.tets +=
          static_cast<std::size_t>(std::count(change.remap.tet_to_new.begin(), change.remap.tet_to_new.end(), TetId()));
  }
  result.severed = severed(operation);
  if (result.with_cut.empty())
    throw FailedError("bench cut", "the scissors cut nothing at " + std::to_string(share) + " of the duct's length",
                      "use a finer mesh");
  follow_exactly(uncut, changes, operation.world().model(), result);
  return result;
}

}  // namespace

std::vector<Row> cut_rows(const Organ& organ, const std::vector<double>& shares) {
  std::vector<double> with_cut, from_first_cut, edits, follow;
  PacedRun all;
  double error = 0, bound = 0;
  std::size_t tets = 0, whole = 0;
  for (const double share : shares) {
    const Transection one = transect(organ, share);
    whole += one.severed ? 0 : 1;
    with_cut.insert(with_cut.end(), one.with_cut.begin(), one.with_cut.end());
    from_first_cut.insert(from_first_cut.end(), one.from_first_cut.begin(), one.from_first_cut.end());
    follow.insert(follow.end(), one.follow.begin(), one.follow.end());
    for (const StepReport& report : one.run.reports)
      if (const double s = report.seconds[static_cast<std::size_t>(Phase::edits)]; s > 0.2e-3) edits.push_back(s);
    all.frames.insert(all.frames.end(), one.run.frames.begin(), one.run.frames.end());
    all.reports.insert(all.reports.end(), one.run.reports.begin(), one.run.reports.end());
    error = std::max(error, one.error);
    bound = std::max(bound, one.bound);
    tets = std::max(tets, one.tets);
  }
  const Organ uncut = organ_of(Operation(organ, {}).world().model());
  const std::vector<Edit> planes = transections(uncut, 5);
  const Edit& plane = planes[planes.size() / 2];
  const double files = 1e3 * paper_through_files(uncut.model, plane),
               memory = 1e3 * paper_in_memory(uncut.model, plane);
  Row frame = distribution_row("cut.while_simulating", "ms", milliseconds(with_cut));
  frame.baseline = "the paper's pause, its file rewritten and reloaded; " + words_of(organ, {}) + ", " +
                   std::to_string(with_cut.size()) + " frames with a cut, " + std::to_string(shares.size()) +
                   " transections, up to " + std::to_string(tets) + " tets parted";
  frame.ratio = *frame.p99 / files;
  frame.goal = 16.7;
  Row in_memory = frame;
  in_memory.name += ".in_memory";
  in_memory.baseline = "the paper's Algorithms 1 and 2 in memory, where nothing is read, written or reloaded";
  in_memory.ratio = *frame.p99 / memory;
  in_memory.goal.reset();
  Row transection = distribution_row("cut.while_simulating.transection", "ms", milliseconds(from_first_cut));
  transection.value = *transection.max;
  transection.baseline = "(every frame from the first cut to 40 after the blades are closed)";
  transection.goal = 16.7;
  std::vector<Row> rows{frame, in_memory, transection};
  rows.push_back({.name = "cut.while_simulating.not_severed",
                  .value = static_cast<double>(whole),
                  .unit = "1",
                  .baseline = "all transections",
                  .ratio = static_cast<double>(whole) / static_cast<double>(shares.size()),
                  .goal = 0});
  std::vector<Row> paced = paced_rows("cut.operation", all, 0);
  rows.insert(rows.end(), paced.begin(), paced.end());
  rows.push_back(distribution_row("cut.edit", "ms", milliseconds(edits)));
  rows.push_back(distribution_row("cut.follow", "ms", milliseconds(follow)));
  rows.push_back({.name = "cut.while_simulating.error",
                  .value = error,
                  .unit = "1",
                  .baseline =
                      "the compliance led through every change of the run, against a refined recomputation after "
                      "the last, worst column; the bound is max(1e-9, 10 eps kappa)",
                  .goal = bound});
  return rows;
}

}  // namespace calot::bench
