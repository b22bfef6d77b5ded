// Parallel loops whose result never depends on the number of threads: fixed blocks, reduced in fixed order.
#pragma once
#include <cstddef>
#include <functional>

namespace calot {

/// Threads used by every parallel loop of the process, at least 1. Default: the machine's cores, or CALOT_THREADS.
void set_thread_count(int count);
int thread_count();

/// Calls body(begin, end, block) for the fixed blocks [0, block), [block, 2·block) … of [0, count), on all threads, in
/// any order. Blocks must be independent. The first exception is rethrown here.
void parallel_blocks(std::size_t count, std::size_t block,
                     const std::function<void(std::size_t, std::size_t, std::size_t)>& body);

/// Runs body(0) … body(count − 1), which must be independent, on all threads.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

/// While one lives, the parallel loops of this thread run on threads of their own, and all of them give way to whoever
/// else wants a core, so that background work never holds up the loops of others. Those keep to the cores that are
/// left: to share a core with background work, and wait for what was begun there, costs more than it brings.
class BackgroundLane {
 public:
  /// @param threads  for the loops of this thread, itself counted; 0: `thread_count()`
  explicit BackgroundLane(int threads = 0);
  ~BackgroundLane();
  BackgroundLane(const BackgroundLane&) = delete;
  BackgroundLane& operator=(const BackgroundLane&) = delete;

 private:
  int niceness_before_, threads_;
};

}  // namespace calot
