// How the sparse factor grows with the mesh, from a thousand to a hundred thousand vertices.
#include <cmath>

#include "bench/benchmarks.h"
#include "bench/organ.h"
#include "calot/base/memory.h"
#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"
#include "calot/compliance/sparse_factor.h"

namespace calot::bench {
namespace {

struct Sample {
  double vertices = 0, nonzeros = 0, flops = 0, analyse = 0, factor = 0, bytes = 0;
};

Sample measure(TetMesh mesh, Progress* progress) {
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  for (std::size_t v = 0; v < 25 && v < fixed.size(); ++v) fixed[v] = 1;
  const Model model(std::move(mesh), {{1, {}}}, std::move(fixed), {});
  const BlockMatrix a = model.step_stiffness();
  std::vector<std::uint8_t> active(a.rows());
  for (std::size_t v = 0; v < active.size(); ++v) active[v] = !model.is_fixed(VertexId(v));
  Sample sample;
  std::shared_ptr<const FactorPattern> pattern;
  sample.analyse = seconds_of([&] { pattern = std::make_shared<FactorPattern>(analyse(a, active)); });
  sample.vertices = static_cast<double>(model.mesh().vertex_count());
  sample.nonzeros = pattern->nonzeros;
  sample.flops = pattern->flops;
  if (progress) progress->phase("factoring " + std::to_string(model.mesh().vertex_count()) + " vertices");
  sample.factor = seconds_of([&] { (void)SparseFactor(pattern, a, active, {}, progress); });
  sample.bytes = static_cast<double>(peak_memory());
  return sample;
}

// The slope of log y over log x, least squares.
double exponent(const std::vector<Sample>& samples, double Sample::*value) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Sample& s : samples) {
    const double x = std::log(s.vertices), y = std::log(s.*value);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const auto n = static_cast<double>(samples.size());
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

// Flops a second of dgemm on all cores, one call on each, 2048 a side.
double gemm_rate() {
  constexpr std::size_t n = 2048;
  const auto threads = static_cast<std::size_t>(thread_count());
  std::vector<std::vector<double>> a(threads, std::vector<double>(n * n, 0.5)), b = a, c = a;
  const auto all = [&] {
    parallel_for(threads, [&](std::size_t t) {
      blas::gemm('N', 'N', n, n, n, 1, a[t].data(), n, b[t].data(), n, 0, c[t].data(), n);
    });
  };
  blas::use_one_thread();
  all();
  double best = 1e300;
  for (int k = 0; k < 5; ++k) best = std::min(best, seconds_of(all));
  return 2.0 * n * n * n * static_cast<double>(threads) / best;
}

void add_rows(std::vector<Row>& rows, const std::string& shape, const std::vector<Sample>& samples) {
  rows.push_back({.name = "growth." + shape + ".nonzeros",
                  .value = exponent(samples, &Sample::nonzeros),
                  .unit = "exponent",
                  .goal = 1.45});
  rows.push_back({.name = "growth." + shape + ".flops",
                  .value = exponent(samples, &Sample::flops),
                  .unit = "exponent",
                  .goal = 2.05});
  for (const Sample& s : samples)
    rows.push_back({.name = "growth." + shape + "." + std::to_string(static_cast<long>(s.vertices)) + ".factor",
                    .value = s.factor,
                    .unit = "s",
                    .baseline = "analysis of the same mesh (" + std::to_string(s.nonzeros / 1e6) + " M non-zeros, " +
                                std::to_string(s.flops / 1e9) + " Gflop)",
                    .ratio = s.factor / s.analyse});
}

}  // namespace

std::vector<Row> bench_growth(const BenchOptions& options) {
  const double before = gemm_rate();
  std::vector<Sample> compact, tree;
  for (const std::size_t n : {1000, 2000, 5000, 10000, 20000, 50000, 100000}) {
    tree.push_back(measure(duct_tree(n), options.progress));
    compact.push_back(measure(compact_organ(n), options.progress));
  }
  const double rate = 0.5 * (before + gemm_rate());
  std::vector<Row> rows;
  add_rows(rows, "compact", compact);
  add_rows(rows, "tree", tree);
  const Sample& largest = compact.back();
  rows.push_back({.name = "growth.100k.seconds", .value = largest.factor, .unit = "s", .goal = 60});
  rows.push_back({.name = "growth.100k.memory", .value = largest.bytes / 1e9, .unit = "GB", .goal = 6});
  // A rate is given as a period, so that lower is better: seconds a Gflop, at most 1/0.6 of dgemm's.
  rows.push_back({.name = "growth.100k.seconds_per_gflop",
                  .value = largest.factor / (largest.flops / 1e9),
                  .unit = "s",
                  .baseline = "dgemm on the same cores in the same run (" + std::to_string(rate / 1e9) + " Gflop/s)",
                  .ratio = largest.factor / largest.flops * rate,
                  .goal_ratio = 1 / 0.6});
  return rows;
}

}  // namespace calot::bench
