// A scene that runs at its own pace on a thread of its own, its instruments in hands.
#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/force_hand.h"
#include "app/simulate_summary.h"
#include "calot/device/gamepads.h"
#include "calot/scene/scene_world.h"
#include "calot/view/camera.h"
#include "calot/view/snapshot_maker.h"

namespace calot {

inline constexpr int live_hands = 2;

/// Devices with force, one for each hand; both functions from any thread.
struct ForceDevices {
  std::function<HapticDevice&(int hand)> device;
  std::function<HandControls(int hand)> controls;
};

struct LiveOptions {
  bool play = false;                       ///< instruments that no hand holds follow the scene's scripts
  std::filesystem::path record;            ///< what they were asked goes into this new file; or empty
  std::optional<ForceDevices> force = {};  ///< who hold the instruments from their first good sample on
};

struct LiveStatistics {
  std::uint64_t steps = 0, late = 0;     ///< late: done after the next one was due
  double p50 = 0, p99 = 0, longest = 0;  ///< of a step [s]
};

/// One run of the scene: what the drawing thread fetches, and which run it is of.
struct LiveFeed {
  std::uint64_t run = 0;  ///< another one after each restart
  std::shared_ptr<SnapshotFeed> snapshots;
};

/// All calls from one thread, that of the window.
class LiveRun {
 public:
  /// Starts the thread and waits until the scene stands; paused. Throws what SceneRun and InputRecorder throw.
  LiveRun(const Scene& scene, Desktop& desktop, Gamepads& pads, const LiveOptions& options);
  ~LiveRun();  ///< stops after the step that is going on and ends the recording
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  void stop();  ///< ends the run and the recording, for good
  void pause(bool paused);
  /// From the beginning; the recording ends. The old run goes on to be seen until the new one stands.
  void restart();
  /// A hand holds this instrument from now on, instead of what it held; −1: none. An instrument is in one hand only.
  void take(int hand, int instrument);
  [[nodiscard]] int held_by(int hand) const { return held_[static_cast<std::size_t>(hand)]; }
  [[nodiscard]] LiveFeed feed() const;
  /// Where the scene is looked at from, and its instruments.
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] const std::vector<InstrumentGeometry>& tools() const { return tools_; }
  [[nodiscard]] LiveStatistics statistics() const;
  /// Rethrows what ended the thread, if something did.
  void check() const;

 private:
  struct Grip {  // of a hand, on the run's thread
    int instrument = -1;
    bool by_pad = false;
    std::optional<Hand> hand;
    std::unique_ptr<ForceHand> force;
  };
  void live();
  void run_once(std::uint64_t number);
  SceneRun::Inputs ask(SceneRun& run);
  InstrumentInput ask(Grip& grip, int hand);
  void hold(Grip& grip, std::size_t hand, SceneRun& run);
  [[nodiscard]] bool wait_while_paused();

  const Scene scene_;
  Desktop& desktop_;
  Gamepads& pads_;
  const LiveOptions options_;
  std::array<std::atomic<int>, live_hands> held_;
  std::array<Grip, live_hands> grips_;
  std::vector<InstrumentInput> last_;  // what each instrument was asked last

  Camera camera_;  // these two: written before the first feed, then read only
  std::vector<InstrumentGeometry> tools_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool paused_ = true, stop_ = false, again_ = false;
  LiveFeed feed_;
  std::exception_ptr failure_;
  Tally durations_;
  std::uint64_t steps_ = 0, late_ = 0;
  std::thread thread_;
};

}  // namespace calot
