#include "app/live_run.h"

#include <algorithm>
#include <chrono>

#include "app/recorded_run.h"
#include "app/view_camera.h"
#include "calot/base/error.h"

namespace calot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double furthest_behind = 0.25;  // a world that is slower than time isn't made to catch up on more [s]
constexpr double outside = 0.15;          // of an instrument without a port: how far up its shaft it is held [m]

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

LiveRun::LiveRun(const Scene& scene, Desktop& desktop, Gamepads& pads, const LiveOptions& options)
    : scene_(scene), desktop_(desktop), pads_(pads), options_(options) {
  for (auto& held : held_) held = -1;
  thread_ = std::thread([this] { live(); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return feed_.snapshots != nullptr || failure_ != nullptr; });
  if (!failure_) return;
  lock.unlock();
  thread_.join();
  std::rethrow_exception(failure_);
}

LiveRun::~LiveRun() {
  stop();
}

void LiveRun::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LiveRun::pause(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
  }
  changed_.notify_all();
}

void LiveRun::restart() {
  {
    const std::lock_guard lock(mutex_);
    again_ = true;
  }
  changed_.notify_all();
}

void LiveRun::take(int hand, int instrument) {
  for (auto& held : held_)
    if (instrument >= 0 && held == instrument) held = -1;
  held_[static_cast<std::size_t>(hand)] = instrument;
}

LiveFeed LiveRun::feed() const {
  const std::lock_guard lock(mutex_);
  return feed_;
}

void LiveRun::check() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

LiveStatistics LiveRun::statistics() const {
  const std::lock_guard lock(mutex_);
  return {steps_, late_, durations_.percentile(0.5), durations_.percentile(0.99), durations_.max()};
}

void LiveRun::live() {
  try {
    for (std::uint64_t number = 1;; ++number) {
      run_once(number);
      const std::lock_guard lock(mutex_);
      if (stop_) return;
      again_ = false;
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
  changed_.notify_all();
}

// @return whether the run goes on
bool LiveRun::wait_while_paused() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !paused_ || stop_ || again_; });
  return !stop_ && !again_;
}

void LiveRun::hold(Grip& grip, std::size_t hand, SceneRun& run) {
  const int wanted = held_[hand];
  if (wanted == grip.instrument) return;
  grip = {};
  grip.instrument = wanted;
  if (wanted < 0) return;
  const auto k = static_cast<std::size_t>(wanted);
  HandOptions options;
  const Pose& pose = last_[k].pose;
  options.port = run.port(k).value_or(Vec3(pose.position - outside * (pose.rotation * Vec3::UnitZ())));
  const InstrumentGeometry& geometry = run.world().instruments()[k].geometry();
  grip.hand.emplace(geometry, options, pose);
  if (options_.force)
    grip.force = std::make_unique<ForceHand>(options_.force->device(static_cast<int>(hand)), geometry, options, pose,
                                             scene_.time_step);
}

// A device with force goes before a gamepad, that before mouse and keys.
InstrumentInput LiveRun::ask(Grip& grip, int hand) {
  if (grip.force)
    if (const auto felt = grip.force->ask(options_.force->controls(hand))) return *felt;
  DeviceState state = pads_.device(hand).read();
  HandControls controls = pads_.controls(hand);
  const bool by_pad = state.connected;
  const DeviceState desk = desktop_.device(hand).read();
  if (!by_pad) {
    state = desk;
    controls = desktop_.controls(hand);
  }
  if (by_pad != grip.by_pad) state.connected = false;  // another device: it takes hold anew
  grip.by_pad = by_pad;
  return grip.hand->update(state, controls, scene_.time_step);
}

// What the scripts ask, or what an instrument was asked last; and instead of it what the hands do.
SceneRun::Inputs LiveRun::ask(SceneRun& run) {
  SceneRun::Inputs inputs;
  if (options_.play)
    inputs = run.next_inputs();
  else
    inputs.assign(last_.begin(), last_.end());
  for (std::size_t h = 0; h < grips_.size(); ++h) {
    hold(grips_[h], h, run);
    if (grips_[h].hand) inputs[static_cast<std::size_t>(grips_[h].instrument)] = ask(grips_[h], static_cast<int>(h));
  }
  for (std::size_t k = 0; k < last_.size(); ++k) last_[k] = *inputs[k];
  return inputs;
}

void LiveRun::run_once(std::uint64_t number) {
  SceneRun run(scene_);
  last_.clear();
  for (std::size_t k = 0; k < scene_.instruments.size(); ++k) last_.push_back(run.asked(k, 0));
  for (Grip& grip : grips_) grip = {};
  std::optional<InputRecorder> recorder;
  if (!options_.record.empty() && number == 1) {
    recorder.emplace(options_.record, recording_header(scene_, run));
  }
  if (number == 1) {
    camera_ = scene_camera(scene_, run);
    for (const InstrumentArm& arm : run.world().instruments()) tools_.push_back(arm.geometry());
  }
  const auto feed = std::make_shared<SnapshotFeed>(run.world());
  {
    const std::lock_guard lock(mutex_);
    feed_ = {number, feed};
  }
  changed_.notify_all();
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(scene_.time_step));
  auto due = Clock::now();
  while (wait_while_paused()) {
    const auto begin = Clock::now();
    if (std::chrono::duration<double>(begin - due).count() > furthest_behind) due = begin;
    SceneRun::Inputs inputs = ask(run);
    if (recorder) recorder->step(inputs);
    run.step(std::move(inputs));
    feed->publish(run.world());
    for (const Grip& grip : grips_)
      if (grip.force) grip.force->give(run.world(), static_cast<std::size_t>(grip.instrument));
    const double took = seconds_since(begin);
    due += period;
    {
      const std::lock_guard lock(mutex_);
      late_ += Clock::now() > due ? 1 : 0;
      ++steps_;
      durations_.add(took);
    }
    std::this_thread::sleep_until(due);
  }
  if (recorder) recorder->end(run.world().state_hash());
}

}  // namespace calot
