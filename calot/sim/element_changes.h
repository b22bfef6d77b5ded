// What an edit does to Â, tet by tet.
#pragma once
#include "calot/sim/warped_compliance.h"

namespace calot {

/// The tets whose share of Â an edit changes, in numbers before it, ascending: removed ones and those around moved
/// vertices.
struct ChangedTets {
  std::vector<TetId> removed, reshaped;
};
ChangedTets changed_tets(const TopologyEdit& edit, const VertexTets& around);

/// Â_e of one tet in the rest frame: a quarter of its mass on each vertex, and its stiffness [N/m].
Mat12 step_stiffness_of(const Model& model, TetId tet);

/// Their shares before the edit …
std::vector<ElementChange> leaving(const Model& before, const ChangedTets& changed);
/// … and after it, pieces included; appended to `changes`.
void add_entering(const Model& after, const Remap& remap, const ChangedTets& changed,
                  std::vector<ElementChange>& changes);

}  // namespace calot
