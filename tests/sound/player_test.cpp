// The player with its thread: without a device, and with OpenAL's own, which takes sound and makes none.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <thread>

#include "calot/sound/sound_player.h"
#include "tests/sound/listening.h"

namespace calot {
namespace {

using Clock = std::chrono::steady_clock;

/// Before OpenAL looks for devices: none but its silent one, so that tests run the same beside a real card.
class SilentDriver : public testing::Environment {
  void SetUp() override {
    setenv("ALSOFT_DRIVERS", "null", 1);
    setenv("ALSOFT_LOGLEVEL", "0", 1);
  }
};
const testing::Environment* const kSilentDriver = testing::AddGlobalTestEnvironment(new SilentDriver);

bool soon(const std::function<bool()>& holds) {
  const Clock::time_point limit = Clock::now() + std::chrono::seconds(20);
  while (!holds()) {
    if (Clock::now() > limit) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

TEST(Player, WithoutADeviceSaysSoOnceAndGoesOnSilently) {
  SoundPlayer player({.device = "no such device"});
  ASSERT_TRUE(soon([&] { return player.status().state == SoundState::silent; }));
  EXPECT_NE(player.status().text.find("no such device"), std::string::npos);
  const std::optional<std::string> news = player.news();
  ASSERT_TRUE(news);
  EXPECT_NE(news->find("without sound"), std::string::npos);
  const SoundCue cue{SoundKind::snip, SoundPosition(0, 0, -0.1), 1};
  player.update({}, std::span(&cue, 1));
  ASSERT_TRUE(soon([&] { return player.status().left_out == 1; }));
  EXPECT_FALSE(player.news()) << "only once";
  player.retry();
  EXPECT_TRUE(soon([&] { return player.news().has_value(); })) << "what came of trying again";
  EXPECT_EQ(player.status().state, SoundState::silent);
}

TEST(Player, PlaysAndItsToneStopsWhenUpdatesStayAway) {
  SoundPlayer player;
  ASSERT_TRUE(soon([&] { return player.status().state == SoundState::playing; })) << player.status().text;
  EXPECT_FALSE(player.news()) << "nothing to tell when all is well";
  SoundScene scene;
  scene.room = false;
  scene.cautery = CauteryMode::cut;
  const SoundCue cue{SoundKind::attention, SoundPosition(0, 0, -0.1), 1};
  player.update(scene, std::span(&cue, 1));
  EXPECT_TRUE(soon([&] { return player.status().played == 1 && player.status().voices == 2; }));
  EXPECT_TRUE(soon([&] { return player.status().voices == 1; })) << "only the room's hum stays";
}

TEST(Player, DoesNotHoldUpItsCaller) {
  SoundPlayer player;
  SoundScene scene;
  scene.heart_rate = 100;
  const std::vector<SoundCue> cues(90, SoundCue{SoundKind::ratchet, SoundPosition(0.02, 0, -0.1), 1});
  std::vector<double> times;
  for (int i = 0; i < 600; ++i) {  // from its first moment, while sounds are made and the device opens
    const Clock::time_point begin = Clock::now();
    player.update(scene, cues);
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::sort(times.begin(), times.end());
  EXPECT_LT(times[times.size() * 98 / 100], 1.0) << "ms";
  EXPECT_TRUE(soon([&] {
    const SoundStatus status = player.status();
    return status.played + status.left_out == 600 * cues.size();
  }));
  EXPECT_LE(player.status().voices, kVoices);
}

TEST(Player, StopsAtAnyMoment) {
  for (int i = 0; i < 3; ++i) {
    SoundPlayer player;
    player.update({});
    std::this_thread::sleep_for(std::chrono::milliseconds(60 * i));
  }
}

}  // namespace
}  // namespace calot
