// The benchmarks themselves; each is described in benches.cpp.
#pragma once
#include "bench/bench.h"

namespace calot::bench {

std::vector<Row> bench_precompute(const BenchOptions& options);
std::vector<Row> bench_cut(const BenchOptions& options);
std::vector<Row> bench_gradual(const BenchOptions& options);
std::vector<Row> bench_growth(const BenchOptions& options);
std::vector<Row> bench_figure4(const BenchOptions& options);
std::vector<Row> bench_figure5(const BenchOptions& options);
std::vector<Row> bench_step(const BenchOptions& options);
std::vector<Row> bench_contact(const BenchOptions& options);
std::vector<Row> bench_haptics(const BenchOptions& options);
std::vector<Row> bench_view(const BenchOptions& options);
std::vector<Row> bench_patient(const BenchOptions& options);
std::vector<Row> bench_cohort(const BenchOptions& options);

}  // namespace calot::bench
