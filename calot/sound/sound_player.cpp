#include "calot/sound/sound_player.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "calot/sound/sound_engine.h"

namespace calot {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostCues = 64;
constexpr double kTick = 0.01;  ///< [s] between changes of gains
constexpr double kStale = 1;    ///< [s] without an update until what goes on fades

}  // namespace

/// What the caller and the thread leave for each other. The thread holds the lock only to take and to put.
struct SoundPlayer::Shared {
  struct Notes {
    SoundScene scene;
    std::vector<SoundCue> cues;
    double volume = 1;
    bool muted = false, fresh = false, retry = false, stop = false;
    bool any() const { return fresh || retry || stop; }
  };

  explicit Shared(const SoundOptions& wanted) : options(wanted) {
    notes.cues.reserve(kMostCues);
    notes.volume = options.volume;
    notes.muted = options.muted;
    thread = std::thread([this] { run(); });
  }

  void run();
  void open(const detail::SoundBank& bank);
  void close();
  void play(Notes& now, double seconds);
  void say(SoundState state, const std::string& text);

  SoundOptions options;
  mutable std::mutex lock;
  std::condition_variable wake;
  Notes notes;         // under the lock
  SoundStatus status;  // under the lock
  std::optional<std::string> news;
  // The thread's own.
  std::unique_ptr<detail::AlDevice> device;
  std::unique_ptr<detail::SoundEngine> engine;
  double since_update = 0;
  std::thread thread;
};

void SoundPlayer::Shared::say(SoundState state, const std::string& text) {
  const std::lock_guard hold(lock);
  const bool better = state == SoundState::playing && status.state == SoundState::silent;
  if (state == SoundState::silent || better) news = text;
  status.state = state;
  status.text = text;
  status.voices = 0;
}

void SoundPlayer::Shared::open(const detail::SoundBank& bank) {
  std::string why_not;
  device = detail::AlDevice::open(options.device, why_not);
  if (!device) return say(SoundState::silent, why_not + "; Calot goes on without sound");
  const detail::AlDevice::Current current(*device);
  engine = std::make_unique<detail::SoundEngine>(bank, options.seed);
  say(SoundState::playing, "sound on " + device->name());
}

void SoundPlayer::Shared::close() {
  if (!device) return;
  {
    const detail::AlDevice::Current current(*device);
    engine.reset();
  }
  device.reset();
}

void SoundPlayer::Shared::play(Notes& now, double seconds) {
  std::uint64_t played = 0;
  int voices = 0;
  if (device && !device->connected()) {
    close();
    say(SoundState::silent, "the sound device went away; Calot goes on without sound");
  }
  if (engine) {
    const detail::AlDevice::Current current(*device);
    since_update = now.fresh ? 0 : since_update + seconds;
    engine->set_volume(now.volume, now.muted);
    engine->hear(since_update < kStale ? now.scene : SoundScene{});
    for (const SoundCue& cue : now.cues) played += engine->play(cue);
    engine->advance(seconds);
    voices = engine->voices();
  }
  const std::lock_guard hold(lock);
  status.played += played;
  status.left_out += now.cues.size() - played;
  status.voices = voices;
  now.cues.clear();
}

void SoundPlayer::Shared::run() {
  const detail::SoundBank bank(options.seed);
  open(bank);
  Notes now;
  now.cues.reserve(kMostCues);
  Clock::time_point last = Clock::now();
  while (true) {
    {
      std::unique_lock hold(lock);
      // Without a device there is nothing to do between updates.
      const double wait = engine ? std::min(kTick, engine->until_beat()) : 1.0;
      wake.wait_for(hold, std::chrono::duration<double>(wait), [&] { return notes.any(); });
      std::swap(now.cues, notes.cues);
      now.scene = notes.scene;
      now.volume = notes.volume;
      now.muted = notes.muted;
      now.fresh = std::exchange(notes.fresh, false);
      now.retry = std::exchange(notes.retry, false);
      now.stop = notes.stop;
    }
    if (now.stop) break;
    if (now.retry && !device) open(bank);
    const Clock::time_point time = Clock::now();
    play(now, std::chrono::duration<double>(time - last).count());
    last = time;
  }
  close();
}

SoundPlayer::SoundPlayer(const SoundOptions& options) : shared_(std::make_unique<Shared>(options)) {}

SoundPlayer::~SoundPlayer() {
  {
    const std::lock_guard hold(shared_->lock);
    shared_->notes.stop = true;
  }
  shared_->wake.notify_one();
  shared_->thread.join();
}

void SoundPlayer::update(const SoundScene& scene, std::span<const SoundCue> cues) noexcept {
  {
    const std::lock_guard hold(shared_->lock);
    Shared::Notes& notes = shared_->notes;
    const std::size_t room = std::min(cues.size(), kMostCues - notes.cues.size());  // of what was reserved
    notes.cues.insert(notes.cues.end(), cues.begin(), cues.begin() + static_cast<std::ptrdiff_t>(room));
    shared_->status.left_out += cues.size() - room;
    notes.scene = scene;
    notes.fresh = true;
  }
  shared_->wake.notify_one();
}

void SoundPlayer::set_volume(double volume) noexcept {
  const std::lock_guard hold(shared_->lock);
  shared_->notes.volume = volume;
}

void SoundPlayer::set_muted(bool muted) noexcept {
  const std::lock_guard hold(shared_->lock);
  shared_->notes.muted = muted;
}

void SoundPlayer::retry() noexcept {
  {
    const std::lock_guard hold(shared_->lock);
    shared_->notes.retry = true;
  }
  shared_->wake.notify_one();
}

SoundStatus SoundPlayer::status() const {
  const std::lock_guard hold(shared_->lock);
  return shared_->status;
}

std::optional<std::string> SoundPlayer::news() {
  const std::lock_guard hold(shared_->lock);
  return std::exchange(shared_->news, std::nullopt);
}

}  // namespace calot
