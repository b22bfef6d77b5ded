#include "calot/sim/haptic_loop.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>

namespace calot {
namespace {

constexpr std::int64_t second = 1'000'000'000;

std::int64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * second + time.tv_nsec;
}

void sleep_until(std::int64_t ns) {
  const timespec time{ns / second, ns % second};
  // Interrupted by a signal: sleep on.
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

bool become_realtime() {
  sched_param priority{};
  priority.sched_priority = (sched_get_priority_min(SCHED_FIFO) + sched_get_priority_max(SCHED_FIFO)) / 2;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
}

}  // namespace

HapticLoop::HapticLoop(HapticDevice& device, const HapticOptions& options)
    : device_(device), period_(options.period), tick_(options, device.limits()), periods_(options.period) {
  thread_ = std::thread([this] { run(); });
}

HapticLoop::~HapticLoop() {
  stop_ = true;
  thread_.join();
}

const HapticOutput& HapticLoop::latest() {
  outputs_.fetch();
  return outputs_.reading();
}

void HapticLoop::run() {
  realtime_ = become_realtime();
  const auto period = static_cast<std::int64_t>(std::llround(period_ * 1e9));
  std::int64_t due = now_ns(), last = 0;
  while (!stop_) {
    const std::int64_t start = now_ns();
    if (tick_.wants_set() && sets_.fetch()) (void)tick_.take(sets_.reading());
    const HapticOutput output = tick_.run(device_.read(), seconds(start));
    device_.write(output.force, output.torque);
    outputs_.writing() = output;
    outputs_.publish();
    const std::int64_t end = now_ns();
    if (last != 0) periods_.add(seconds(start - last), seconds(end - start));
    last = start;
    due += period;
    // Too late for the next ones: leave them out, instead of running after them without a pause.
    if (end > due) {
      const std::int64_t late = (end - due) / period + 1;
      missed_ += static_cast<std::uint64_t>(late);
      due += late * period;
    }
    sleep_until(due);
  }
  device_.write(Vec3::Zero(), Vec3::Zero());
}

}  // namespace calot
