// What of the tissue changes from step to step.
#pragma once
#include <vector>

#include "calot/mesh/topology_edit.h"

namespace calot {

struct TissueState {
  std::vector<Vec3> positions;   ///< n, where each vertex is [m]
  std::vector<Vec3> velocities;  ///< n [m/s]
};

/// A vertex of the mesh after an edit gets what belongs to it: survivors keep theirs, a moved vertex takes the value at
/// its new place on its edge, an added one the value between its two origins.
template <class T>
std::vector<T> carry_over(const std::vector<T>& before, const Remap& remap) {
  std::vector<T> after(remap.vertex_to_old.size());
  for (std::size_t v = 0; v < after.size(); ++v)
    if (remap.vertex_to_old[v].valid()) after[v] = before[remap.vertex_to_old[v].index()];
  const auto between = [&](VertexId a, VertexId b, double weight) {
    return T(before[a.index()] + weight * (before[b.index()] - before[a.index()]));
  };
  for (const MovedVertex& m : remap.moved)
    if (const VertexId now = remap.vertex_to_new[m.vertex.index()]; now.valid())
      after[now.index()] = between(m.vertex, m.to, m.weight);
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k)
    after[remap.added_vertices[k].index()] =
        between(remap.added_from[k].from, remap.added_from[k].to, remap.added_from[k].weight);
  return after;
}

}  // namespace calot
