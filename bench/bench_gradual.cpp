// A blade that goes on: ten tets a step, sixty steps, along the organ.
#include <Eigen/Geometry>
#include <algorithm>
#include <thread>

#include "bench/accuracy.h"
#include "bench/benchmarks.h"
#include "bench/organ.h"
#include "calot/base/error.h"
#include "calot/mesh/parts.h"

namespace calot::bench {
namespace {

constexpr std::size_t steps = 60, tets_a_step = 10;
// A fold starts when so many rows wait, and is adopted so many steps later: fixed, so that a replay has the same bits.
constexpr std::size_t fold_at_rank = 30, adopt_after = 22;

// The tets to remove, in the order in which one blade reaches them that lays the organ open lengthwise, from its bulk
// towards the duct (old numbers).
std::vector<std::vector<TetId>> blade_path(const Organ& organ) {
  const TetMesh& mesh = organ.model.mesh();
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : mesh.positions) centre += p / static_cast<double>(mesh.vertex_count());
  const Vec3 along = (organ.middle - centre).normalized();
  const Edit edit = cut(mesh, Plane{organ.middle, along.unitOrthogonal()});
  std::vector<std::pair<double, TetId>> reached;
  for (const TetId t : edit.removed) {
    double depth = 0;
    for (const VertexId v : mesh.tet(t)) depth += along.dot(mesh.position(v));
    reached.emplace_back(depth, t);
  }
  std::sort(reached.begin(), reached.end());
  if (reached.size() < steps * tets_a_step)
    throw FailedError("", "the plane meets " + std::to_string(reached.size()) + " tets, too few for 60 steps of 10",
                      "use a finer mesh");
  std::vector<std::vector<TetId>> path(steps);
  for (std::size_t k = 0; k < steps * tets_a_step; ++k) path[k / tets_a_step].push_back(reached[k].second);
  return path;
}

// Adds the crumbs that removing these tets leaves: pieces of a few tets, hanging on nothing or on a vertex or an edge.
// An operation would suck them away (`calot cut --clean`). Choosing what goes is not part of the step that is timed.
void add_crumbs(const TetMesh& mesh, TopologyEdit& edit) {
  constexpr std::size_t crumb = 30;
  TetMesh after = mesh;
  const Remap remap = apply(after, edit);
  const Parts parts = face_connected_parts(after);
  for (const std::vector<TetId>& piece : parts.tets)
    if (piece.size() <= crumb)
      for (const TetId t : piece) edit.removed.push_back(remap.tet_to_old[t.index()]);
  std::sort(edit.removed.begin(), edit.removed.end());
}

}  // namespace

std::vector<Row> bench_gradual(const BenchOptions& options) {
  const Organ organ = make_organ(options);
  const std::vector<std::vector<TetId>> path = blade_path(organ);
  Compliance compliance = precompute(organ.model);
  compliance.reserve_fold();  // Before the operation begins, as a simulation would.
  Model model = organ.model;
  std::vector<TetId> now(organ.model.mesh().tet_count());  // original tet → current
  for (std::size_t t = 0; t < now.size(); ++t) now[t] = TetId(t);
  std::vector<double> milliseconds, ranks;
  std::size_t folds = 0, fold_started = 0, removed = 0;
  bool folding = false;
  double smallest = 1, refreshed = 0;
  if (options.progress) options.progress->phase("cutting step by step");
  for (std::size_t s = 0; s < steps; ++s) {
    const auto frame_end = std::chrono::steady_clock::now() + std::chrono::microseconds(16667);
    TopologyEdit edit;
    for (const TetId t : path[s])
      if (now[t.index()].valid()) edit.removed.push_back(now[t.index()]);
    std::sort(edit.removed.begin(), edit.removed.end());
    add_crumbs(model.mesh(), edit);
    removed += edit.removed.size();
    StiffnessChange change;
    milliseconds.push_back(1e3 * seconds_of([&] {
                             change = model.apply(edit);
                             const UpdateReport report = compliance.update(change);
                             smallest = std::min(smallest, report.smallest_eigenvalue);
                             refreshed += report.refreshed;
                             const std::vector<DofId> dofs = query_dofs(change, model.mesh().vertex_count());
                             (void)compliance.block(dofs, dofs);
                             if (folding && s - fold_started >= adopt_after) {
                               compliance.adopt_fold();
                               folding = false;
                               ++folds;
                             }
                             if (!folding && compliance.pending_rank() >= fold_at_rank) {
                               compliance.start_fold();
                               folding = true;
                               fold_started = s;
                             }
                           }));
    ranks.push_back(static_cast<double>(compliance.pending_rank()));
    for (TetId& t : now)
      if (t.valid()) t = change.remap.tet_to_new[t.index()];
    if (options.progress) options.progress->at(static_cast<double>(s + 1) / steps);
    std::this_thread::sleep_until(frame_end);
  }
  const Compliance reference = precompute(model, {Backend::sparse});
  std::vector<DofId> dofs;
  for (std::size_t k = 0; k < 60; ++k)
    dofs.push_back(dof_of(VertexId(k * 7919 % model.mesh().vertex_count()), static_cast<int>(k % 3)));
  const double recompute = 1e3 * seconds_of([&] { (void)precompute(model); });
  Row step = distribution_row("gradual.step", "ms", milliseconds);
  step.baseline = "recomputing the matrix at each step";
  step.ratio = *step.p99 / recompute;
  step.goal = 2;
  Row error = {.name = "gradual.error",
               .value = worst_column(compliance, reference, dofs),
               .unit = "1",
               .baseline = "a refined recomputation after step 60, worst column; the bound is max(1e-9, 10 eps kappa)",
               .goal = error_bound(reference)};
  Row rank = distribution_row("gradual.pending_rank", "1", ranks);
  Row fold_count = {.name = "gradual.folds", .value = static_cast<double>(folds), .unit = "1"};
  Row tets = {.name = "gradual.tets_removed", .value = static_cast<double>(removed), .unit = "1"};
  Row anew = {.name = "gradual.computed_anew", .value = refreshed, .unit = "1"};
  Row probe = {.name = "gradual.probe", .value = compliance.probe(), .unit = "1"};
  Row eigenvalue = {.name = "gradual.smallest_eigenvalue", .value = smallest, .unit = "1"};
  return {step, error, rank, fold_count, tets, anew, probe, eigenvalue};
}

}  // namespace calot::bench
