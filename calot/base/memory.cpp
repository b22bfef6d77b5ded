#include "calot/base/memory.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "calot/base/error.h"

namespace calot {
namespace {

constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

// The value in bytes of a line "Name:   123 kB", or `fallback`.
std::uint64_t kilobytes_in(const char* file, const std::string& name, std::uint64_t fallback) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(name + ":", 0) == 0) return std::strtoull(line.c_str() + name.size() + 1, nullptr, 10) * 1024;
  return fallback;
}

std::uint64_t number_in(const char* file, std::uint64_t fallback) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  return in >> value ? value : fallback;
}

// What recycled buffers gave back.
class Pool {
 public:
  static constexpr std::size_t granule = std::size_t{1} << 16, largest = std::size_t{1} << 25,
                               most = std::size_t{1} << 26;
  // The smallest that fits and isn't much too large; none: null.
  std::pair<void*, std::size_t> take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    auto best = free_.end();
    for (auto it = free_.begin(); it != free_.end(); ++it)
      if (it->second >= bytes && it->second <= 2 * bytes && (best == free_.end() || it->second < best->second))
        best = it;
    if (best == free_.end()) return {nullptr, 0};
    const auto found = *best;
    held_ -= found.second;
    free_.erase(best);
    return found;
  }
  bool keep(void* memory, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > largest || held_ + bytes > most) return false;
    free_.emplace_back(memory, bytes);
    held_ += bytes;
    return true;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<void*, std::size_t>> free_;
  std::size_t held_ = 0;
};

Pool& pool() {
  static Pool* const all = new Pool;  // outlives every buffer, those of other statics too
  return *all;
}

}  // namespace

std::uint64_t available_memory() {
  std::uint64_t bytes = kilobytes_in("/proc/meminfo", "MemAvailable", no_limit);
  const std::uint64_t group_limit = number_in("/sys/fs/cgroup/memory.max", no_limit);
  const std::uint64_t group_used = number_in("/sys/fs/cgroup/memory.current", 0);
  if (group_limit != no_limit) bytes = std::min(bytes, group_limit - std::min(group_limit, group_used));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    const std::uint64_t used = kilobytes_in("/proc/self/status", "VmSize", 0);
    bytes = std::min<std::uint64_t>(bytes, limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used));
  }
  return bytes;
}

std::uint64_t peak_memory() {
  return kilobytes_in("/proc/self/status", "VmHWM", 0);
}

std::string readable_bytes(std::uint64_t bytes) {
  const char* const units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1000 && unit < 5; ++unit) value /= 1000;
  char text[32];
  std::snprintf(text, sizeof text, value < 10 && unit > 0 ? "%.1f %s" : "%.0f %s", value, units[unit]);
  return text;
}

void require_memory(std::uint64_t bytes, const std::string& what) {
  const std::uint64_t there = available_memory();
  if (bytes > there)
    throw FailedError("memory",
                      what + " needs " + readable_bytes(bytes) + " and " + readable_bytes(there) + " are free",
                      "use a coarser mesh, or --backend sparse");
}

Buffer::Buffer(std::size_t count) : count_(count) {
  if (count == 0) return;
  mapped_ = count * sizeof(double);
  void* memory = mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    mapped_ = 0;
    throw FailedError("memory", "the system refused " + readable_bytes(count * sizeof(double)), "use a coarser mesh");
  }
  data_ = static_cast<double*>(memory);
}

Buffer Buffer::recycled(std::size_t count) {
  const std::size_t bytes = (count * sizeof(double) + Pool::granule - 1) / Pool::granule * Pool::granule;
  Buffer buffer;
  if (count == 0 || bytes > Pool::largest) {
    buffer = Buffer(count);
  } else if (const auto [memory, there] = pool().take(bytes); memory) {
    buffer.data_ = static_cast<double*>(memory);
    buffer.mapped_ = there;
  } else {
    buffer = Buffer(bytes / sizeof(double));
  }
  buffer.count_ = count;
  buffer.recycled_ = true;
  return buffer;
}

void Buffer::release() {
  if (data_ && !(recycled_ && pool().keep(data_, mapped_))) munmap(data_, mapped_);
  data_ = nullptr;
}

void Buffer::swap(Buffer& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(count_, other.count_);
  std::swap(mapped_, other.mapped_);
  std::swap(recycled_, other.recycled_);
}

}  // namespace calot
