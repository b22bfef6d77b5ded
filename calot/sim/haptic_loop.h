// The thread that touches: 1000 times a second from the device through the last constraint set to the device.
#pragma once
#include <atomic>
#include <thread>

#include "calot/base/triple_buffer.h"
#include "calot/sim/haptic_periods.h"
#include "calot/sim/haptic_tick.h"

namespace calot {

/// Owns the thread, not the device. The world's thread gives constraint sets and takes outputs; neither side waits.
class HapticLoop {
 public:
  /// Starts at once. Throws InputError for options out of range.
  explicit HapticLoop(HapticDevice& device, const HapticOptions& options = {});
  /// Fades nothing: stops, and shows zero force.
  ~HapticLoop();
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  // On one thread, the world's:
  /// A set to fill; holds an earlier one, whose memory is used again.
  HapticConstraints& next_set() { return sets_.writing(); }
  void publish_set() { sets_.publish(); }
  /// The last tick's output; the same until there is a newer one.
  const HapticOutput& latest();

  // On any thread:
  [[nodiscard]] PeriodStatistics periods() const { return periods_.statistics(); }
  /// Whether the system lets the thread go before all others (SCHED_FIFO); without, expect jitter on a busy machine.
  [[nodiscard]] bool is_realtime() const { return realtime_; }
  /// Ticks left out because the thread got no turn for that long.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  void run();

  HapticDevice& device_;
  double period_;
  HapticTick tick_;
  TripleBuffer<HapticConstraints> sets_;
  TripleBuffer<HapticOutput> outputs_;
  PeriodRing periods_;
  std::atomic<bool> realtime_ = false, stop_ = false;
  std::atomic<std::uint64_t> missed_ = 0;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace calot
