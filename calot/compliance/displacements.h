// Forces, displacements, and how far two displacement fields are apart.
#pragma once
#include <vector>

#include "calot/compliance/full_compliance.h"

namespace calot {

/// A force [N] on one vertex.
struct PointForce {
  VertexId vertex;
  Vec3 force;
};
/// Displacement of every vertex [m], n; zero at fixed ones.
using Displacements = std::vector<Vec3>;

/// u = C f of a whole matrix as it stands, not refined. Throws InputError for a vertex out of range.
Displacements multiply(const FullCompliance& compliance, const std::vector<PointForce>& forces);

/// Distances between two displacement fields over all vertices [m], as in the paper's figure 4.
struct Distance {
  double max = 0, mean = 0, std = 0;
};
Distance distance_between(const Displacements& a, const Displacements& b);

}  // namespace calot
