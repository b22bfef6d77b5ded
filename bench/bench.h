// Benchmarks: what one is, what it answers, and how time is taken. Each is one file, bench_NAME.cpp, and one line in
// benches.cpp; `calot bench NAME` runs it.
#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calot/base/progress.h"

namespace calot::bench {

/// One measured number. Lower is better: a rate is given as a period.
struct Row {
  std::string name = {};  ///< "precompute.dense"
  double value = 0;
  std::string unit = {};                               ///< "s", "ms", "m", "1" …
  std::optional<double> p50 = {}, p99 = {}, max = {};  ///< where `value` stands for a distribution; in `unit`
  std::string baseline = {};                           ///< what `ratio` compares with, in words; empty: nothing
  std::optional<double> ratio = {};                    ///< value / baseline, both taken in this run
  std::optional<double> goal = {},
                        goal_ratio = {};  ///< upper bounds of `value` (of `p99` where there is one) and `ratio`
};

/// The row's goals are met; true where it has none.
bool met(const Row& row);

/// The machine and the build that a number belongs to.
struct Machine {
  std::string processor, blas, compiler, system;
  int cores = 0, threads = 0;
  double memory_gb = 0;
};
Machine this_machine();

struct Report {
  Machine machine;
  std::vector<Row> rows;
};

struct BenchOptions {
  std::filesystem::path output;      ///< folder for tables, figures and pictures; empty: none are written
  std::filesystem::path model = {};  ///< a model.toml to measure instead of the benchmark's own; empty: its own
  Progress* progress = nullptr;
};

struct Bench {
  std::string name, description;
  std::function<std::vector<Row>(const BenchOptions&)> run;
};

/// Every benchmark, in the order that `calot bench --list` shows.
const std::vector<Bench>& benches();
/// The benchmark of this name. Throws InputError, listing the names there are.
const Bench& find_bench(const std::string& name);
Report run(const Bench& bench, const BenchOptions& options);

/// {"machine": …, "rows": [ … ]}; a missing number or word is null.
std::string to_json(const Report& report);
/// The same for people.
std::string to_text(const Report& report);

/// Seconds since it was made.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double seconds_of(const std::function<void()>& work);

struct Distribution {
  double mean = 0, p50 = 0, p99 = 0, max = 0;
};
/// Percentiles by the nearest rank: p99 of 60 values is the largest. Throws InputError for no values.
Distribution distribution(std::vector<double> values);

/// A row for a distribution of values: `value` is its p99.
Row distribution_row(const std::string& name, const std::string& unit, const std::vector<double>& values);

}  // namespace calot::bench
