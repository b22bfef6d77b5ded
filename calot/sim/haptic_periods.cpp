#include "calot/sim/haptic_periods.h"

#include <algorithm>
#include <cmath>

namespace calot {

Distribution distribution_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values[std::max<std::size_t>(rank, 1) - 1];
  };
  return {at(0.5), at(0.99), values.back()};
}

void PeriodRing::add(double period, double work) {
  const std::uint64_t count = count_.load(std::memory_order_relaxed);
  periods_[count % size].store(static_cast<float>(period), std::memory_order_relaxed);
  work_[count % size].store(static_cast<float>(work), std::memory_order_relaxed);
  count_.store(count + 1, std::memory_order_release);
}

PeriodStatistics PeriodRing::statistics() const {
  PeriodStatistics statistics;
  statistics.ticks = count_.load(std::memory_order_acquire);
  statistics.counted = std::min<std::uint64_t>(statistics.ticks, size);
  std::vector<double> periods, jitter, work;
  for (std::size_t i = 0; i < statistics.counted; ++i) {
    periods.push_back(periods_[i].load(std::memory_order_relaxed));
    jitter.push_back(std::abs(periods.back() - wanted_));
    work.push_back(work_[i].load(std::memory_order_relaxed));
  }
  statistics.period = distribution_of(std::move(periods));
  statistics.jitter = distribution_of(std::move(jitter));
  statistics.work = distribution_of(std::move(work));
  return statistics;
}

}  // namespace calot
