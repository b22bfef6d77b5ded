#include "calot/sim/element_changes.h"

#include <algorithm>

namespace calot {

ChangedTets changed_tets(const TopologyEdit& edit, const VertexTets& around) {
  ChangedTets changed{edit.removed, {}};
  for (const MovedVertex& m : edit.moved)
    for (std::uint32_t k = around.start[m.vertex.index()]; k < around.start[m.vertex.index() + 1]; ++k)
      changed.reshaped.push_back(around.tets[k]);
  std::sort(changed.reshaped.begin(), changed.reshaped.end());
  changed.reshaped.erase(std::unique(changed.reshaped.begin(), changed.reshaped.end()), changed.reshaped.end());
  std::erase_if(changed.reshaped,
                [&](TetId t) { return std::binary_search(edit.removed.begin(), edit.removed.end(), t); });
  return changed;
}

Mat12 step_stiffness_of(const Model& model, TetId t) {
  const TetMesh& mesh = model.mesh();
  const Tet& tet = mesh.tet(t);
  const TetShape shape =
      tet_shape(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
  Mat12 stiffness_of_step = model.dynamics().stiffness_factor() * stiffness(shape, model.lame_of(t));
  stiffness_of_step.diagonal().array() += model.dynamics().mass_factor() * model.material(t).density * shape.volume / 4;
  return stiffness_of_step;
}

std::vector<ElementChange> leaving(const Model& before, const ChangedTets& changed) {
  std::vector<ElementChange> changes;
  for (const std::vector<TetId>* tets : {&changed.removed, &changed.reshaped})
    for (const TetId t : *tets) changes.push_back({before.mesh().tet(t), step_stiffness_of(before, t), t, false});
  return changes;
}

void add_entering(const Model& after, const Remap& remap, const ChangedTets& changed,
                  std::vector<ElementChange>& changes) {
  for (const TetId old : changed.reshaped) {
    const TetId t = remap.tet_to_new[old.index()];
    changes.push_back({after.mesh().tet(t), step_stiffness_of(after, t), old, true});
  }
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k) {
    const TetId t = remap.added_tets[k];
    changes.push_back({after.mesh().tet(t), step_stiffness_of(after, t), remap.added_parents[k], true});
  }
}

}  // namespace calot
