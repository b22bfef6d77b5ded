// Example 2: a blade that advances through the duct in small steps, the compliance exact after each.
#include <calot/calot.h>

#include <chrono>
#include <iostream>

#include "sample_model.h"

using namespace calot;

int main() try {
  Model model = load_model(sample::model_file());
  Compliance compliance = precompute(model);

  // The blade is 2 mm long more at each step and comes from above, across the duct's axis.
  double slowest = 0;
  for (int step = 1; step <= 9; ++step) {
    const double depth = 0.002 * step;
    const BladePatch blade{.centre = {0.010, 0, 0.009 - depth / 2},
                           .normal = {1, 0, 0},
                           .along = {0, 0, -1},
                           .length = depth,
                           .width = 0.02};
    const Edit edit = cut(model.mesh(), blade, {.region = "cystic duct"});
    if (edit.empty()) continue;  // still in the air, or nothing left there

    const auto start = std::chrono::steady_clock::now();
    const UpdateReport report = compliance.update(model.apply(edit));
    const double ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    slowest = std::max(slowest, ms);
    std::cout << "step " << step << ": " << edit.removed.size() << " tets, rank " << report.rank << ", " << ms
              << " ms, " << face_connected_parts(model.mesh()).count() << " part(s)\n";
  }

  // Corrections pile up until they are folded in; the answers are the same before and after.
  compliance.fold();
  const double drift = compliance.probe();
  std::cout << "slowest step " << slowest << " ms; drift " << drift << '\n';
  return face_connected_parts(model.mesh()).count() == 2 && drift < 1e-9 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
