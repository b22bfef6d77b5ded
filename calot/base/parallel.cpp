#include "calot/base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <thread>

namespace calot {
namespace {

int default_threads() {
  if (const char* text = std::getenv("CALOT_THREADS")) {
    const int n = std::atoi(text);
    if (n >= 1) return n;
  }
  return std::max(1u, std::thread::hardware_concurrency());
}

std::mutex arena_mutex;
std::unique_ptr<tbb::task_arena> arena;
std::unique_ptr<tbb::global_control> limit;  // lets more threads than cores run when asked for, as tests do

thread_local std::unique_ptr<tbb::task_arena> background_arena;

tbb::task_arena& current_arena() {
  if (background_arena) return *background_arena;
  const std::lock_guard lock(arena_mutex);
  if (!arena) arena = std::make_unique<tbb::task_arena>(default_threads());
  return *arena;
}

}  // namespace

void set_thread_count(int count) {
  const std::lock_guard lock(arena_mutex);
  const int threads = std::max(1, count);
  limit.reset();
  limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  arena = std::make_unique<tbb::task_arena>(threads);
}

int thread_count() { return current_arena().max_concurrency(); }

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 0) return;
  if (count == 1) return body(0);
  current_arena().execute([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { body(i); }, tbb::simple_partitioner{});
  });
}

void parallel_blocks(std::size_t count, std::size_t block,
                     const std::function<void(std::size_t, std::size_t, std::size_t)>& body) {
  const std::size_t blocks = (count + block - 1) / block;
  parallel_for(blocks, [&](std::size_t b) { body(b * block, std::min(count, (b + 1) * block), b); });
}

BackgroundLane::BackgroundLane() { background_arena = std::make_unique<tbb::task_arena>(thread_count()); }
BackgroundLane::~BackgroundLane() { background_arena.reset(); }

}  // namespace calot
