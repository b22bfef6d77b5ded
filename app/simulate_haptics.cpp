#include "app/simulate_haptics.h"

#include <algorithm>
#include <thread>

#include "app/terminal.h"
#include "calot/base/error.h"

namespace calot {
namespace {

std::size_t instrument_of(const Scene& scene) {
  for (std::size_t k = 0; k < scene.instruments.size(); ++k)
    if (scene.instruments[k].name == scene.haptics.instrument) return k;
  throw InputError(scene.file.string(), "no instrument is for a haptic device",
                   "add [haptics] with instrument = \"…\"");
}

HapticOptions options_of(const Scene& scene) {
  HapticOptions options;
  options.coupling.stiffness = scene.haptics.stiffness;
  options.damping = scene.haptics.damping;
  options.limits.max_force = scene.haptics.max_force;
  options.world_period = scene.time_step;
  return options;
}

}  // namespace

MockHolder::MockHolder(const Scene& scene, const SceneRun& run)
    : instrument_(instrument_of(scene)),
      name_(scene.haptics.instrument),
      period_(scene.time_step),
      device_([&run, k = instrument_](double time) { return run.asked(k, time).pose; }),
      loop_(device_, options_of(scene)),
      next_(std::chrono::steady_clock::now()) {}

void MockHolder::take(SceneRun::Inputs& inputs) {
  next_ += std::chrono::duration_cast<std::chrono::steady_clock::duration>(period_);
  const auto now = std::chrono::steady_clock::now();
  if (now > next_) {
    ++late_;
    next_ = now;
  }
  std::this_thread::sleep_until(next_);
  std::optional<InstrumentInput>& input = inputs[instrument_];
  device_.set_fingers(input->opening, input->grip, input->energy, input->fire);
  const HapticOutput& output = loop_.latest();
  if (!output.has_pose) return;
  input = output.input;
  peak_ = std::max(peak_, output.force.norm());
  stale_ += output.stale ? 1 : 0;
  refused_ += output.refused_set ? 1 : 0;
  limited_ += output.force_limited || output.rate_limited || output.energy_limited ? 1 : 0;
}

void MockHolder::give(const World& world) {
  world.haptic_constraints(instrument_, loop_.next_set());
  loop_.publish_set();
}

std::string MockHolder::text() const {
  const PeriodStatistics periods = loop_.periods();
  return "haptics (" + name_ + "): " + number_text(1e3 * periods.period.p50) + " ms a tick, p99 " +
         number_text(1e3 * periods.period.p99) + ", at most " + number_text(1e3 * periods.period.max) + ", " +
         std::to_string(loop_.missed()) + " left out" + (loop_.is_realtime() ? "" : " (no real-time priority)") +
         "; force " + number_text(peak_) + " N at most; limited in " + std::to_string(limited_) + " steps, stale in " +
         std::to_string(stale_) + "; world late " + std::to_string(late_) + " times";
}

nlohmann::ordered_json MockHolder::json() const {
  const PeriodStatistics periods = loop_.periods();
  return {{"instrument", name_},
          {"period_ms",
           {{"p50", 1e3 * periods.period.p50}, {"p99", 1e3 * periods.period.p99}, {"max", 1e3 * periods.period.max}}},
          {"missed_ticks", loop_.missed()},
          {"real_time_priority", loop_.is_realtime()},
          {"peak_force_N", peak_},
          {"limited_steps", limited_},
          {"stale_steps", stale_},
          {"refused_sets", refused_},
          {"late_steps", late_}};
}

}  // namespace calot
