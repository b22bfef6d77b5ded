#include "calot/base/progress.h"

#include "calot/base/error.h"

namespace calot {

void Progress::phase(std::string_view name) {
  phase_ = name;
  start_ = std::chrono::steady_clock::now();
  at(0);
}

void Progress::at(double fraction) {
  if (stop_requested()) throw Interrupted();
  if (!listener_) return;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double remaining = fraction > 0.01 ? elapsed * (1 - fraction) / fraction : -1;
  listener_({phase_, fraction, elapsed, remaining});
}

}  // namespace calot
