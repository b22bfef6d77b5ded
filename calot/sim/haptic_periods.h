// How evenly the haptic loop runs.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace calot {

struct Distribution {
  double p50 = 0, p99 = 0, max = 0;
};
/// The value that a share of all doesn't pass (nearest rank); all 0 for none.
Distribution distribution_of(std::vector<double> values);

struct PeriodStatistics {
  std::uint64_t ticks = 0;  ///< since the start
  std::size_t counted = 0;  ///< the last so many of them are in the figures below
  Distribution period;      ///< from one tick's start to the next [s]
  Distribution jitter;      ///< distance of the period from the wanted one [s]
  Distribution work;        ///< from a tick's start to its end [s]
};

/// The last periods. `add` on one thread; `statistics` on any, at any time, without holding the first up.
class PeriodRing {
 public:
  static constexpr std::size_t size = 4096;
  explicit PeriodRing(double wanted) : wanted_(wanted) {}
  void add(double period, double work);
  [[nodiscard]] PeriodStatistics statistics() const;

 private:
  double wanted_;
  std::atomic<std::uint64_t> count_ = 0;
  std::array<std::atomic<float>, size> periods_{}, work_{};
};

}  // namespace calot
