// Inside this room only. Voxels as files store them, read block by block.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/byte_source.h"
#include "calot/image/label_map.h"

namespace calot {

enum class ScalarType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };
std::size_t bytes_of(ScalarType type);

/// How numbers are stored.
struct StoredNumbers {
  ScalarType type = ScalarType::uint8;
  bool swapped = false;             ///< the file has the other byte order
  double slope = 1, intercept = 0;  ///< value = slope · stored + intercept
};

/// Reads numbers in the file's order.
class NumberReader {
 public:
  static constexpr std::size_t block = std::size_t{1} << 16;
  /// @param count  numbers that the file's header promises; the source stands before the first
  /// Throws InputError at once where the file is too small to hold them.
  NumberReader(ByteSource& source, const StoredNumbers& stored, std::size_t count);
  /// The next `block` numbers or what is left of them; empty at the end. Throws InputError: truncated or damaged.
  std::span<const double> next();
  [[nodiscard]] std::size_t done() const { return done_; }  ///< numbers given so far
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const std::string& name() const { return source_.name(); }

 private:
  ByteSource& source_;
  StoredNumbers stored_;
  std::size_t count_, done_ = 0;
  std::vector<char> raw_;
  std::vector<double> values_;
};

/// The nearest whole HU (halves away from zero), clamped.
inline std::int16_t whole_hounsfield(double value) {
  const double clamped = std::clamp(value, -32768.0, 32767.0);
  return static_cast<std::int16_t>(static_cast<int>(clamped + std::copysign(0.5, clamped)));
}

/// A number as a label. Throws InputError naming file and voxel for anything but whole numbers in 0 … 65535.
Label label_of(double value, std::size_t voxel, const std::string& where);
/// All numbers as labels.
std::vector<Label> read_labels(NumberReader& numbers, Progress& progress);
/// All numbers as whole HU, clamped to −32768 … 32767. Throws InputError for values that aren't finite.
std::vector<std::int16_t> read_hounsfield(NumberReader& numbers, Progress& progress);

}  // namespace calot
