#include "app/comparison.h"

#include <algorithm>
#include <cmath>

#include "app/full_matrix.h"
#include "app/stopwatch.h"
#include "calot/base/error.h"

namespace calot {
namespace {

void renumber(std::vector<PointForce>& forces, const Remap& remap) {
  for (PointForce& force : forces) {
    const VertexId before = force.vertex;
    force.vertex = remap.vertex_to_new[before.index()];
    if (!force.vertex.valid())
      throw InputError("--force", "vertex " + std::to_string(before.value) + " is removed by the cut",
                       "choose one that stays");
  }
}

MethodResult by_paper(FullCompliance compliance, const Remap& remap, const TetMesh& mesh,
                      const std::vector<PointForce>& forces) {
  Stopwatch watch;
  paper_update(compliance, remap.orphaned, mesh);
  const double seconds = watch.lap();
  return {"paper", seconds, multiply(compliance, forces), {}};
}

MethodResult exactly(Compliance& compliance, const StiffnessChange& change, const std::vector<PointForce>& forces) {
  Stopwatch watch;
  compliance.update(change);
  const double seconds = watch.lap();
  return {"exact", seconds, compliance.solve(forces), {}};
}

MethodResult recomputed(const Model& model, const std::vector<PointForce>& forces, Progress* progress) {
  Stopwatch watch;
  const Compliance compliance = precompute(model, {}, progress);
  const double seconds = watch.lap();
  return {"recompute", seconds, compliance.solve(forces), {}};
}

}  // namespace

Comparison compare(const Model& model, const std::vector<Blade>& blades, const CutOptions& options,
                   std::vector<PointForce> forces, Progress* progress) {
  Comparison comparison;
  comparison.edit = cut(model.mesh(), blades, options);
  if (comparison.edit.removed.size() == model.mesh().tet_count())
    throw FailedError("", "the cut removes every tetrahedron, so nothing is left", "cut less");
  Model after = model;
  const StiffnessChange change = after.apply(comparison.edit);
  if (!change.unsupported.empty())
    throw Unsupported("", "the cut leaves a static part without support: " + change.unsupported,
                      "fix it in the model, or use a time_step > 0");
  renumber(forces, change.remap);
  comparison.mesh = after.mesh();
  {
    // One matrix goes before the next comes: at most two are held at once.
    Compliance compliance = precompute(model, {}, progress);
    comparison.methods[1] = by_paper(compliance.full(), change.remap, after.mesh(), forces);
    comparison.methods[2] = exactly(compliance, change, forces);
  }
  comparison.methods[0] = recomputed(after, forces, progress);
  const Displacements& truth = comparison.methods[0].u;
  for (MethodResult& method : comparison.methods) method.distance = distance_between(method.u, truth);
  for (const Vec3& u : truth) comparison.peak = std::max(comparison.peak, u.norm());
  return comparison;
}

}  // namespace calot
