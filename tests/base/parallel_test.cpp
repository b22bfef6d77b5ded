#include "calot/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace calot {
namespace {

TEST(Parallel, BlocksCoverEverythingOnceAndAreFixed) {
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    std::vector<int> seen(1003, 0), block_of(1003, -1);
    parallel_blocks(1003, 64, [&](std::size_t begin, std::size_t end, std::size_t block) {
      for (std::size_t i = begin; i < end; ++i) {
        ++seen[i];
        block_of[i] = static_cast<int>(block);
      }
    });
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(seen[i], 1);
      EXPECT_EQ(block_of[i], static_cast<int>(i / 64));
    }
  }
  set_thread_count(static_cast<int>(std::thread::hardware_concurrency()));
}

TEST(Parallel, AnExceptionComesOut) {
  EXPECT_THROW(parallel_for(100,
                            [](std::size_t i) {
                              if (i == 57) throw std::runtime_error("57");
                            }),
               std::runtime_error);
}

TEST(Parallel, AnExceptionComesOutOfABackgroundLane) {
  std::thread background([&] {
    const BackgroundLane lane;
    for (int round = 0; round < 50; ++round) {
      std::atomic<int> done = 0;
      EXPECT_THROW(parallel_for(100,
                                [&](std::size_t i) {
                                  if (i == 57) throw std::runtime_error("57");
                                  ++done;
                                }),
                   std::runtime_error);
      EXPECT_LT(done, 100);
      parallel_for(100, [&](std::size_t) { ++done; });
      EXPECT_GE(done, 100);
    }
  });
  background.join();
}

TEST(Parallel, ABackgroundLaneWorksBesideTheOthers) {
  std::atomic<int> sum = 0;
  std::thread background([&] {
    const BackgroundLane lane;
    parallel_for(1000, [&](std::size_t) { ++sum; });
  });
  parallel_for(1000, [&](std::size_t) { ++sum; });
  background.join();
  EXPECT_EQ(sum, 2000);
}

}  // namespace
}  // namespace calot
