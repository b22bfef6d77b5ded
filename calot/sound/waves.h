// Inside this room only: what sounds are put together from.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calot/sound/sounds.h"

namespace calot::detail {

using Samples = std::vector<float>;

inline std::size_t samples_of(double seconds) {
  return static_cast<std::size_t>(seconds * kSampleRate + 0.5);
}

/// SplitMix64 [Steele2014]: the same numbers on every machine.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : state_(seed) {}
  /// Each value as likely as any other in [low, high).
  double between(double low, double high);
  /// In [low, high), each octave as likely as any other; low > 0.
  double octaves(double low, double high);
  /// White noise, −1 … 1.
  double noise() { return between(-1, 1); }

 private:
  std::uint64_t state_;
};

/// Second-order filter, bilinear transform of the analogue prototype.
class Filter {
 public:
  static Filter low(double frequency, double q = 0.7071);
  static Filter high(double frequency, double q = 0.7071);
  /// Gain 1 at the middle.
  static Filter band(double frequency, double q);
  double operator()(double in);
  void run(Samples& samples);

 private:
  Filter(double b0, double b1, double b2, double a0, double a1, double a2);
  double b0_, b1_, b2_, a1_, a2_;
  double z1_ = 0, z2_ = 0;
};

/// A resonance that rings down. Its start is rounded over `attack`, so that it does not click.
struct Mode {
  double frequency = 1000;  ///< [Hz]
  double decay = 0.01;      ///< to 1/e [s]
  double amplitude = 1;
  double attack = 0.0003;  ///< [s]
  double rise = 0;         ///< relative change of the frequency per second
};
/// Adds the mode from sample `start` on; what goes beyond the end is lost, or with `around` starts over at 0 (for
/// loops).
void add_mode(Samples& samples, std::size_t start, const Mode& mode, bool around = false);
/// Adds noise through a band-pass that swells within `attack` and then decays, like add_mode.
struct Puff {
  double frequency = 1000, q = 1;
  double decay = 0.01, amplitude = 1, attack = 0.001;
};
void add_puff(Samples& samples, std::size_t start, const Puff& puff, Chance& chance, bool around = false);

/// Noise of the given length through `shape`, as a loop: its end is faded into its start at equal power.
Samples noise_loop(std::size_t count, Chance& chance, std::vector<Filter> shape);
/// Smooth random numbers about 1, a loop: 1 + depth × (band-limited noise up to `frequency` [Hz], −1 … 1).
Samples flutter_loop(std::size_t count, Chance& chance, double frequency, double depth);

/// A sum of sines with the given amplitudes at 1, 2, 3 … times the frequency, all starting at 0.
Samples partials(std::size_t count, double frequency, const std::vector<double>& amplitudes);
/// Raised-cosine ends, `in` and `out` samples long.
void fade(Samples& samples, std::size_t in, std::size_t out);

/// To the wanted root mean square over its loudest 50 ms, its peak at most 0.9, mean 0.
void finish_loop(Samples& samples, double level);
/// The same, with ends that start and end with 0.
void finish_once(Samples& samples, double level, double fade_in = 0.0005, double fade_out = 0.02);

}  // namespace calot::detail
