// Inside this room only: where a step's time goes. Nothing depends on it but the report.
#pragma once
#include <chrono>

#include "calot/sim/world.h"

namespace calot {

class World::PhaseClock {
 public:
  explicit PhaseClock(std::array<double, phase_count>& seconds)
      : seconds_(seconds), begin_(std::chrono::steady_clock::now()) {}
  /// Books the time since the last call, less `elsewhere`.
  void end(Phase phase, double elsewhere = 0) {
    const auto now = std::chrono::steady_clock::now();
    seconds_[static_cast<std::size_t>(phase)] += std::chrono::duration<double>(now - begin_).count() - elsewhere;
    begin_ = now;
  }

 private:
  std::array<double, phase_count>& seconds_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace calot
