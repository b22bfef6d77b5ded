// What is synthesised, before anything plays it.
#include <gtest/gtest.h>

#include <string>

#include "calot/sound/sounds.h"
#include "tests/sound/listening.h"

namespace calot {
namespace {

class EverySound : public testing::TestWithParam<SoundKind> {};

TEST_P(EverySound, IsWithinItsLimitsAndHasNoConstantPart) {
  const std::vector<float> samples = synthesise(GetParam(), 3);
  ASSERT_GT(samples.size(), 0.05 * kSampleRate);
  double sum = 0;
  for (const float s : samples) {
    ASSERT_TRUE(std::isfinite(s));
    sum += s;
  }
  EXPECT_LE(test::peak(samples), 0.9001);
  EXPECT_LT(std::abs(sum / static_cast<double>(samples.size())), 1e-5);
  EXPECT_GT(test::rms(samples), 0.01) << "cannot be heard";
  EXPECT_LT(test::rms(samples), 0.35) << "shouts";
}

TEST_P(EverySound, IsTheSameEachTimeAndAnotherForAnotherSeedUnlessItIsATone) {
  const SoundKind kind = GetParam();
  EXPECT_EQ(synthesise(kind, 5), synthesise(kind, 5));
  const bool tone = kind == SoundKind::error || kind == SoundKind::attention || kind == SoundKind::beep ||
                    kind == SoundKind::cut_tone || kind == SoundKind::coag_tone || kind == SoundKind::alarm_low ||
                    kind == SoundKind::alarm_medium || kind == SoundKind::alarm_high;
  EXPECT_EQ(synthesise(kind, 5) == synthesise(kind, 6), tone);
}

TEST_P(EverySound, DoesNotClickAtItsEndsOrAtItsSeam) {
  const std::vector<float> samples = synthesise(GetParam(), 1);
  if (!loops(GetParam())) {
    EXPECT_LT(std::abs(samples.front()), 1e-3);
    EXPECT_LT(std::abs(samples.back()), 1e-3);
    return;
  }
  // The step and the bend across the seam are no larger than what the sound does anyway.
  const std::size_t n = samples.size();
  const auto at = [&](std::size_t i) { return static_cast<double>(samples[i % n]); };
  double step = 0, bend = 0;
  for (std::size_t i = 2; i + 2 < n; ++i) {
    step = std::max(step, std::abs(at(i + 1) - at(i)));
    bend = std::max(bend, std::abs(at(i + 1) - 2 * at(i) + at(i - 1)));
  }
  EXPECT_LE(std::abs(at(n) - at(n - 1)), step);
  for (const std::size_t i : {n - 1, n}) EXPECT_LE(std::abs(at(i + 1) - 2 * at(i) + at(i - 1)), bend);
}

TEST_P(EverySound, OfALoopIsAsLoudAtItsSeamAsElsewhere) {
  if (GetParam() != SoundKind::sizzle && GetParam() != SoundKind::suction_air && GetParam() != SoundKind::room) {
    SUCCEED();  // the others have pauses of their own
    return;
  }
  const std::vector<float> samples = synthesise(GetParam(), 1);
  std::vector<float> seam(samples.end() - 6000, samples.end());
  seam.insert(seam.end(), samples.begin(), samples.begin() + 6000);
  EXPECT_NEAR(test::rms(seam) / test::rms(samples), 1, 0.45);
}

std::string test_name(const testing::TestParamInfo<SoundKind>& info) {
  std::string name(name_of(info.param));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Sounds, EverySound, testing::ValuesIn(all_sounds()), test_name);

TEST(Beep, FallsHalfASemitoneForEachPerCent) {
  for (const double saturation : {100.0, 97.0, 90.0, 81.0, 72.0}) {
    const std::vector<float> samples = synthesise(SoundKind::beep, 0, {.saturation = saturation});
    const double expected = 880 * std::pow(2, (saturation - 100) / 24);
    EXPECT_NEAR(beep_frequency(saturation), expected, 1e-9);
    EXPECT_NEAR(test::strongest(samples, 300, 1200) / expected, 1, 0.01);
  }
  EXPECT_EQ(beep_frequency(std::nan("")), beep_frequency(50));
  EXPECT_EQ(beep_frequency(140), 880);
}

TEST(GeneratorTone, OfCutAndOfCoagulationAreToldApart) {
  const std::vector<float> cut = synthesise(SoundKind::cut_tone), coag = synthesise(SoundKind::coag_tone);
  EXPECT_NEAR(test::strongest(std::span(cut).subspan(0, 9600), 300, 1500), 660, 6.6);
  EXPECT_NEAR(test::strongest(std::span(coag).subspan(0, 9600), 300, 1500), 940, 9.4);
  EXPECT_GT(test::amplitude_at(cut, 660), 0.15);
}

TEST(Spectrum, OfEachNoiseIsWhereItBelongs) {
  const std::vector<float> sizzle = synthesise(SoundKind::sizzle), room = synthesise(SoundKind::room),
                           gurgle = synthesise(SoundKind::suction_fluid), air = synthesise(SoundKind::suction_air);
  EXPECT_GT(test::level_between(sizzle, 2000, 12000), 20 * test::level_between(sizzle, 50, 1000));
  EXPECT_GT(test::level_between(room, 40, 500), 20 * test::level_between(room, 2000, 12000));
  EXPECT_GT(test::level_between(gurgle, 250, 2000), 5 * test::level_between(gurgle, 4000, 12000));
  EXPECT_GT(test::level_between(air, 400, 6000), 10 * test::level_between(air, 50, 200));
}

TEST(Crackle, ComesMoreOftenWhenDense) {
  const auto bursts = [](SoundKind kind) {
    const std::vector<float> samples = synthesise(kind);
    int count = 0;
    std::size_t quiet = 10000;
    for (const float s : samples) {
      quiet = std::abs(s) > 0.05F ? 0 : quiet + 1;
      if (quiet == 480) ++count;  // 10 ms of quiet end a burst
    }
    return count / (static_cast<double>(samples.size()) / kSampleRate);
  };
  EXPECT_GT(bursts(SoundKind::crackle), 2);
  EXPECT_GT(bursts(SoundKind::crackle_dense), 2 * bursts(SoundKind::crackle));
}

/// Where the pulses reach and leave 90 % of their amplitude, and where they pass 10 % [s].
struct Pulse {
  double from_10, from_90, to_90, to_10;
};
std::vector<Pulse> pulses_of(const std::vector<float>& samples, double frequency) {
  const auto period = static_cast<std::size_t>(std::lround(kSampleRate / frequency));
  std::vector<float> envelope(samples.size());
  for (std::size_t i = 0; i + period < samples.size(); ++i) {
    envelope[i + period / 2] = static_cast<float>(test::peak(std::span(samples).subspan(i, period)));
  }
  const double top = test::peak(envelope);
  std::vector<Pulse> pulses;
  bool inside = false, full = false;
  for (std::size_t i = 0; i < envelope.size(); ++i) {
    const double t = static_cast<double>(i) / kSampleRate, level = envelope[i] / top;
    if (!inside && level > 0.1) pulses.push_back({t, t, t, t});
    if (inside && level <= 0.1) pulses.back().to_10 = t;
    inside = level > 0.1;
    if (!full && level > 0.9) pulses.back().from_90 = t;
    if (full && level <= 0.9) pulses.back().to_90 = t;
    full = level > 0.9;
  }
  return pulses;
}

struct Limits {
  SoundKind kind;
  std::size_t count;
  double shortest, longest;      // pulse [s]
  double space_low, space_high;  // x or y
  double pause_low, pause_high;
};
class Alarm : public testing::TestWithParam<Limits> {};

TEST_P(Alarm, KeepsToTheStandard) {
  const Limits& limits = GetParam();
  const std::vector<float> samples = synthesise(limits.kind);
  const double frequency = test::strongest(std::span(samples).subspan(2400, 4800), 150, 1000);
  EXPECT_NEAR(frequency, alarm_burst(limits.kind).frequency, 6);
  const std::vector<Pulse> pulses = pulses_of(samples, frequency);
  ASSERT_EQ(pulses.size(), limits.count);
  const double first = pulses[1].from_90 - pulses[0].to_90;
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    const double duration = pulses[i].to_90 - pulses[i].from_90, rise = pulses[i].from_90 - pulses[i].from_10;
    EXPECT_GT(duration, limits.shortest);
    EXPECT_LT(duration, limits.longest);
    EXPECT_GT(rise, 0.1 * duration);
    EXPECT_LT(rise, 0.4 * duration);
    if (i + 1 == pulses.size()) break;
    const double space = pulses[i + 1].from_90 - pulses[i].to_90;
    const double fall = pulses[i].to_10 - pulses[i].to_90;
    EXPECT_LE(fall, space - rise);
    if (i == 4) {
      EXPECT_GT(space, 0.35);  // between the halves of ten
      EXPECT_LT(space, 1.30);
    } else if (i == 2 || i == 7) {
      EXPECT_NEAR(space, 2 * first + duration, 0.05 * (2 * first + duration));
    } else {
      EXPECT_GT(space, limits.space_low);
      EXPECT_LT(space, limits.space_high);
      EXPECT_NEAR(space, first, 0.05 * first);
    }
  }
  const double pause = static_cast<double>(samples.size()) / kSampleRate - pulses.back().to_90 + pulses[0].from_90;
  EXPECT_GT(pause, limits.pause_low);
  EXPECT_LT(pause, limits.pause_high);
}

TEST_P(Alarm, HasAtLeastFourHarmonicsWithin15Decibels) {
  const std::vector<float> samples = synthesise(GetParam().kind);
  const auto pulse = std::span(samples).subspan(2400, 4800);
  const double frequency = alarm_burst(GetParam().kind).frequency, first = test::amplitude_at(pulse, frequency);
  int near = 0;
  for (int k = 2; k * frequency <= 4000; ++k) {
    near += std::abs(20 * std::log10(test::amplitude_at(pulse, k * frequency) / first)) < 15;
  }
  EXPECT_GE(near, 4);
}

// [Iec2006] Tables 3 and 4.
INSTANTIATE_TEST_SUITE_P(Priorities, Alarm,
                         testing::Values(Limits{SoundKind::alarm_high, 10, 0.075, 0.200, 0.050, 0.125, 2.5, 15},
                                         Limits{SoundKind::alarm_medium, 3, 0.125, 0.250, 0.125, 0.250, 2.5, 30},
                                         Limits{SoundKind::alarm_low, 2, 0.125, 0.250, 0.125, 0.250, 15, 1e9}),
                         [](const auto& each) {
                           return test_name({each.param.kind, 0});
                         });

TEST(Alarms, AreLouderTheMoreUrgent) {
  const auto loud = [](SoundKind kind) { return test::peak(synthesise(kind)); };
  EXPECT_GT(loud(SoundKind::alarm_high), loud(SoundKind::alarm_medium));
  EXPECT_GT(loud(SoundKind::alarm_medium), loud(SoundKind::alarm_low));
}

}  // namespace
}  // namespace calot
