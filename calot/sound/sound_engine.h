// Inside this room only: turns scenes and cues into OpenAL's sources. Knows no clock: `advance` tells it the time that
// passed. All calls while the device is current.
#pragma once
#include <array>
#include <vector>

#include "calot/sound/al_device.h"
#include "calot/sound/sound_bank.h"
#include "calot/sound/sound_player.h"
#include "calot/sound/waves.h"

namespace calot::detail {

class SoundEngine {
 public:
  SoundEngine(const SoundBank& bank, std::uint64_t seed);
  ~SoundEngine();
  SoundEngine(const SoundEngine&) = delete;
  SoundEngine& operator=(const SoundEngine&) = delete;

  void hear(const SoundScene& scene);
  /// False if it was left out.
  bool play(const SoundCue& cue);
  void set_volume(double volume, bool muted);
  /// Brings gains, heartbeats and what ended forward [s].
  void advance(double seconds);
  /// Until the heart beats next [s]; large if it doesn't.
  [[nodiscard]] double until_beat() const;
  [[nodiscard]] int voices() const;

 private:
  /// A sound without end: its gain follows `target` within about `rise` and `fall` [s].
  struct Loop {
    SoundKind kind = SoundKind::room;
    ALuint source = 0;
    double target = 0, gain = 0, rise = 0.01, fall = 0.04;
    SoundPosition position = SoundPosition(0, 0, -1);
    bool plays = false;
  };
  struct Voice {
    ALuint source = 0;
    SoundKind kind = SoundKind::snip;
    double age = 1e9;  ///< [s]
    bool plays = false;
  };
  Loop& loop(SoundKind kind) {
    return loops_[static_cast<std::size_t>(kind) - static_cast<std::size_t>(SoundKind::cut_tone)];
  }
  void follow(Loop& one, double seconds);
  void start(Voice& voice, const SoundCue& cue);
  Voice* free_voice(SoundKind kind);
  void beat(double seconds);

  std::array<std::vector<ALuint>, kSoundKinds> buffers_;
  std::array<Loop, kSoundKinds - static_cast<std::size_t>(SoundKind::cut_tone)> loops_;
  std::array<Voice, 16> voices_;
  Chance chance_;
  double heart_rate_ = 0, saturation_ = 98, phase_ = 1;
};

}  // namespace calot::detail
