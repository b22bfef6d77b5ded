// Example 1: load an organ, precompute its compliance, cut it, and ask how it moves.
//
//   01_cut [model.toml]     without an argument, a small organ is made
#include <calot/calot.h>

#include <iostream>

#include "sample_model.h"

using namespace calot;

int main(int argc, char** argv) try {
  const auto path = argc > 1 ? std::filesystem::path(argv[1]) : sample::model_file();

  // The whole of it. Everything is in SI: metres, newtons, pascals.
  Model model = load_model(path);
  Compliance compliance = precompute(model);  // about a second
  Edit edit = cut(model.mesh(), Plane{{0.010, 0, 0}, {1, 0, 0}}, {.region = "cystic duct"});
  compliance.update(model.apply(edit));                                // exact, milliseconds
  Displacements u = compliance.solve({{VertexId{12}, {0, -0.5, 0}}});  // [m], every vertex

  // What came of it. The force pulls at the gallbladder; the duct is severed, so only that side follows.
  std::cout << edit.removed.size() << " tets removed, " << face_connected_parts(model.mesh()).count() << " parts\n";
  std::cout << "vertex 12 moves by " << 1e3 * u[12].norm() << " mm\n";
  return edit.removed.empty() || !(u[12].norm() > 0) ? 1 : 0;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
