#include "bench/benchmarks.h"

namespace calot::bench {

const std::vector<Bench>& benches() {
  static const std::vector<Bench> all = {
      {"precompute", "the whole compliance, dense and sparse, beside LAPACK's inverse of the same matrix",
       bench_precompute},
      {"cut",
       "a full transection of the duct: usable, folded, beside the paper's update; without --model, by scissors in a "
       "running operation too",
       bench_cut},
      {"gradual", "60 steps of 10 tets at 60 Hz, with folds in the background", bench_gradual},
      {"growth", "the sparse factor from 1,000 to 100,000 vertices", bench_growth},
      {"figure4", "the paper's figure 4: recomputed, paper and exact displacement, and how far they differ",
       bench_figure4},
      {"figure5", "the paper's figure 5: time to recompute and to update, six sizes of mesh", bench_figure5},
      {"step", "a step of an operation on 10,000 and 20,000 tets at real pace, by phases; preconditioned beside plain",
       bench_step},
      {"contact", "the friction problems of an operation, by us and by Siconos", bench_contact},
      {"haptics", "the 1 kHz loop pressing on a running operation: period, jitter, time of a tick", bench_haptics},
      {"view", "pictures on a processor that draws by itself, sending a surface, and the world's pace beside them",
       bench_view},
      {"patient", "from a CT of 512 x 512 x 300 voxels to a patient's folder", bench_patient},
      {"cohort", "twenty phantoms and every variant from CT to a checked folder, with a table", bench_cohort},
  };
  return all;
}

}  // namespace calot::bench
