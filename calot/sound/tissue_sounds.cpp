// Burning tissue, suction, the room: sounds without end, from many small events placed around a circle of time.
#include <algorithm>
#include <cmath>

#include "calot/sound/kinds.h"

namespace calot::detail {

namespace {

void multiply(Samples& samples, const Samples& by) {
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] *= by[i];
}

void add(Samples& samples, const Samples& other, double gain) {
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] += static_cast<float>(gain * other[i]);
}

/// A gas bubble in water: rings at 3/r, decays by 0.13/r + 0.0072 r^-1.5 per second (radius r [m]) and climbs as it
/// nears the surface [VanDenDoel2005].
void add_bubble(Samples& samples, std::size_t start, double radius, double amplitude, double climb) {
  const double damping = 0.13 / radius + 0.0072 * std::pow(radius, -1.5);
  add_mode(samples, start, {3 / radius, 1 / damping, amplitude, 0.002, climb * damping}, true);
}

}  // namespace

Samples make_sizzle(Chance& chance) {
  const std::size_t count = samples_of(5);
  Samples samples(count);
  // Steam breaks out of the surface in thousands of tiny bursts, most of them faint.
  for (int i = 0; i < 9000; ++i) {
    const std::size_t at = static_cast<std::size_t>(chance.between(0, static_cast<double>(count)));
    const double size = 0.08 * std::min(10.0, std::pow(chance.between(0.01, 1), -0.7));
    const Puff burst{chance.octaves(2200, 9500), 1.5, chance.octaves(0.0004, 0.002), size, 0.0002};
    add_puff(samples, at, burst, chance, true);
  }
  Samples steam = noise_loop(count, chance, {Filter::high(2500), Filter::low(9000), Filter::low(12000)});
  multiply(steam, flutter_loop(count, chance, 12, 0.55));
  add(samples, steam, 0.35);
  multiply(samples, flutter_loop(count, chance, 3, 0.25));
  finish_loop(samples, 0.13);
  return samples;
}

Samples make_crackle(Chance& chance, double rate) {
  const std::size_t count = samples_of(7);
  Samples samples(count);
  const int bursts = static_cast<int>(7 * rate);
  for (int i = 0; i < bursts; ++i) {
    const std::size_t at = static_cast<std::size_t>(chance.between(0, static_cast<double>(count)));
    const double size = 0.15 * std::min(6.0, std::pow(chance.between(0.02, 1), -0.5));
    const double pitch = chance.octaves(900, 4200);
    add_puff(samples, at, {pitch, 0.8, chance.octaves(0.0008, 0.004), size, 0.0001}, chance, true);
    add_mode(samples, at, {pitch * 0.45, chance.octaves(0.001, 0.005), 0.5 * size, 0.0002, 0}, true);
  }
  finish_loop(samples, 0.15);
  return samples;
}

Samples make_suction_air(Chance& chance) {
  const std::size_t count = samples_of(4);
  Samples samples = noise_loop(count, chance, {Filter::band(1900, 0.5), Filter::low(6500)});
  // The tube's own notes colour the rush of gas: a pipe of 33 cm, open at both ends.
  for (const double note : {520.0, 1040.0, 1560.0})
    add(samples, noise_loop(count, chance, {Filter::band(note, 12)}), 0.9);
  multiply(samples, flutter_loop(count, chance, 5, 0.22));
  finish_loop(samples, 0.09);
  return samples;
}

Samples make_suction_fluid(Chance& chance) {
  const std::size_t count = samples_of(6);
  Samples samples(count);
  // Gulps: fluid and gas take turns in the tube, seven or so times a second, never evenly.
  double time = 0;
  while (time < 6) {
    const int bubbles = static_cast<int>(chance.between(3, 12));
    const double length = chance.between(0.05, 0.13), strength = chance.octaves(0.35, 1);
    for (int i = 0; i < bubbles; ++i) {
      const std::size_t at = samples_of(time + chance.between(0, length)) % count;
      const double radius = chance.octaves(0.0018, 0.0085);
      add_bubble(samples, at, radius, strength * chance.octaves(0.2, 1), chance.between(0.05, 0.3));
    }
    add_puff(samples, samples_of(time) % count, {chance.octaves(500, 1100), 0.8, length, 0.45 * strength, 0.02}, chance,
             true);
    time += chance.between(0.09, 0.2);
  }
  Samples rush = noise_loop(count, chance, {Filter::band(1100, 0.5), Filter::low(4500)});
  multiply(rush, flutter_loop(count, chance, 9, 0.8));
  add(samples, rush, 0.22);
  finish_loop(samples, 0.16);
  return samples;
}

Samples make_room(Chance& chance) {
  const std::size_t count = samples_of(8);
  Samples samples = noise_loop(count, chance, {Filter::high(45), Filter::low(170), Filter::low(600, 0.6)});
  add(samples, noise_loop(count, chance, {Filter::band(420, 0.4), Filter::low(1800)}), 0.14);  // air through grilles
  multiply(samples, flutter_loop(count, chance, 0.8, 0.12));
  // Transformers and fans of the machines; whole numbers of periods in 8 s.
  add(samples, partials(count, 100, {1, 0.4, 0.2}), 0.004);
  add(samples, partials(count, 117.5, {1, 0.2}), 0.003);
  finish_loop(samples, 0.05);
  return samples;
}

}  // namespace calot::detail
