// What comes out of the loudspeakers, rendered into memory by OpenAL's loopback device.
#include <gtest/gtest.h>

#include "calot/sound/sound_recorder.h"
#include "tests/sound/listening.h"

namespace calot {
namespace {

SoundScene quiet() {
  SoundScene scene;
  scene.room = false;
  return scene;
}

std::size_t seconds(double time) {
  return static_cast<std::size_t>(time * kSampleRate);
}

/// Energy of the right channel over that of the left.
double right_to_left(std::span<const std::int16_t> stereo) {
  return std::pow(test::rms(test::channel(stereo, 1)) / test::rms(test::channel(stereo, 0)), 2);
}

std::vector<float> both(std::span<const std::int16_t> stereo) {
  std::vector<float> sum = test::channel(stereo, 0);
  const std::vector<float> right = test::channel(stereo, 1);
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = (sum[i] + right[i]) / 2;
  return sum;
}

std::vector<float> hear(SoundRecorder& recorder, const SoundScene& scene, double time) {
  recorder.update(scene);
  return both(recorder.render(seconds(time)));
}

class EveryCue : public testing::TestWithParam<SoundKind> {};

TEST_P(EveryCue, IsHeardWithin20MillisecondsFromItsSide) {
  SoundRecorder recorder;
  for (const double side : {-1.0, 0.0, 1.0}) {
    EXPECT_EQ(test::peak(hear(recorder, quiet(), 0.1)), 0) << "not silent before";
    const SoundCue cue{GetParam(), SoundPosition(0.05 * side, 0.01, -0.09), 1};
    recorder.update(quiet(), std::span(&cue, 1));
    const std::vector<std::int16_t> stereo = recorder.render(seconds(0.8));
    const std::vector<float> mono = both(stereo);
    const double loudest = test::peak(mono), begins = test::onset(mono, 0.02 * loudest);
    EXPECT_GT(loudest, 0.01);
    EXPECT_GE(begins, 0);
    EXPECT_LT(begins, 0.020);
    const bool central =
        GetParam() == SoundKind::error || GetParam() == SoundKind::attention || GetParam() == SoundKind::beep;
    const double ratio = right_to_left(stereo);
    if (central || side == 0) {
      EXPECT_NEAR(ratio, 1, 0.05);
    } else {
      EXPECT_GT(side > 0 ? ratio : 1 / ratio, 4);
    }
    EXPECT_EQ(recorder.status().voices, 0) << "ends by itself";
  }
}

std::string test_name(const testing::TestParamInfo<SoundKind>& each) {
  std::string name(name_of(each.param));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
std::vector<SoundKind> cues() {
  std::vector<SoundKind> kinds;
  for (const SoundKind kind : all_sounds()) {
    if (!loops(kind)) kinds.push_back(kind);
  }
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(Cues, EveryCue, testing::ValuesIn(cues()), test_name);

TEST(Heard, CauteryPansAndItsToneBeginsAndEndsAtOnce) {
  SoundRecorder recorder;
  hear(recorder, quiet(), 0.1);
  SoundScene scene = quiet();
  scene.cautery = CauteryMode::coagulate;
  scene.cautery_power = 30;
  scene.cautery_position = SoundPosition(-0.04, 0, -0.08);
  const std::vector<float> begin = hear(recorder, scene, 0.3);
  EXPECT_LT(test::onset(begin, 0.005), 0.020);
  EXPECT_GT(test::amplitude_at(std::span(begin).subspan(4800), 940), 0.02);
  EXPECT_LT(test::amplitude_at(std::span(begin).subspan(4800), 660), 0.002);
  EXPECT_LT(right_to_left(recorder.render(seconds(0.3))), 0.5);
  const std::vector<float> end = hear(recorder, quiet(), 0.6);
  EXPECT_EQ(test::peak(std::span(end).subspan(seconds(0.45))), 0);
}

TEST(Heard, SizzleFollowsThePowerThatReachesTissue) {
  double before = 0;
  for (const double power : {0.0, 5.0, 10.0, 20.0, 40.0}) {
    SoundRecorder recorder;
    SoundScene scene = quiet();
    scene.cautery_power = power;
    hear(recorder, scene, 0.2);
    const double level = test::rms(hear(recorder, scene, 2));
    if (power == 0) {
      EXPECT_EQ(level, 0);
    }
    if (power > 5) {
      EXPECT_NEAR(level / before, std::sqrt(2), 0.25);  // twice the power, twice the energy
    }
    before = level;
  }
  EXPECT_GT(before, 0.02);
}

TEST(Heard, LoopsHaveNoGapAtTheirSeams) {
  SoundRecorder recorder;
  SoundScene scene = quiet();
  scene.cautery = CauteryMode::cut;
  hear(recorder, scene, 0.2);
  const std::vector<float> tone = hear(recorder, scene, 3.5);  // three seams
  double low = 1, high = 0;
  for (std::size_t i = 0; i + 480 <= tone.size(); i += 240) {
    const double level = test::rms(std::span(tone).subspan(i, 480));
    low = std::min(low, level);
    high = std::max(high, level);
  }
  EXPECT_GT(low, 0.9 * high);
  scene = quiet();
  scene.suction = true;
  SoundRecorder other;
  hear(other, scene, 0.2);
  const std::vector<float> hiss = hear(other, scene, 9);  // two seams
  const double mean = test::rms(hiss);
  for (std::size_t i = 0; i + 960 <= hiss.size(); i += 480) {
    EXPECT_GT(test::rms(std::span(hiss).subspan(i, 960)), 0.35 * mean) << i / 48 << " ms";
  }
}

TEST(Heard, SuctionGurglesWhenItTakesFluid) {
  SoundScene scene = quiet();
  scene.suction = true;
  SoundRecorder dry, wet;
  hear(dry, scene, 0.2);
  const std::vector<float> hiss = hear(dry, scene, 2);
  scene.suction_flow = 10e-6;
  hear(wet, scene, 0.2);
  const std::vector<float> gurgle = hear(wet, scene, 2);
  const auto dark = [](const std::vector<float>& s) {
    return test::level_between(s, 200, 900) / test::level_between(s, 2500, 9000);
  };
  EXPECT_GT(dark(gurgle), 4 * dark(hiss));
}

TEST(Heard, HeartbeatsKeepTheirRateAndFallWithSaturation) {
  SoundRecorder recorder;
  SoundScene scene = quiet();
  scene.heart_rate = 90;
  scene.saturation = 88;
  const std::vector<float> heard = hear(recorder, scene, 6);
  std::vector<double> beats;
  std::size_t silent = seconds(1);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    silent = std::abs(heard[i]) > 0.01 ? 0 : silent + 1;
    if (silent == 0 && (beats.empty() || static_cast<double>(i) / kSampleRate > beats.back() + 0.3)) {
      beats.push_back(static_cast<double>(i) / kSampleRate);
    }
  }
  ASSERT_EQ(beats.size(), 9U);
  EXPECT_LT(beats.front(), 0.020);
  for (std::size_t i = 1; i < beats.size(); ++i) EXPECT_NEAR(beats[i] - beats[i - 1], 60.0 / 90, 0.008);
  const auto beat = std::span(heard).subspan(seconds(beats[1]), seconds(0.1));
  EXPECT_NEAR(test::strongest(beat, 400, 1000) / beep_frequency(88), 1, 0.01);
}

TEST(Heard, AlarmSoundsWhileItLasts) {
  SoundRecorder recorder;
  SoundScene scene = quiet();
  scene.alarm = AlarmPriority::high;
  const std::vector<float> alarm = hear(recorder, scene, 1);
  EXPECT_LT(test::onset(alarm, 0.1 * test::peak(alarm)), 0.020);
  EXPECT_GT(test::amplitude_at(std::span(alarm).subspan(2400, 4800), 523.25), 0.02);
  const std::vector<float> after = hear(recorder, quiet(), 0.6);
  EXPECT_EQ(test::peak(std::span(after).subspan(seconds(0.45))), 0);
}

TEST(Heard, NothingWhenMutedAndAllAgainAfter) {
  SoundRecorder recorder;
  SoundScene scene;
  scene.cautery = CauteryMode::cut;
  scene.cautery_power = 40;
  scene.heart_rate = 70;
  EXPECT_GT(test::rms(hear(recorder, scene, 0.3)), 0.01);
  recorder.set_muted(true);
  hear(recorder, scene, 0.1);
  const SoundCue cue{SoundKind::snip, SoundPosition(0, 0, -0.1), 2};
  recorder.update(scene, std::span(&cue, 1));
  EXPECT_EQ(test::peak(both(recorder.render(seconds(1.5)))), 0);
  recorder.set_muted(false);
  EXPECT_GT(test::rms(hear(recorder, scene, 0.3)), 0.01);
}

TEST(Heard, EverythingAtOnceDoesNotOverload) {
  SoundRecorder recorder({.volume = 1});
  SoundScene scene;
  scene.cautery = CauteryMode::coagulate;
  scene.cautery_power = 60;
  scene.suction = true;
  scene.suction_flow = 5e-6;
  scene.heart_rate = 120;
  scene.alarm = AlarmPriority::high;
  scene.cautery_position = scene.suction_position = SoundPosition(0.05, 0, -0.06);
  std::vector<SoundCue> all;
  for (const SoundKind kind : cues()) all.push_back({kind, SoundPosition(0.05, 0, -0.06), 1});
  std::size_t full = 0, count = 0;
  for (int i = 0; i < 10; ++i) {
    recorder.update(scene, all);
    for (const std::int16_t s : recorder.render(seconds(0.3))) {
      full += s == 32767 || s == -32768;
      ++count;
    }
  }
  EXPECT_LT(static_cast<double>(full), 1e-4 * static_cast<double>(count));
}

TEST(Heard, ManyCuesNeitherCrashNorGrow) {
  SoundRecorder recorder;
  std::uint64_t asked = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<SoundCue> many;
    for (const SoundKind kind : all_sounds()) {  // loops are no cues
      const double gain = kind == SoundKind::clip && i % 3 == 0 ? std::nan("") : 1;
      const double x = kind == SoundKind::snip && i % 5 == 0 ? std::nan("") : 0.01;
      many.push_back({kind, SoundPosition(x, 0, -0.1), gain});
    }
    asked += many.size();
    recorder.update(quiet(), many);
    recorder.render(240);
    const SoundStatus status = recorder.status();
    ASSERT_LE(status.voices, kVoices);
    ASSERT_EQ(status.played + status.left_out, asked);
  }
  EXPECT_GT(recorder.status().played, 100U);
  recorder.render(seconds(1));
  EXPECT_EQ(recorder.status().voices, 0);
}

TEST(Heard, TheSameEachTime) {
  const auto record = [] {
    SoundRecorder recorder({.seed = 4});
    SoundScene scene;
    scene.cautery_power = 25;
    scene.heart_rate = 80;
    std::vector<std::int16_t> all;
    for (int i = 0; i < 20; ++i) {
      const SoundCue cue{SoundKind::snip, SoundPosition(0.01 * i - 0.1, 0, -0.1), 1};
      recorder.update(scene, std::span(&cue, 1));
      const std::vector<std::int16_t> part = recorder.render(1600);
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  };
  EXPECT_EQ(record(), record());
}

TEST(Mix, TakesNumbersThatAreNotFiniteAsNothing) {
  SoundScene scene;
  scene.suction = true;
  scene.cautery_power = scene.suction_flow = std::nan("");
  const SoundMix mix = mix_of(scene);
  EXPECT_EQ(mix.sizzle, 0);
  EXPECT_EQ(mix.suction_fluid, 0);
  EXPECT_EQ(mix.suction_air, 1);
}

}  // namespace
}  // namespace calot
