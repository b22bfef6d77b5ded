#include "calot/sound/waves.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace calot::detail {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPeak = 0.9;

double swell(double time, double attack) {
  return time >= attack ? 1.0 : 0.5 - 0.5 * std::cos(kPi * time / attack);
}

/// Root mean square of the loudest 50 ms.
double loudness(const Samples& samples) {
  const std::size_t window = std::min(samples.size(), samples_of(0.05));
  double sum = 0, most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sum += static_cast<double>(samples[i]) * samples[i];
    if (i >= window) sum -= static_cast<double>(samples[i - window]) * samples[i - window];
    most = std::max(most, sum);
  }
  return window > 0 ? std::sqrt(most / static_cast<double>(window)) : 0;
}

void scale(Samples& samples, double level) {
  const double loud = loudness(samples);
  if (!(loud > 0)) return;
  double peak = 0;
  for (const float s : samples) peak = std::max(peak, std::abs(static_cast<double>(s)));
  const double gain = std::min(level / loud, kPeak / peak);
  for (float& s : samples) s = static_cast<float>(s * gain);
}

double mean(const Samples& samples) {
  return std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
}

}  // namespace

double Chance::between(double low, double high) {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  const double unit = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  return low + (high - low) * unit;
}

double Chance::octaves(double low, double high) {
  return std::exp(between(std::log(low), std::log(high)));
}

Filter::Filter(double b0, double b1, double b2, double a0, double a1, double a2)
    : b0_(b0 / a0), b1_(b1 / a0), b2_(b2 / a0), a1_(a1 / a0), a2_(a2 / a0) {}

Filter Filter::low(double frequency, double q) {
  const double w = 2 * kPi * frequency / kSampleRate, c = std::cos(w), a = std::sin(w) / (2 * q);
  return {(1 - c) / 2, 1 - c, (1 - c) / 2, 1 + a, -2 * c, 1 - a};
}

Filter Filter::high(double frequency, double q) {
  const double w = 2 * kPi * frequency / kSampleRate, c = std::cos(w), a = std::sin(w) / (2 * q);
  return {(1 + c) / 2, -1 - c, (1 + c) / 2, 1 + a, -2 * c, 1 - a};
}

Filter Filter::band(double frequency, double q) {
  const double w = 2 * kPi * frequency / kSampleRate, c = std::cos(w), a = std::sin(w) / (2 * q);
  return {a, 0, -a, 1 + a, -2 * c, 1 - a};
}

double Filter::operator()(double in) {
  const double out = b0_ * in + z1_;
  z1_ = b1_ * in - a1_ * out + z2_;
  z2_ = b2_ * in - a2_ * out;
  return out;
}

void Filter::run(Samples& samples) {
  for (float& s : samples) s = static_cast<float>((*this)(s));
}

void add_mode(Samples& samples, std::size_t start, const Mode& mode, bool around) {
  const std::size_t count = std::min(samples.size(), samples_of(mode.attack + 7 * mode.decay));
  double phase = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t at = start + i;
    if (at >= samples.size()) {
      if (!around) return;
      at %= samples.size();
    }
    const double t = static_cast<double>(i) / kSampleRate;
    samples[at] +=
        static_cast<float>(mode.amplitude * swell(t, mode.attack) * std::exp(-t / mode.decay) * std::sin(phase));
    phase += 2 * kPi * mode.frequency * (1 + mode.rise * t) / kSampleRate;
  }
}

void add_puff(Samples& samples, std::size_t start, const Puff& puff, Chance& chance, bool around) {
  const std::size_t count = std::min(samples.size(), samples_of(puff.attack + 7 * puff.decay));
  Filter band = Filter::band(puff.frequency, puff.q);
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t at = start + i;
    if (at >= samples.size()) {
      if (!around) return;
      at %= samples.size();
    }
    const double t = static_cast<double>(i) / kSampleRate;
    const double fall = std::exp(-std::max(0.0, t - puff.attack) / puff.decay);
    samples[at] += static_cast<float>(puff.amplitude * swell(t, puff.attack) * fall * band(chance.noise()));
  }
}

Samples noise_loop(std::size_t count, Chance& chance, std::vector<Filter> shape) {
  const std::size_t seam = std::min(count / 2, samples_of(0.25)), settle = samples_of(0.1);
  Samples long_one(count + seam);
  for (std::size_t i = 0; i < settle + long_one.size(); ++i) {
    double s = chance.noise();
    for (Filter& filter : shape) s = filter(s);
    if (i >= settle) long_one[i - settle] = static_cast<float>(s);
  }
  Samples loop(long_one.begin(), long_one.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < seam; ++i) {
    const double turn = kPi / 2 * static_cast<double>(i) / static_cast<double>(seam);
    loop[i] = static_cast<float>(std::sin(turn) * loop[i] + std::cos(turn) * long_one[count + i]);
  }
  return loop;
}

Samples flutter_loop(std::size_t count, Chance& chance, double frequency, double depth) {
  Samples loop = noise_loop(count, chance, {Filter::low(frequency)});
  float most = 0;
  for (const float s : loop) most = std::max(most, std::abs(s));
  for (float& s : loop) s = static_cast<float>(1 + depth * s / most);
  return loop;
}

Samples partials(std::size_t count, double frequency, const std::vector<double>& amplitudes) {
  Samples samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double phase = 2 * kPi * frequency * static_cast<double>(i) / kSampleRate;
    double sum = 0;
    for (std::size_t k = 0; k < amplitudes.size(); ++k)
      sum += amplitudes[k] * std::sin(phase * static_cast<double>(k + 1));
    samples[i] = static_cast<float>(sum);
  }
  return samples;
}

void fade(Samples& samples, std::size_t in, std::size_t out) {
  for (std::size_t i = 0; i < std::min(in, samples.size()); ++i) {
    samples[i] *= static_cast<float>(swell(static_cast<double>(i), static_cast<double>(in)));
  }
  for (std::size_t i = 0; i < std::min(out, samples.size()); ++i) {
    samples[samples.size() - 1 - i] *= static_cast<float>(swell(static_cast<double>(i), static_cast<double>(out)));
  }
}

void finish_loop(Samples& samples, double level) {
  const double middle = mean(samples);
  for (float& s : samples) s = static_cast<float>(s - middle);
  scale(samples, level);
}

void finish_once(Samples& samples, double level, double fade_in, double fade_out) {
  fade(samples, samples_of(fade_in), samples_of(fade_out));
  Samples window(samples.size(), 1.0F);
  fade(window, window.size() / 2, window.size() - window.size() / 2);
  const double share = mean(samples) / mean(window);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<float>(samples[i] - share * window[i]);
  scale(samples, level);
}

}  // namespace calot::detail
