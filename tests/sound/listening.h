// How the tests listen: levels, single frequencies, onsets.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "calot/sound/sounds.h"

namespace calot::test {

inline double rms(std::span<const float> samples) {
  double sum = 0;
  for (const float s : samples) sum += static_cast<double>(s) * s;
  return samples.empty() ? 0 : std::sqrt(sum / static_cast<double>(samples.size()));
}

inline double peak(std::span<const float> samples) {
  double most = 0;
  for (const float s : samples) most = std::max(most, std::abs(static_cast<double>(s)));
  return most;
}

/// Under a Hann window.
inline std::vector<float> windowed(std::span<const float> samples) {
  std::vector<float> out(samples.begin(), samples.end());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double along = static_cast<double>(i) / static_cast<double>(out.size());
    out[i] *= static_cast<float>(0.5 - 0.5 * std::cos(2 * std::numbers::pi * along));
  }
  return out;
}

/// Amplitude of one frequency of windowed samples: the Goertzel sum.
inline double goertzel(std::span<const float> samples, double frequency) {
  const double turn = 2 * std::numbers::pi * frequency / kSampleRate, coefficient = 2 * std::cos(turn);
  double s1 = 0, s2 = 0;
  for (const float s : samples) {
    const double s0 = s + coefficient * s1 - s2;
    s2 = s1;
    s1 = s0;
  }
  return 4 * std::sqrt(std::max(0.0, s1 * s1 + s2 * s2 - coefficient * s1 * s2)) / static_cast<double>(samples.size());
}

inline double amplitude_at(std::span<const float> samples, double frequency) {
  return goertzel(windowed(samples), frequency);
}

/// The strongest frequency of a range, to 0.2 %.
inline double strongest(std::span<const float> samples, double low, double high) {
  const std::vector<float> window = windowed(samples);
  double best = low, most = 0;
  for (double f = low; f <= high; f *= 1.002) {
    const double a = goertzel(window, f);
    if (a > most) {
      most = a;
      best = f;
    }
  }
  return best;
}

/// Energy between two frequencies in the first tenth of a second, to compare with that of another range.
inline double level_between(std::span<const float> samples, double low, double high) {
  const std::vector<float> window = windowed(samples.subspan(0, std::min<std::size_t>(samples.size(), 4800)));
  double sum = 0;
  for (double f = low; f < high; f *= 1.01) sum += std::pow(goertzel(window, f), 2) * f;
  return sum;
}

/// One channel of interleaved 16-bit stereo as −1 … 1.
inline std::vector<float> channel(std::span<const std::int16_t> stereo, std::size_t which) {
  std::vector<float> out;
  for (std::size_t i = which; i < stereo.size(); i += 2) out.push_back(static_cast<float>(stereo[i]) / 32768.0F);
  return out;
}

/// Time of the first sample louder than this [s], or −1.
inline double onset(std::span<const float> samples, double threshold) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::abs(samples[i]) > threshold) return static_cast<double>(i) / kSampleRate;
  }
  return -1;
}

}  // namespace calot::test
