// Instruments: metal on metal, handles, valves.
#include <cmath>

#include "calot/sound/kinds.h"

namespace calot::detail {

namespace {

/// Small steel parts meet: a handful of high modes that die within a few hundredths of a second, over the dull knock of
/// the handle.
void add_click(Samples& samples, double time, double pitch, double amplitude, double ring, Chance& chance) {
  const std::size_t at = samples_of(time);
  constexpr double kRatios[] = {1, 1.58, 2.24, 2.92, 3.84};  // of a stiff bar's modes, spread by its fittings
  double share = 1;
  for (const double ratio : kRatios) {
    const double frequency = pitch * ratio * chance.between(0.97, 1.03);
    if (frequency > 0.45 * kSampleRate) break;
    add_mode(samples, at, {frequency, ring / ratio, amplitude * share * chance.between(0.7, 1.3), 0.00015, 0});
    share *= 0.7;
  }
  add_puff(samples, at, {pitch * 1.3, 0.6, 0.0012, 0.9 * amplitude, 0.0002}, chance);
}

void add_knock(Samples& samples, double time, double pitch, double amplitude, Chance& chance) {
  add_mode(samples, samples_of(time), {pitch * chance.between(0.95, 1.05), 0.012, amplitude, 0.001, 0});
  add_mode(samples, samples_of(time), {pitch * 2.3, 0.006, 0.5 * amplitude, 0.0008, 0});
}

}  // namespace

Samples make_snip(Chance& chance) {
  Samples samples(samples_of(0.26));
  // Two edges slide over each other: noise whose band climbs as the point of contact runs to the tip.
  const double slide = chance.between(0.050, 0.065);
  const int grains = 60;
  for (int i = 0; i < grains; ++i) {
    const double along = (i + chance.between(0, 1)) / grains;
    const double amplitude = (0.1 + 0.3 * along * along) * chance.between(0.3, 1);
    const Puff grain{3200 + 4200 * along, 1.6, 0.0018, amplitude, 0.0006};
    add_puff(samples, samples_of(slide * along), grain, chance);
  }
  add_click(samples, slide, chance.between(2700, 3100), 1, 0.022, chance);
  add_knock(samples, slide + 0.002, 420, 0.35, chance);
  finish_once(samples, 0.16);
  return samples;
}

Samples make_ratchet(Chance& chance) {
  Samples samples(samples_of(0.2));
  double time = 0.001, gap = chance.between(0.030, 0.036);
  for (int tooth = 0; tooth < 3; ++tooth) {
    add_click(samples, time, chance.between(1850, 2050) * (1 + 0.05 * tooth), 0.6 + 0.2 * tooth, 0.007, chance);
    add_knock(samples, time, 640, 0.2, chance);
    time += gap;
    gap *= 1.12;  // the hand meets the tissue's resistance
  }
  finish_once(samples, 0.15);
  return samples;
}

Samples make_ratchet_release(Chance& chance) {
  Samples samples(samples_of(0.14));
  add_click(samples, 0.001, chance.between(1500, 1650), 0.7, 0.008, chance);
  add_click(samples, 0.019, chance.between(1150, 1250), 1, 0.010, chance);
  add_knock(samples, 0.019, 380, 0.5, chance);
  finish_once(samples, 0.13);
  return samples;
}

Samples make_clip(Chance& chance) {
  Samples samples(samples_of(0.36));
  double time = 0.001, gap = chance.between(0.024, 0.028);
  for (int tooth = 0; tooth < 4; ++tooth) {
    add_click(samples, time, chance.between(1600, 1750), 0.35 + 0.07 * tooth, 0.005, chance);
    time += gap;
    gap *= 1.08;
  }
  time += 0.02;  // the clip's legs meet, the applier's handle strikes its stop
  add_click(samples, time, chance.between(2300, 2500), 1, 0.014, chance);
  add_knock(samples, time, 310, 0.9, chance);
  add_click(samples, time + 0.055, chance.between(1300, 1400), 0.3, 0.008, chance);  // spring back
  finish_once(samples, 0.17);
  return samples;
}

Samples make_exchange(Chance& chance) {
  Samples samples(samples_of(0.34));
  // The flap of the trocar's valve gives way, some gas escapes past the shaft, the flap falls back.
  add_knock(samples, 0.001, 260, 0.9, chance);
  add_click(samples, 0.001, chance.between(950, 1050), 0.35, 0.006, chance);
  add_puff(samples, samples_of(0.006), {2400, 0.5, 0.045, 0.5, 0.03}, chance);
  const double back = chance.between(0.15, 0.17);
  add_knock(samples, back, 340, 0.5, chance);
  add_click(samples, back, chance.between(1250, 1400), 0.45, 0.006, chance);
  finish_once(samples, 0.12, 0.0005, 0.04);
  return samples;
}

Samples make_slip(Chance& chance) {
  Samples samples(samples_of(0.16));
  for (int i = 0; i < 14; ++i) {  // wet tissue catches on one row of teeth after the other
    const double along = i / 14.0;
    const Puff grain{chance.octaves(350, 900), 1.2, 0.005, 1 - 0.8 * along, 0.002};
    add_puff(samples, samples_of(0.07 * along + chance.between(0, 0.004)), grain, chance);
  }
  add_mode(samples, samples_of(0.05), {210, 0.012, 0.35, 0.003, -2});
  finish_once(samples, 0.07, 0.001, 0.05);
  return samples;
}

Samples make_tear(Chance& chance) {
  Samples samples(samples_of(0.3));
  for (int i = 0; i < 70; ++i) {  // fibres give way in bunches
    const double time = 0.2 * std::pow(chance.between(0, 1), 1.4);
    const Puff fibre{chance.octaves(500, 2600), 1.1, 0.003, (1 - 3.5 * time) * chance.octaves(0.1, 1), 0.0005};
    add_puff(samples, samples_of(time), fibre, chance);
  }
  finish_once(samples, 0.1, 0.001, 0.06);
  return samples;
}

}  // namespace calot::detail
