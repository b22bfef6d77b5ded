// The same sounds without a device: what would be heard, as samples, for films and tests.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "calot/sound/sound_player.h"

namespace calot {

/// Time passes only by `render`, so the same calls give the same samples on one machine.
class SoundRecorder {
 public:
  /// `options.device` isn't used. Throws FailedError if OpenAL can't render into memory.
  explicit SoundRecorder(const SoundOptions& options = {});
  ~SoundRecorder();

  void update(const SoundScene& scene, std::span<const SoundCue> cues = {});
  void set_volume(double volume);
  void set_muted(bool muted);
  /// The next so many samples of each channel, interleaved left, right; at kSampleRate.
  std::vector<std::int16_t> render(std::size_t samples);
  [[nodiscard]] SoundStatus status() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace calot
