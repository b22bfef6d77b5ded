// Example 5: no pause. After a cut the compliance answers at once from its corrections; a background thread folds them
// in meanwhile, and the result is adopted at a step fixed beforehand, never "when ready", so that a run can be
// repeated.
#include <calot/calot.h>

#include <iostream>

#include "sample_model.h"

using namespace calot;

int main() try {
  Model model = load_model(sample::model_file());
  Compliance compliance = precompute(model);

  // What a contact would ask for: the block of the compliance of a few touched vertices.
  std::vector<DofId> touched;
  for (const int v : {12, 40, 77})
    for (int axis = 0; axis < 3; ++axis) touched.push_back(dof_of(VertexId(v), axis));

  constexpr int cut_at = 5, adopt_at = 12, steps = 20;
  Eigen::MatrixXd before_adoption;
  double difference = 0;
  for (int step = 0; step < steps; ++step) {
    if (step == cut_at) {
      const Edit edit = cut(model.mesh(), Plane{{0.010, 0, 0}, {1, 0, 0}}, {.region = "cystic duct"});
      compliance.update(model.apply(edit));
      compliance.start_fold();
    }
    if (step == adopt_at) compliance.adopt_fold();  // waits if the thread is late
    const Eigen::MatrixXd block = compliance.block(touched, touched);
    if (step == cut_at) before_adoption = block;
    if (step > cut_at) difference = std::max(difference, (block - before_adoption).norm() / block.norm());
    std::cout << "step " << step << ": " << compliance.pending_rank() << " dofs wait to be folded\n";
  }
  std::cout << "the answer changed by " << difference << " when the fold was adopted\n";
  return compliance.pending_rank() == 0 && difference < 1e-9 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
