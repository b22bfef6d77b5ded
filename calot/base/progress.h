// Progress of long work, and the one way to stop it.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

namespace calot {

/// What a listener is told.
struct ProgressState {
  std::string_view phase;
  double fraction = 0;           ///< of this phase, 0 … 1
  double elapsed_seconds = 0;    ///< in this phase
  double remaining_seconds = 0;  ///< estimate for this phase; < 0 while unknown
};

/// Handed down by whoever runs long work. Silent by default. One thread reports; `request_stop` is safe from any
/// thread and from a signal handler.
class Progress {
 public:
  using Listener = std::function<void(const ProgressState&)>;
  Progress() = default;
  explicit Progress(Listener listener) : listener_(std::move(listener)) {}

  /// Starts a phase at fraction 0. Throws Interrupted if a stop was requested.
  void phase(std::string_view name);
  /// Reports how far the phase is, 0 … 1. Throws Interrupted if a stop was requested.
  void at(double fraction);
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool stop_requested() const noexcept { return stop_.load(std::memory_order_relaxed); }

 private:
  Listener listener_;
  std::string phase_;
  std::chrono::steady_clock::time_point start_{};
  std::atomic<bool> stop_{false};
};

}  // namespace calot
