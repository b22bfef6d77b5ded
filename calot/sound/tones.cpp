// What machines say: monitor, alarms, generator, the program itself.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/sound/kinds.h"

namespace calot {

double beep_frequency(double saturation) {
  const double shown = std::isfinite(saturation) ? std::clamp(std::round(saturation), 50.0, 100.0) : 50.0;
  return 880 * std::exp2((shown - 100) / 24);
}

AlarmBurst alarm_burst(SoundKind kind) {
  AlarmBurst burst;
  burst.frequency = 523.25;
  switch (kind) {
    case SoundKind::alarm_high: {
      constexpr double kX = 0.1, kPulse = 0.15, kHalves = 0.5;
      burst.pulses = 10;
      burst.pulse = kPulse;
      burst.space = {kX, kX, 2 * kX + kPulse, kX, kHalves, kX, kX, 2 * kX + kPulse, kX};
      burst.pause = 4;
      burst.level = 0.45;
      break;
    }
    case SoundKind::alarm_medium:
      burst.pulses = 3;
      burst.pulse = 0.2;
      burst.space = {0.2, 0.2};
      burst.pause = 8;
      burst.level = 0.32;
      break;
    default:
      burst.pulses = 2;
      burst.pulse = 0.2;
      burst.space = {0.2};
      burst.pause = 18;
      burst.level = 0.22;
  }
  burst.rise = 0.2 * burst.pulse;
  return burst;
}

namespace detail {

Samples make_beep(double frequency) {
  Samples samples = partials(samples_of(0.12), frequency, {1, 0.12, 0.05});
  finish_once(samples, 0.22, 0.006, 0.05);
  return samples;
}

Samples make_generator_tone(double frequency) {
  Samples samples =
      partials(samples_of(1), frequency, {1, 0.22, 0.3, 0.06, 0.1});  // a small loudspeaker in a steel case
  finish_loop(samples, 0.16);
  return samples;
}

Samples make_error() {
  const std::size_t pulse = samples_of(0.13), gap = samples_of(0.05);
  Samples samples(2 * pulse + gap);
  for (const std::size_t start : {std::size_t{0}, pulse + gap}) {
    Samples one = partials(pulse, start == 0 ? 233.08 : 196, {1, 0.5, 0.6, 0.25, 0.3, 0.1});
    fade(one, samples_of(0.006), samples_of(0.03));
    std::copy(one.begin(), one.end(), samples.begin() + static_cast<std::ptrdiff_t>(start));
  }
  finish_once(samples, 0.16);
  return samples;
}

Samples make_attention() {
  Samples samples(samples_of(0.7));
  for (const auto& [time, note] : {std::pair{0.0, 783.99}, {0.12, 1046.5}}) {
    add_mode(samples, samples_of(time), {note, 0.13, 1, 0.004, 0});
    add_mode(samples, samples_of(time), {2.76 * note, 0.03, 0.15, 0.002, 0});  // a struck bar's second mode
  }
  finish_once(samples, 0.14, 0.001, 0.1);
  return samples;
}

Samples make_alarm(const AlarmBurst& burst) {
  // A raised cosine takes (arccos −0.8 − arccos 0.8)/π of its length from 10 to 90 %, and arccos 0.8/π from 90 to 100.
  const double tail = std::acos(0.8) / std::numbers::pi, ramp = burst.rise / (1 - 2 * tail);
  const std::size_t whole = samples_of(burst.pulse + 2 * ramp * (1 - tail));
  Samples pulse = partials(whole, burst.frequency, {1, 0.7, 0.5, 0.4, 0.3, 0.25});
  fade(pulse, samples_of(ramp), samples_of(ramp));
  double total = burst.pulse * burst.pulses + burst.pause;
  for (const double space : burst.space) total += space;
  Samples samples(samples_of(total));
  double time = 0;
  for (int i = 0; i < burst.pulses; ++i) {
    const std::size_t start = samples_of(time);
    for (std::size_t k = 0; k < pulse.size(); ++k) samples[start + k] += pulse[k];
    if (i + 1 < burst.pulses) time += burst.pulse + burst.space[static_cast<std::size_t>(i)];
  }
  finish_loop(samples, burst.level / std::numbers::sqrt2);
  return samples;
}

}  // namespace detail

}  // namespace calot
