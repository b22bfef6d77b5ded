// The paper's Fig. 4: the same cut by recomputation, by the paper's update and exactly, and how far they differ.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/compliance/compliance.h"
#include "calot/cut/cut.h"

namespace calot {

struct MethodResult {
  std::string name;
  double seconds = 0;  ///< until the compliance after the cut is usable
  Displacements u;     ///< [m], every vertex of the cut mesh
  Distance distance;   ///< from the recomputation
};

struct Comparison {
  TetMesh mesh;  ///< after the cut
  Edit edit;
  double peak = 0;                      ///< largest recomputed displacement [m]
  std::array<MethodResult, 3> methods;  ///< recompute, paper, exact
};

/// Cuts the model by the three methods and loads it with forces on vertices of the uncut mesh.
/// Throws InputError where a force is on a vertex that the cut removes; FailedError as `calot cut` does.
Comparison compare(const Model& model, const std::vector<Blade>& blades, const CutOptions& options,
                   std::vector<PointForce> forces, Progress* progress);

}  // namespace calot
