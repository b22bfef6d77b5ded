// The haptic loop beside a running operation: how evenly it ticks, and what a tick costs.
#include <algorithm>
#include <cmath>
#include <thread>

#include "bench/benchmarks.h"
#include "bench/simulation_rows.h"
#include "calot/base/error.h"
#include "calot/sim/haptic_loop.h"
#include "calot/sim/haptic_mock.h"

namespace calot::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// Notes when it is read and written, as a device would feel it. Its lists are looked at when the loop is gone.
class Timed final : public HapticDevice {
 public:
  Timed(MockHapticDevice& device, std::size_t ticks) : device_(device) {
    reads.reserve(ticks);
    writes.reserve(ticks);
    forces.reserve(ticks);
  }
  [[nodiscard]] DeviceLimits limits() const override { return device_.limits(); }
  DeviceState read() noexcept override {
    if (reads.size() < reads.capacity()) reads.push_back(Clock::now());
    return device_.read();
  }
  void write(const Vec3& force, const Vec3& torque) noexcept override {
    device_.write(force, torque);
    if (writes.size() < reads.size()) {
      writes.push_back(Clock::now());
      forces.push_back(force.norm());
    }
  }
  std::vector<Clock::time_point> reads, writes;
  std::vector<double> forces;

 private:
  MockHapticDevice& device_;
};

double ms_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double, std::milli>(b - a).count();
}

std::vector<double> periods_of(const std::vector<Clock::time_point>& times) {
  std::vector<double> periods;
  for (std::size_t k = 1; k < times.size(); ++k) periods.push_back(ms_between(times[k - 1], times[k]));
  return periods;
}

std::vector<double> jitter_of(const std::vector<double>& periods) {
  std::vector<double> jitter;
  for (const double period : periods) jitter.push_back(std::abs(period - 1));
  return jitter;
}

// What the machine gives a thread that only sleeps, while nothing else of ours runs: jitter [ms].
std::vector<double> idle_jitter(std::size_t ticks) {
  std::vector<Clock::time_point> times;
  std::thread([&] {
    auto next = Clock::now();
    for (std::size_t k = 0; k < ticks; ++k) {
      times.push_back(Clock::now());
      next = std::max(next + std::chrono::milliseconds(1), Clock::now());
      std::this_thread::sleep_until(next);
    }
  }).join();
  return jitter_of(periods_of(times));
}

}  // namespace

std::vector<Row> haptic_rows(const Organ& organ, double seconds) {
  const std::vector<double> idle = idle_jitter(static_cast<std::size_t>(200 * seconds));
  Operation operation(organ, {});
  warm_up(operation);
  const Pose start = operation.world().instruments()[Operation::second_tube].to();
  const Vec3 press = operation.pressing(), along = start.rotation * Vec3::UnitX();
  // In and out by 3 mm once a second, across by 2 mm.
  MockHapticDevice mock([=](double t) {
    const double phase = 2 * 3.14159265358979 * t;
    return Pose{start.rotation,
                start.position + 1.5e-3 * (1 - std::cos(phase)) * press + 2e-3 * std::sin(0.7 * phase) * along};
  });
  Timed device(mock, static_cast<std::size_t>(1200 * seconds));
  PacedRun run;
  std::uint64_t missed = 0;
  bool realtime = false;
  {
    HapticLoop loop(device);
    const auto exchange = [&] {
      operation.world().haptic_constraints(Operation::second_tube, loop.next_set());
      loop.publish_set();
      if (const HapticOutput& felt = loop.latest(); felt.has_pose) operation.drive(Operation::second_tube, felt.input);
    };
    exchange();
    run = run_paced(operation, static_cast<std::size_t>(60 * seconds), exchange);
    missed = loop.missed();
    realtime = loop.is_realtime();
  }
  check_hold(operation);
  const std::vector<double> periods = periods_of(device.reads);
  std::vector<double> work;
  for (std::size_t k = 0; k < device.writes.size(); ++k) work.push_back(ms_between(device.reads[k], device.writes[k]));
  Row period = distribution_row("haptics.period", "ms", periods);
  period.value = *period.p50;
  period.baseline = "1 ms, p50";
  period.ratio = *period.p50;
  period.goal = 1.2;
  Row jitter = distribution_row("haptics.jitter", "ms", jitter_of(periods));
  jitter.baseline = "a thread that only sleeps, before the operation, p99";
  jitter.ratio = *jitter.p99 / distribution(idle).p99;
  jitter.goal = 0.2;
  Row tick = distribution_row("haptics.tick", "ms", work);
  tick.baseline = "1 ms, p99";
  tick.ratio = *tick.p99;
  const double ticks = static_cast<double>(device.reads.size());
  return {period,
          jitter,
          tick,
          {.name = "haptics.missed",
           .value = static_cast<double>(missed),
           .unit = "1",
           .baseline = "all ticks",
           .ratio = static_cast<double>(missed) / (ticks + static_cast<double>(missed))},
          {.name = "haptics.realtime",
           .value = realtime ? 1.0 : 0.0,
           .unit = "1",
           .baseline = realtime ? "(the system granted SCHED_FIFO)" : "(the system refused SCHED_FIFO)"},
          distribution_row("haptics.idle_jitter", "ms", idle),
          distribution_row("haptics.force", "N", device.forces),
          distribution_row("haptics.frame", "ms", milliseconds(run.frames))};
}

std::vector<Row> bench_haptics(const BenchOptions& options) {
  const Organ organ = make_organ_of_tets(options, 10000, 1.0 / 60);
  if (options.progress) options.progress->phase("touching");
  return haptic_rows(organ, 10);
}

}  // namespace calot::bench
