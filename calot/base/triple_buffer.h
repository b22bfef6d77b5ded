// Hand-over of the newest value from one thread to another, without locks and without waiting.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

namespace calot {

/// Three slots: one the writer fills, one the reader reads, one between them. Each side swaps its own with the one
/// between; a value that the reader didn't fetch is overwritten by the next. One writing and one reading thread. Slots
/// are reused, so that values with memory of their own needn't allocate again.
template <class T>
class TripleBuffer {
 public:
  /// The writer's slot; holds some earlier value.
  T& writing() { return slots_[writing_]; }
  void publish() {
    writing_ = between_.exchange(static_cast<std::uint8_t>(writing_ | fresh), std::memory_order_acq_rel) & index;
  }

  /// Fetches the newest value. @return false where there is none newer than the one in `reading`
  bool fetch() {
    if ((between_.load(std::memory_order_relaxed) & fresh) == 0) return false;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & index;
    return true;
  }
  /// What was fetched last; a default value before.
  const T& reading() const { return slots_[reading_]; }

 private:
  static constexpr std::uint8_t fresh = 4, index = 3;
  std::array<T, 3> slots_{};
  std::atomic<std::uint8_t> between_ = 1;
  std::uint8_t writing_ = 0;  // the writer's alone
  std::uint8_t reading_ = 2;  // the reader's alone
};

}  // namespace calot
