// The thread around the tick, the hand-over, and the statistics of its periods.
#include "calot/sim/haptic_loop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "calot/sim/haptic_mock.h"
#include "tests/sim/haptic_walls.h"

namespace calot::test {
namespace {

TEST(TripleBuffer, GivesTheNewestOnceAndKeepsIt) {
  TripleBuffer<int> buffer;
  EXPECT_FALSE(buffer.fetch());
  EXPECT_EQ(buffer.reading(), 0);
  for (int i = 1; i <= 3; ++i) {
    buffer.writing() = i;
    buffer.publish();
  }
  EXPECT_TRUE(buffer.fetch());
  EXPECT_EQ(buffer.reading(), 3);
  EXPECT_FALSE(buffer.fetch());
  EXPECT_EQ(buffer.reading(), 3);
}

// Values of two halves: a torn one would show; and they never go back.
TEST(TripleBuffer, IsNeverTornNorGoesBackBetweenThreads) {
  struct Pair {
    std::uint64_t a = 0, padding[30] = {}, b = 0;
  };
  TripleBuffer<Pair> buffer;
  constexpr std::uint64_t count = 300000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= count; ++i) {
      buffer.writing().a = i;
      buffer.writing().b = i;
      buffer.publish();
    }
  });
  std::uint64_t last = 0, wrong = 0;
  while (last < count) {
    if (!buffer.fetch()) continue;
    wrong += buffer.reading().a != buffer.reading().b || buffer.reading().a <= last ? 1 : 0;
    last = buffer.reading().a;
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
}

TEST(Periods, QuantilesByRank) {
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const Distribution d = distribution_of(values);
  EXPECT_EQ(d.p50, 100);
  EXPECT_EQ(d.p99, 198);
  EXPECT_EQ(d.max, 200);
  EXPECT_EQ(distribution_of({}).max, 0);
  EXPECT_EQ(distribution_of({7}).p99, 7);
}

TEST(Periods, CountTheLastOnes) {
  PeriodRing ring(1.0);
  EXPECT_EQ(ring.statistics().counted, 0u);
  for (int i = 0; i < 50; ++i) ring.add(100, 100);  // pushed out later
  for (std::size_t i = 0; i < PeriodRing::size; ++i) ring.add(i % 2 == 0 ? 0.75 : 1.5, 0.25);
  const PeriodStatistics s = ring.statistics();
  EXPECT_EQ(s.ticks, PeriodRing::size + 50);
  EXPECT_EQ(s.counted, PeriodRing::size);
  EXPECT_EQ(s.period.p50, 0.75);
  EXPECT_EQ(s.period.max, 1.5);
  EXPECT_EQ(s.jitter.p50, 0.25);
  EXPECT_EQ(s.jitter.p99, 0.5);
  EXPECT_EQ(s.work.max, 0.25);
}

// A second of the real thing. How evenly it runs depends on the machine and is no matter of this test.
TEST(HapticLoop, RunsTouchesAndStops) {
  using Clock = std::chrono::steady_clock;
  MockHapticDevice device([](double) { return at(0, 0, -0.004); });
  std::uint64_t ticks = 0;
  double force = 0;
  {
    HapticLoop loop(device);
    const auto end = Clock::now() + std::chrono::seconds(1);
    std::uint64_t step = 0, last_tick = 0;
    while (Clock::now() < end) {
      loop.next_set() = wall_set(at(0, 0, 0), 1000, 0.2);
      loop.next_set().step = ++step;
      loop.publish_set();
      std::this_thread::sleep_for(std::chrono::milliseconds(16));
      const HapticOutput& out = loop.latest();
      EXPECT_GE(out.tick, last_tick);
      EXPECT_LE(out.step, step);
      last_tick = out.tick;
      force = out.force.z();
    }
    ticks = loop.periods().ticks;
    EXPECT_EQ(loop.latest().status, HapticStatus::working);
    EXPECT_GT(loop.latest().step, 5u);
    EXPECT_LE(ticks + loop.missed(), 5000u);
    RecordProperty("realtime", loop.is_realtime() ? "yes" : "no");
    RecordProperty("jitter_p99_us", std::to_string(1e6 * loop.periods().jitter.p99));
  }
  EXPECT_GT(ticks, 100u);
  EXPECT_NEAR(force, 0.004 / (1 / 1000.0 + 1 / 1000.0 + 1 / 300.0), 0.05);
  EXPECT_EQ(device.force(), Vec3(Vec3::Zero()));
}

TEST(HapticLoop, ManyStartsAndStops) {
  MockHapticDevice device([](double) { return at(0, 0, 0); });
  for (int i = 0; i < 50; ++i) {
    HapticLoop loop(device);
    (void)loop.latest();
  }
}

}  // namespace
}  // namespace calot::test
