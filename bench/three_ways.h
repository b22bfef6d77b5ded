// One cut, three answers: recomputed, by the paper's update, and exactly.
#pragma once
#include "bench/organ.h"
#include "calot/compliance/compliance.h"

namespace calot::bench {

struct ThreeWays {
  Model after;  ///< the cut model
  StiffnessChange change;
  Compliance recomputed, exact;
  FullCompliance paper;
  double recompute_seconds = 0;  ///< from the mesh
  double paper_seconds = 0;      ///< Algorithms 1 and 2 in memory
  double exact_seconds = 0;      ///< until a block of 60 dofs is answered
};

ThreeWays cut_three_ways(const Model& model, const Edit& edit, Progress* progress);

/// Algorithms 1 and 2 on the model's matrix in memory [s].
double paper_in_memory(const Model& model, const Edit& edit);

/// The paper's whole way: SOFA's file is read, updated, written, and read again as the scene is reloaded [s].
double paper_through_files(const Model& model, const Edit& edit);

}  // namespace calot::bench
