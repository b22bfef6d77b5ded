// How long the compliance takes, beside LAPACK's dense inverse of the same matrix.
#include <fstream>

#include "bench/benchmarks.h"
#include "bench/organ.h"
#include "calot/base/memory.h"
#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"
#include "calot/compliance/compliance.h"

namespace calot::bench {
namespace {

// Â over the free dofs as LAPACK wants it.
std::vector<double> dense_stiffness(const Model& model, std::size_t& n) {
  const BlockMatrix a = model.step_stiffness();
  std::vector<std::int64_t> row(a.rows(), -1);
  n = 0;
  for (std::size_t v = 0; v < a.rows(); ++v)
    if (!model.is_fixed(VertexId(v))) row[v] = static_cast<std::int64_t>(n), n += 3;
  std::vector<double> dense(n * n, 0.0);
  for (std::size_t v = 0; v < a.rows(); ++v)
    for (std::uint32_t k = a.row_start[v]; k < a.row_start[v + 1]; ++k) {
      const std::size_t u = a.column[k];
      if (row[v] < 0 || row[u] < 0) continue;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          dense[(static_cast<std::size_t>(row[u]) + static_cast<std::size_t>(j)) * n +
                static_cast<std::size_t>(row[v]) + static_cast<std::size_t>(i)] = a.block[k](i, j);
    }
  return dense;
}

double lapack_seconds(const Model& model, int threads) {
  std::size_t n = 0;
  std::vector<double> a = dense_stiffness(model, n);
  blas::set_threads(threads);
  const double seconds = seconds_of([&] {
    blas::potrf(n, a.data(), n);
    blas::potri(n, a.data(), n);
  });
  blas::set_threads(1);
  return seconds;
}

// Peak bytes held while `work` runs, beyond what was held before.
std::uint64_t peak_of(const std::function<void()>& work) {
  std::ofstream("/proc/self/clear_refs") << "5";  // resets the peak to what is held now
  const std::uint64_t before = peak_memory();
  work();
  const std::uint64_t peak = peak_memory();
  return peak - std::min(before, peak);
}

}  // namespace

std::vector<Row> bench_precompute(const BenchOptions& options) {
  const Organ organ = make_organ(options);
  std::vector<double> dense, sparse;
  std::uint64_t matrix = 0;
  for (int k = 0; k < 5; ++k) dense.push_back(seconds_of([&] { matrix = precompute(organ.model).bytes(); }));
  for (int k = 0; k < 5; ++k) sparse.push_back(seconds_of([&] { (void)precompute(organ.model, {Backend::sparse}); }));
  const std::uint64_t peak = peak_of([&] { (void)precompute(organ.model); });
  const double one = lapack_seconds(organ.model, 1), all = lapack_seconds(organ.model, thread_count());

  const std::string vertices = std::to_string(organ.model.mesh().vertex_count()) + " vertices";
  Row row = distribution_row("precompute.dense", "s", dense);
  row.value = *row.p50;
  row.baseline = "LAPACK dpotrf + dpotri of the same matrix, one thread, " + vertices;
  row.ratio = row.value / one;
  row.goal = 0.8;
  row.goal_ratio = 0.08;
  Row both = {.name = "precompute.dense_all_threads",
              .value = row.value,
              .unit = "s",
              .baseline = "the same LAPACK on all cores",
              .ratio = row.value / all};
  Row small = distribution_row("precompute.sparse", "s", sparse);
  small.value = *small.p50;
  small.baseline = "precompute.dense";
  small.ratio = small.value / row.value;
  Row memory = {.name = "precompute.peak_memory",
                .value = static_cast<double>(peak),
                .unit = "B",
                .baseline = "the matrix",
                .ratio = static_cast<double>(peak) / static_cast<double>(matrix),
                .goal_ratio = 2.2};
  return {row, both, small, memory};
}

}  // namespace calot::bench
