// The paper's figure 5: time to recompute the compliance and to update it, for six sizes of mesh.
#include <algorithm>
#include <cstdio>

#include "bench/benchmarks.h"
#include "bench/plot.h"
#include "bench/three_ways.h"

namespace calot::bench {
namespace {

// SOFA v26.06 on a 2-core machine, tube meshes, E 1 MPa, ν 0.45, 10 ms [s]: measured by others than this program and
// quoted, not measured here. The default's last two are extrapolated.
struct Quoted {
  std::size_t vertices;
  double conjugate_gradients, sparse_ldl, precomputed_solver;
};
constexpr Quoted quoted[] = {{140, 4.3, 0.42, 0.022}, {399, 58.9, 5.3, 0.145}, {407, 66.8, 5.6, 0.126},
                             {961, 608, 67.8, 1.13},  {1918, 3600, 595, 6.43}, {2442, 6700, 1177, 12.5}};

struct Sample {
  std::size_t wanted = 0, vertices = 0, tets = 0;
  double recompute = 0, paper = 0, files = 0, exact = 0;
};

Sample measure(std::size_t vertices, const BenchOptions& options) {
  const Organ organ = make_organ(options, vertices);
  const std::vector<Edit> cuts = transections(organ, 5);
  const Edit& edit = cuts[cuts.size() / 2];
  std::vector<double> recompute, paper, exact;
  for (int k = 0; k < 5; ++k) {
    const ThreeWays ways = cut_three_ways(organ.model, edit, options.progress);
    recompute.push_back(ways.recompute_seconds);
    paper.push_back(ways.paper_seconds);
    exact.push_back(ways.exact_seconds);
  }
  return {vertices,
          organ.model.mesh().vertex_count(),
          organ.model.mesh().tet_count(),
          distribution(recompute).p50,
          distribution(paper).p50,
          paper_through_files(organ.model, edit),
          distribution(exact).p50};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void write_figure(const std::filesystem::path& folder, const std::vector<Sample>& samples) {
  std::filesystem::create_directories(folder);
  std::vector<std::vector<std::string>> rows;
  Plot plot{.title = "Time until the compliance after a cut can be used",
            .x_label = "vertices",
            .y_label = "seconds",
            .log_x = true,
            .log_y = true};
  PlotSeries recompute{.title = "recomputed"}, paper{.title = "paper's update, in memory"},
      files{.title = "paper's way: file and reload"}, exact{.title = "exact update"},
      sofa{.title = "SOFA recomputing, default (quoted; last two extrapolated)"},
      ldl{.title = "SOFA recomputing, LDL (quoted)"},
      solver{.title = "SOFA recomputing, PrecomputedLinearSolver (quoted)"};
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Sample& s = samples[k];
    const auto x = static_cast<double>(s.vertices);
    for (PlotSeries* series : {&recompute, &paper, &files, &exact}) series->x.push_back(x);
    recompute.y.push_back(s.recompute);
    paper.y.push_back(s.paper);
    files.y.push_back(s.files);
    exact.y.push_back(s.exact);
    rows.push_back({std::to_string(s.wanted), std::to_string(s.vertices), std::to_string(s.tets), number(s.recompute),
                    number(s.paper), number(s.files), number(s.exact), number(quoted[k].conjugate_gradients),
                    number(quoted[k].sparse_ldl), number(quoted[k].precomputed_solver)});
  }
  for (const Quoted& q : quoted) {
    for (PlotSeries* series : {&sofa, &ldl, &solver}) series->x.push_back(static_cast<double>(q.vertices));
    sofa.y.push_back(q.conjugate_gradients);
    ldl.y.push_back(q.sparse_ldl);
    solver.y.push_back(q.precomputed_solver);
  }
  plot.series = {recompute, files, paper, exact, sofa, ldl, solver};
  write_plot(folder / "figure5", plot);
  write_csv(folder / "figure5.csv",
            {"paper_vertices", "vertices", "tets", "recompute_s", "paper_update_in_memory_s", "paper_rewrite_reload_s",
             "exact_usable_s", "sofa_default_s_quoted", "sofa_ldl_s_quoted", "sofa_precomputed_linear_solver_s_quoted"},
            rows);
}

}  // namespace

std::vector<Row> bench_figure5(const BenchOptions& options) {
  BenchOptions phantom = options;
  phantom.model.clear();  // Six sizes of one organ: a single model would not do.
  std::vector<Sample> samples;
  for (const Quoted& q : quoted) samples.push_back(measure(q.vertices, phantom));
  if (!options.output.empty()) write_figure(options.output, samples);
  std::vector<Row> rows;
  for (const Sample& s : samples) {
    const std::string name = "figure5." + std::to_string(s.wanted) + ".",
                      size = std::to_string(s.vertices) + " vertices, " + std::to_string(s.tets) + " tets";
    rows.push_back({.name = name + "recompute",
                    .value = s.recompute,
                    .unit = "s",
                    .baseline = "SOFA's quickest way, quoted (" + size + ")",
                    .ratio = s.recompute / quoted[&s - samples.data()].precomputed_solver});
    rows.push_back({.name = name + "paper_in_memory",
                    .value = s.paper,
                    .unit = "s",
                    .baseline = "recomputing",
                    .ratio = s.paper / s.recompute});
    rows.push_back({.name = name + "paper_rewrite_reload",
                    .value = s.files,
                    .unit = "s",
                    .baseline = "recomputing",
                    .ratio = s.files / s.recompute});
    rows.push_back({.name = name + "exact",
                    .value = s.exact,
                    .unit = "s",
                    .baseline = "the paper's update in memory",
                    .ratio = s.exact / s.paper});
  }
  return rows;
}

}  // namespace calot::bench
