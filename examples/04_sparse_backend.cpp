// Example 4: the same questions to two homes of the compliance. The dense one holds the whole matrix, so that any block
// is there at once; the sparse one holds the factor, a hundredth of the memory, and makes columns on demand.
#include <calot/calot.h>

#include <iostream>

#include "sample_model.h"

using namespace calot;

int main() try {
  const Model whole = load_model(sample::model_file());
  const Edit edit = cut(whole.mesh(), Plane{{0.010, 0, 0}, {1, 0, 0}}, {.region = "cystic duct"});

  std::vector<Displacements> answers;
  for (const Backend backend : {Backend::dense, Backend::sparse}) {
    Model model = whole;  // a value: each backend cuts its own
    Compliance compliance = precompute(model, {.backend = backend});
    const double megabytes = static_cast<double>(compliance.bytes()) / 1e6;
    compliance.update(model.apply(edit));
    answers.push_back(compliance.solve({{VertexId{12}, {0, -0.5, 0}}}));
    std::cout << (backend == Backend::dense ? "dense:  " : "sparse: ") << megabytes << " MB before the cut\n";
  }

  double largest = 0, difference = 0;
  for (std::size_t v = 0; v < answers[0].size(); ++v) {
    largest = std::max(largest, answers[0][v].norm());
    difference = std::max(difference, (answers[0][v] - answers[1][v]).norm());
  }
  std::cout << "they differ by " << difference / largest << " of the largest displacement\n";
  return difference <= 1e-9 * largest ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
