// Large memory: how much there is, and buffers that come in huge pages.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace calot {

/// Bytes this process may still take: the machine's available memory, the control group's and the address-space limit.
std::uint64_t available_memory();
/// Peak bytes this process has held so far.
std::uint64_t peak_memory();
/// "409 MB", in powers of ten.
std::string readable_bytes(std::uint64_t bytes);
/// Throws FailedError naming `what`, the bytes needed and the bytes there are, if they are too few.
void require_memory(std::uint64_t bytes, const std::string& what);

/// An array of doubles straight from the system: not touched, hence not paid for, until it is written.
/// (Huge pages were measured and left out: on virtual machines their first touch was three times slower.)
class Buffer {
 public:
  Buffer() = default;
  explicit Buffer(std::size_t count);
  /// One that may have been used before and hold anything. Memory of moderate size that such buffers give back is kept
  /// for the next ones: pages that come fresh from the system cost more than a small factor's arithmetic.
  static Buffer recycled(std::size_t count);
  ~Buffer() { release(); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(Buffer& other) noexcept;
  [[nodiscard]] double* data() { return data_; }
  [[nodiscard]] const double* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return count_; }

 private:
  void release();
  double* data_ = nullptr;
  std::size_t count_ = 0, mapped_ = 0;
  bool recycled_ = false;
};

}  // namespace calot
