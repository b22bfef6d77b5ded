#include "calot/sound/sound_engine.h"

#include <algorithm>
#include <cmath>

namespace calot {

namespace {

double finite(double value, double low, double high) {
  return std::isfinite(value) ? std::clamp(value, low, high) : 0;
}

}  // namespace

SoundMix mix_of(const SoundScene& scene) {
  SoundMix mix;
  const double power = finite(scene.cautery_power, 0, 60);
  const double heat = std::min(1.1, std::sqrt(power / 40)), often = std::clamp((power - 5) / 20, 0.0, 1.0);
  mix.sizzle = heat;
  mix.crackle = heat * std::sqrt(1 - often);
  mix.crackle_dense = heat * std::sqrt(often);
  if (!scene.suction) return mix;
  const double wet = std::sqrt(finite(scene.suction_flow, 0, 10e-6) / 10e-6);
  mix.suction_fluid = wet;
  mix.suction_air = std::sqrt(1 - 0.75 * wet);
  return mix;
}

namespace detail {

namespace {

/// Among the others, so that neither tones cover tissue nor all of it together overloads.
double level_of(SoundKind kind) {
  switch (kind) {
    case SoundKind::cut_tone:
    case SoundKind::coag_tone:
      return 0.22;
    case SoundKind::sizzle:
      return 0.8;
    case SoundKind::crackle:
    case SoundKind::crackle_dense:
      return 0.45;
    case SoundKind::suction_air:
      return 0.5;
    case SoundKind::suction_fluid:
      return 0.7;
    case SoundKind::beep:
      return 0.3;
    case SoundKind::room:
      return 0.22;
    case SoundKind::slip:
      return 0.7;
    case SoundKind::alarm_low:
    case SoundKind::alarm_medium:
    case SoundKind::alarm_high:
      return 0.55;
    default:
      return 0.6;
  }
}

/// Which cue gives way to which when all voices are busy: the higher stays.
int rank_of(SoundKind kind) {
  switch (kind) {
    case SoundKind::beep:
      return 4;
    case SoundKind::error:
      return 3;
    case SoundKind::clip:
    case SoundKind::snip:
    case SoundKind::tear:
    case SoundKind::attention:
      return 2;
    case SoundKind::slip:
      return 0;
    default:
      return 1;
  }
}

bool from_machines(SoundKind kind) {
  return kind == SoundKind::error || kind == SoundKind::attention || kind == SoundKind::beep;
}

constexpr double kTogether = 0.025;  // [s] two cues of one kind closer than this are one

/// Nearer instruments are a little louder; the direction pans. Distances of a laparoscope [m].
void set_up_source(ALuint source) {
  alSourcei(source, AL_SOURCE_RELATIVE, AL_TRUE);
  alSourcef(source, AL_REFERENCE_DISTANCE, 0.1F);
  alSourcef(source, AL_MAX_DISTANCE, 0.3F);
  alSourcef(source, AL_ROLLOFF_FACTOR, 0.5F);
}

void place(ALuint source, SoundPosition position, bool central) {
  if (central || !position.allFinite()) position = SoundPosition(0, 0, -0.1);
  alSource3f(source, AL_POSITION, static_cast<float>(position.x()), static_cast<float>(position.y()),
             static_cast<float>(position.z()));
}

}  // namespace

SoundEngine::SoundEngine(const SoundBank& bank, std::uint64_t seed) : chance_(seed) {
  alDistanceModel(AL_INVERSE_DISTANCE_CLAMPED);
  for (const SoundKind kind : all_sounds()) {
    const std::vector<SoundBank::Take>& takes = bank.takes[static_cast<std::size_t>(kind)];
    std::vector<ALuint>& buffers = buffers_[static_cast<std::size_t>(kind)];
    buffers.resize(takes.size());
    alGenBuffers(static_cast<ALsizei>(buffers.size()), buffers.data());
    for (std::size_t i = 0; i < takes.size(); ++i) {
      alBufferData(buffers[i], AL_FORMAT_MONO16, takes[i].data(),
                   static_cast<ALsizei>(takes[i].size() * sizeof(std::int16_t)), kSampleRate);
    }
    if (!loops(kind)) continue;
    Loop& one = loop(kind);
    one.kind = kind;
    alGenSources(1, &one.source);
    set_up_source(one.source);
    alSourcei(one.source, AL_LOOPING, AL_TRUE);
    alSourcei(one.source, AL_BUFFER, static_cast<ALint>(buffers.front()));
  }
  loop(SoundKind::room).rise = loop(SoundKind::room).fall = 0.5;
  for (Voice& voice : voices_) {
    alGenSources(1, &voice.source);
    set_up_source(voice.source);
  }
}

SoundEngine::~SoundEngine() {
  for (Loop& one : loops_) alDeleteSources(1, &one.source);
  for (Voice& voice : voices_) alDeleteSources(1, &voice.source);
  for (std::vector<ALuint>& buffers : buffers_) alDeleteBuffers(static_cast<ALsizei>(buffers.size()), buffers.data());
}

void SoundEngine::hear(const SoundScene& scene) {
  const SoundMix mix = mix_of(scene);
  const auto want = [&](SoundKind kind, double gain, const SoundPosition& position = SoundPosition(0, 0, -0.1)) {
    loop(kind).target = gain * level_of(kind);
    loop(kind).position = position;
  };
  want(SoundKind::cut_tone, scene.cautery == CauteryMode::cut);
  want(SoundKind::coag_tone, scene.cautery == CauteryMode::coagulate);
  want(SoundKind::sizzle, mix.sizzle, scene.cautery_position);
  want(SoundKind::crackle, mix.crackle, scene.cautery_position);
  want(SoundKind::crackle_dense, mix.crackle_dense, scene.cautery_position);
  want(SoundKind::suction_air, mix.suction_air, scene.suction_position);
  want(SoundKind::suction_fluid, mix.suction_fluid, scene.suction_position);
  want(SoundKind::alarm_low, scene.alarm == AlarmPriority::low);
  want(SoundKind::alarm_medium, scene.alarm == AlarmPriority::medium);
  want(SoundKind::alarm_high, scene.alarm == AlarmPriority::high);
  want(SoundKind::room, scene.room);
  heart_rate_ = finite(scene.heart_rate, 0, 300);
  saturation_ = finite(scene.saturation, kLowestBeep, 100);
}

void SoundEngine::follow(Loop& one, double seconds) {
  const double within = one.target > one.gain ? one.rise : one.fall;
  one.gain += (one.target - one.gain) * -std::expm1(-seconds / within);
  if (one.target == 0 && one.gain < 1e-3) one.gain = 0;
  if (one.gain == 0) {
    if (one.plays) alSourceStop(one.source);
    one.plays = false;
    return;
  }
  place(one.source, one.position, false);
  alSourcef(one.source, AL_GAIN, static_cast<float>(one.gain));
  if (!one.plays) alSourcePlay(one.source);
  one.plays = true;
}

SoundEngine::Voice* SoundEngine::free_voice(SoundKind kind) {
  Voice* worst = nullptr;
  for (Voice& voice : voices_) {
    if (!voice.plays) return &voice;
    const auto worth = [](const Voice& v) { return std::pair(rank_of(v.kind), -v.age); };
    if (worst == nullptr || worth(voice) < worth(*worst)) worst = &voice;
  }
  return rank_of(worst->kind) <= rank_of(kind) ? worst : nullptr;
}

void SoundEngine::start(Voice& voice, const SoundCue& cue) {
  const std::vector<ALuint>& takes = buffers_[static_cast<std::size_t>(cue.kind)];
  std::size_t take = static_cast<std::size_t>(chance_.between(0, static_cast<double>(takes.size())));
  if (cue.kind == SoundKind::beep) {
    take = static_cast<std::size_t>(std::lround(std::max(saturation_, static_cast<double>(kLowestBeep)))) - kLowestBeep;
  }
  alSourceStop(voice.source);
  alSourcei(voice.source, AL_BUFFER, static_cast<ALint>(takes[take]));
  place(voice.source, cue.position, from_machines(cue.kind));
  alSourcef(voice.source, AL_GAIN, static_cast<float>(std::clamp(cue.gain, 0.0, 2.0) * level_of(cue.kind)));
  alSourcePlay(voice.source);
  voice.kind = cue.kind;
  voice.age = 0;
  voice.plays = true;
}

bool SoundEngine::play(const SoundCue& cue) {
  if (loops(cue.kind) || !std::isfinite(cue.gain) || cue.gain <= 0) return false;
  for (const Voice& voice : voices_) {
    if (voice.plays && voice.kind == cue.kind && voice.age < kTogether) return false;
  }
  Voice* voice = free_voice(cue.kind);
  if (voice == nullptr) return false;
  start(*voice, cue);
  return true;
}

void SoundEngine::set_volume(double volume, bool muted) {
  alListenerf(AL_GAIN, muted ? 0.0F : static_cast<float>(finite(volume, 0, 1)));
}

double SoundEngine::until_beat() const {
  return heart_rate_ > 0 ? std::max(0.0, 1 - phase_) * 60 / heart_rate_ : 1e9;
}

void SoundEngine::beat(double seconds) {
  if (heart_rate_ <= 0) {
    phase_ = 1;  // the first beat comes at once
    return;
  }
  phase_ += seconds * heart_rate_ / 60;
  if (phase_ < 1) return;
  phase_ = std::min(phase_ - 1, 1.0);
  if (phase_ >= 1) phase_ = 0;  // after a long gap, one beat is enough
  play({SoundKind::beep, {}, 1});
}

void SoundEngine::advance(double seconds) {
  for (Voice& voice : voices_) {
    voice.age += seconds;
    if (!voice.plays) continue;
    ALint state = AL_STOPPED;
    alGetSourcei(voice.source, AL_SOURCE_STATE, &state);
    voice.plays = state == AL_PLAYING;
  }
  for (Loop& one : loops_) follow(one, seconds);
  beat(seconds);
}

int SoundEngine::voices() const {
  const auto playing = [](const auto& voice) { return voice.plays; };
  return static_cast<int>(std::count_if(loops_.begin(), loops_.end(), playing) +
                          std::count_if(voices_.begin(), voices_.end(), playing));
}

}  // namespace detail

}  // namespace calot
