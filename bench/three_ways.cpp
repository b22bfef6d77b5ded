#include "bench/three_ways.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "calot/compliance/compliance_file.h"

namespace calot::bench {

ThreeWays cut_three_ways(const Model& model, const Edit& edit, Progress* progress) {
  Compliance exact = precompute(model, {}, progress);
  FullCompliance paper = exact.full();
  Model after = model;
  StiffnessChange change;
  const double exact_seconds = seconds_of([&] {
    change = after.apply(edit);
    exact.update(change);
    const std::vector<DofId> dofs = query_dofs(change, after.mesh().vertex_count());
    (void)exact.block(dofs, dofs);
  });
  const double paper_seconds = seconds_of([&] { paper_update(paper, change.struck, after.mesh()); });
  const Stopwatch watch;
  Compliance recomputed = precompute(after, {}, progress);
  const double recompute_seconds = watch.seconds();
  return {std::move(after), std::move(change), std::move(recomputed), std::move(exact),
          std::move(paper), recompute_seconds, paper_seconds,         exact_seconds};
}

double paper_in_memory(const Model& model, const Edit& edit) {
  FullCompliance full = precompute(model).full();
  Model after = model;
  const StiffnessChange change = after.apply(edit);
  return seconds_of([&] { paper_update(full, change.struck, after.mesh()); });
}

double paper_through_files(const Model& model, const Edit& edit) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("calot-bench-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const double h = model.dynamics().time_step;
  write_comp(folder / "before.comp", precompute(model).full(), h);
  Model after = model;
  const StiffnessChange change = after.apply(edit);
  const double seconds = seconds_of([&] {
    FullCompliance full = read_comp(folder / "before.comp", model.mesh().vertex_count(), h);
    paper_update(full, change.struck, after.mesh());
    write_comp(folder / "after.comp", full, h);
    (void)read_comp(folder / "after.comp", full.vertices, h);
  });
  std::filesystem::remove_all(folder);
  return seconds;
}

}  // namespace calot::bench
