// Plays what a scene sounds like on the machine's sound device, from a thread of its own.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "calot/sound/sound_scene.h"

namespace calot {

struct SoundOptions {
  std::string device = {};  ///< as OpenAL names it; empty: the system's
  double volume = 0.8;      ///< 0 … 1
  bool muted = false;
  std::uint64_t seed = 0;  ///< of the synthesised sounds
};

enum class SoundState : std::uint8_t {
  starting,  ///< sounds are made, the device is opened
  playing,
  silent,  ///< no device, or it went away; `retry` tries again
};

struct SoundStatus {
  SoundState state = SoundState::starting;
  std::string text;            ///< one line for the screen: the device's name, or why there is none
  std::uint64_t played = 0;    ///< cues that were started
  std::uint64_t left_out = 0;  ///< cues that were not: too many, not finite, or while silent
  int voices = 0;              ///< sounds now, at most kVoices
};

inline constexpr int kVoices = 28;  ///< at once: 12 for what goes on, 16 for cues

/// Never throws when playing and never waits for the device: calls leave a note for the thread and return. Without a
/// sound device everything works, silently. When updates stay away for a second, what goes on fades, so that no tone
/// hangs after the picture stopped.
class SoundPlayer {
 public:
  explicit SoundPlayer(const SoundOptions& options = {});
  ~SoundPlayer();
  SoundPlayer(const SoundPlayer&) = delete;
  SoundPlayer& operator=(const SoundPlayer&) = delete;

  /// Once a picture: what goes on now, and what happened since the last call (at most 64 cues; more are left out).
  void update(const SoundScene& scene, std::span<const SoundCue> cues = {}) noexcept;
  void set_volume(double volume) noexcept;  ///< 0 … 1
  void set_muted(bool muted) noexcept;
  /// Tries to open the device again, if there is none. The status tells what came of it.
  void retry() noexcept;

  [[nodiscard]] SoundStatus status() const;
  /// A line for the user, once after each change for the worse or the better: "no sound device …".
  [[nodiscard]] std::optional<std::string> news();

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace calot
