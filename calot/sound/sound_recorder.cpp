#include "calot/sound/sound_recorder.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/sound/sound_engine.h"
#include "calot/sound/wav.h"

namespace calot {

struct SoundRecorder::Parts {
  std::unique_ptr<detail::AlDevice> device;
  std::unique_ptr<detail::SoundEngine> engine;
  double volume = 1;
  bool muted = false;
  SoundStatus status;
};

SoundRecorder::SoundRecorder(const SoundOptions& options) : parts_(std::make_unique<Parts>()) {
  std::string why_not;
  parts_->device = detail::AlDevice::loopback(why_not);
  if (!parts_->device) throw FailedError("sound", why_not, "record without sound");
  const detail::AlDevice::Current current(*parts_->device);
  parts_->engine = std::make_unique<detail::SoundEngine>(detail::SoundBank(options.seed), options.seed);
  parts_->volume = options.volume;
  parts_->muted = options.muted;
  parts_->engine->set_volume(options.volume, options.muted);
  parts_->status.state = SoundState::playing;
  parts_->status.text = "into memory";
}

SoundRecorder::~SoundRecorder() {
  const detail::AlDevice::Current current(*parts_->device);
  parts_->engine.reset();
}

void SoundRecorder::update(const SoundScene& scene, std::span<const SoundCue> cues) {
  const detail::AlDevice::Current current(*parts_->device);
  parts_->engine->hear(scene);
  for (const SoundCue& cue : cues) ++(parts_->engine->play(cue) ? parts_->status.played : parts_->status.left_out);
}

void SoundRecorder::set_volume(double volume) {
  const detail::AlDevice::Current current(*parts_->device);
  parts_->engine->set_volume(parts_->volume = volume, parts_->muted);
}

void SoundRecorder::set_muted(bool muted) {
  const detail::AlDevice::Current current(*parts_->device);
  parts_->engine->set_volume(parts_->volume, parts_->muted = muted);
}

std::vector<std::int16_t> SoundRecorder::render(std::size_t samples) {
  constexpr std::size_t kStep = kSampleRate / 200;  // 5 ms between changes of gains
  const detail::AlDevice::Current current(*parts_->device);
  std::vector<float> stereo(2 * samples);
  for (std::size_t done = 0; done < samples;) {
    const std::size_t count = std::min(kStep, samples - done);
    parts_->engine->advance(static_cast<double>(count) / kSampleRate);
    parts_->device->render(stereo.data() + 2 * done, static_cast<int>(count));
    done += count;
  }
  return to_16_bit(stereo);
}

SoundStatus SoundRecorder::status() const {
  SoundStatus status = parts_->status;
  status.voices = parts_->engine->voices();
  return status;
}

}  // namespace calot
