#include "calot/base/parallel.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

// TBB isn't instrumented, nor is this file (see CMakeLists.txt): the thread sanitizer is told what loops order.
#ifdef CALOT_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#define CALOT_COMES_BEFORE(place) __tsan_release(place)
#define CALOT_COMES_AFTER(place) __tsan_acquire(place)
#else
#define CALOT_COMES_BEFORE(place) static_cast<void>(place)
#define CALOT_COMES_AFTER(place) static_cast<void>(place)
#endif

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

tbb::task_arena& current_arena() {
  const std::lock_guard lock(arena_mutex);
  if (!arena) arena = std::make_unique<tbb::task_arena>(default_threads());
  return *arena;
}

}  // namespace

namespace {

// How willingly a thread gives way; per thread on Linux.
constexpr int background_niceness = 15;

// A few threads that share out one loop at a time.
class Crew {
 public:
  explicit Crew(int helpers) {
    for (int k = 0; k < helpers; ++k) threads_.emplace_back([this] { help(); });
  }
  ~Crew() {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  void run(std::size_t count, const std::function<void(std::size_t)>& body) {
    if (running_) {  // a loop inside a loop of the same thread
      for (std::size_t i = 0; i < count; ++i) body(i);
      return;
    }
    running_ = true;
    {
      const std::lock_guard lock(mutex_);
      body_ = &body;
      count_ = count;
      next_ = 0;
      failure_ = nullptr;
      ++round_;
    }
    wake_.notify_all();
    work(body, count);
    std::unique_lock lock(mutex_);
    body_ = nullptr;  // Who has not begun by now stays out.
    done_.wait(lock, [this] { return working_ == 0; });
    running_ = false;
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void work(const std::function<void(std::size_t)>& body, std::size_t count) {
    try {
      for (std::size_t i = next_++; i < count; i = next_++) body(i);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      next_ = count;
    }
  }
  void help() {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), background_niceness);
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return closing_ || (round_ != seen && body_ != nullptr); });
      if (closing_) return;
      seen = round_;
      const auto* body = body_;
      const std::size_t count = count_;
      ++working_;
      lock.unlock();
      work(*body, count);
      lock.lock();
      if (--working_ == 0) done_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::vector<std::thread> threads_;
  const std::function<void(std::size_t)>* body_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_{0};
  std::uint64_t round_ = 0;
  int working_ = 0;
  bool closing_ = false;
  bool running_ = false;  // used by the owner only
  std::exception_ptr failure_;
};

thread_local std::unique_ptr<Crew> background_crew;
std::atomic<int> threads_in_background{0};

void in_turn(std::size_t count, const std::function<void(std::size_t)>& body) {
  for (std::size_t i = 0; i < count; ++i) body(i);
}

}  // namespace

void set_thread_count(int count) {
  const std::lock_guard lock(arena_mutex);
  const int threads = std::max(1, count);
  limit.reset();
  limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                static_cast<std::size_t>(threads));
  arena = std::make_unique<tbb::task_arena>(threads);
}

int thread_count() {
  return current_arena().max_concurrency();
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 0) return;
  if (count == 1) return body(0);
  if (background_crew) return background_crew->run(count, body);
  if (const int background = threads_in_background; background > 0 && thread_count() - background < 2)
    return in_turn(count, body);
  char begin = 0, end = 0;
  CALOT_COMES_BEFORE(&begin);
  current_arena().execute([&] {
    tbb::parallel_for(
        std::size_t{0}, count,
        [&](std::size_t i) {
          CALOT_COMES_AFTER(&begin);
          body(i);
          CALOT_COMES_BEFORE(&end);
        },
        tbb::simple_partitioner{});
  });
  CALOT_COMES_AFTER(&end);
}

void parallel_blocks(std::size_t count, std::size_t block,
                     const std::function<void(std::size_t, std::size_t, std::size_t)>& body) {
  const std::size_t blocks = (count + block - 1) / block;
  parallel_for(blocks, [&](std::size_t b) { body(b * block, std::min(count, (b + 1) * block), b); });
}

BackgroundLane::BackgroundLane(int threads)
    : niceness_before_(getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()))),
      threads_(threads > 0 ? threads : thread_count()) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), background_niceness);
  background_crew = std::make_unique<Crew>(threads_ - 1);
  threads_in_background += threads_;
}

BackgroundLane::~BackgroundLane() {
  threads_in_background -= threads_;
  background_crew.reset();
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness_before_);
}

}  // namespace calot
