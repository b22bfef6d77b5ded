#include "calot/image/voxel_numbers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "calot/base/error.h"

namespace calot {
namespace {

static_assert(std::endian::native == std::endian::little);

[[noreturn]] void too_short(const std::string& where) {
  throw InputError(where, "is truncated: it holds fewer voxels than its header says", "copy or export the file again");
}

template <class T>
void convert(std::span<const char> raw, const StoredNumbers& stored, std::vector<double>& values) {
  const auto convert_all = [&](const auto& number_at) {
    for (std::size_t v = 0; v < values.size(); ++v)
      values[v] = stored.slope * static_cast<double>(number_at(raw.data() + v * sizeof(T))) + stored.intercept;
  };
  if (!stored.swapped)
    return convert_all([](const char* at) {
      T number;
      std::memcpy(&number, at, sizeof(T));
      return number;
    });
  convert_all([](const char* at) {
    std::array<char, sizeof(T)> bytes{};
    std::reverse_copy(at, at + sizeof(T), bytes.begin());
    return std::bit_cast<T>(bytes);
  });
}

void convert_any(std::span<const char> raw, const StoredNumbers& stored, std::vector<double>& values) {
  switch (stored.type) {
    case ScalarType::int8:
      return convert<std::int8_t>(raw, stored, values);
    case ScalarType::uint8:
      return convert<std::uint8_t>(raw, stored, values);
    case ScalarType::int16:
      return convert<std::int16_t>(raw, stored, values);
    case ScalarType::uint16:
      return convert<std::uint16_t>(raw, stored, values);
    case ScalarType::int32:
      return convert<std::int32_t>(raw, stored, values);
    case ScalarType::uint32:
      return convert<std::uint32_t>(raw, stored, values);
    case ScalarType::int64:
      return convert<std::int64_t>(raw, stored, values);
    case ScalarType::uint64:
      return convert<std::uint64_t>(raw, stored, values);
    case ScalarType::float32:
      return convert<float>(raw, stored, values);
    case ScalarType::float64:
      return convert<double>(raw, stored, values);
  }
}

template <class T, class Convert>
std::vector<T> read_all(NumberReader& numbers, Progress& progress, const Convert& converted) {
  std::vector<T> all;
  all.reserve(numbers.count());
  for (auto block = numbers.next(); !block.empty(); block = numbers.next()) {
    const std::size_t first = all.size();
    all.resize(first + block.size());
    for (std::size_t v = 0; v < block.size(); ++v) all[first + v] = converted(block[v], first + v);
    progress.at(static_cast<double>(numbers.done()) / static_cast<double>(numbers.count()));
  }
  return all;
}

}  // namespace

std::size_t bytes_of(ScalarType type) {
  constexpr std::array<std::size_t, 10> bytes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return bytes[static_cast<std::size_t>(type)];
}

NumberReader::NumberReader(ByteSource& source, const StoredNumbers& stored, std::size_t count)
    : source_(source), stored_(stored), count_(count) {
  if (!source.could_hold(count * bytes_of(stored.type))) too_short(source.name());
  values_.reserve(block);
}

std::span<const double> NumberReader::next() {
  values_.resize(std::min(block, count_ - done_));
  if (values_.empty()) return {};
  raw_.resize(values_.size() * bytes_of(stored_.type));
  if (source_.read(raw_.data(), raw_.size()) < raw_.size()) too_short(source_.name());
  convert_any(raw_, stored_, values_);
  done_ += values_.size();
  if (done_ == count_ && !source_.ends_well()) too_short(source_.name());
  return values_;
}

Label label_of(double value, std::size_t voxel, const std::string& where) {
  if (!(value >= 0 && value <= 65535) || value != std::floor(value))
    throw InputError(
        where, "voxel " + std::to_string(voxel) + " has the value " + std::to_string(value) + ", which is no label",
        "give a segmentation: whole numbers from 0 to 65535");
  return static_cast<Label>(value);
}

std::vector<Label> read_labels(NumberReader& numbers, Progress& progress) {
  return read_all<Label>(numbers, progress,
                         [&](double value, std::size_t voxel) { return label_of(value, voxel, numbers.name()); });
}

std::vector<std::int16_t> read_hounsfield(NumberReader& numbers, Progress& progress) {
  return read_all<std::int16_t>(numbers, progress, [&](double value, std::size_t voxel) {
    if (!std::isfinite(value))
      throw InputError(numbers.name(), "voxel " + std::to_string(voxel) + " has the value " + std::to_string(value),
                       "export the CT again, as Hounsfield units");
    return whole_hounsfield(value);
  });
}

}  // namespace calot
