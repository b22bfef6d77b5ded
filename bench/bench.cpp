#include "bench/bench.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calot/base/error.h"

namespace calot::bench {

bool met(const Row& row) {
  const bool value_met = !row.goal || row.p99.value_or(row.value) <= *row.goal;
  const bool ratio_met = !row.goal_ratio || (row.ratio && *row.ratio <= *row.goal_ratio);
  return value_met && ratio_met;
}

const Bench& find_bench(const std::string& name) {
  std::string names;
  for (const Bench& bench : benches()) {
    if (bench.name == name) return bench;
    names += (names.empty() ? "" : ", ") + bench.name;
  }
  throw InputError("bench", "there is no benchmark \"" + name + "\"", "choose one of: " + names);
}

Report run(const Bench& bench, const BenchOptions& options) {
  if (!options.output.empty()) std::filesystem::create_directories(options.output);
  Report report{this_machine(), bench.run(options)};
  return report;
}

double seconds_of(const std::function<void()>& work) {
  const Stopwatch watch;
  work();
  return watch.seconds();
}

Distribution distribution(std::vector<double> values) {
  if (values.empty()) throw InputError("distribution", "there are no values");
  std::sort(values.begin(), values.end());
  const auto rank = [&](double fraction) {
    const auto at = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
    return values[std::max<std::size_t>(at, 1) - 1];
  };
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  return {mean, rank(0.5), rank(0.99), values.back()};
}

Row distribution_row(const std::string& name, const std::string& unit, const std::vector<double>& values) {
  const Distribution d = distribution(values);
  return {.name = name, .value = d.p99, .unit = unit, .p50 = d.p50, .p99 = d.p99, .max = d.max};
}

}  // namespace calot::bench
