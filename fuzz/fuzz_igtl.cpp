// OpenIGTLink from anybody: the first byte says how the rest is read. Even: a stream in pieces of that size. Odd: the
// content of one message of a type and version, whose header is right, so that more than the checksum is tried.
#include <igtl_util.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "calot/device/igtl_message.h"

namespace {

void need(bool holds) {
  if (!holds) __builtin_trap();
}

void look_at(const calot::IgtlMessage& message) {
  need(message.type.size() <= 12 && message.device.size() <= 20 &&
       message.content.size() <= calot::IgtlReader::largest_body);
  if (const auto pose = calot::igtl_pose(message))
    need(pose->position.allFinite() && pose->position.cwiseAbs().maxCoeff() <= 10 &&
         std::abs(pose->rotation.norm() - 1) < 1e-9);
  if (const auto fingers = calot::igtl_fingers(message))
    need(fingers->opening >= 0 && fingers->opening <= 4 && fingers->grip >= 0 && fingers->grip <= 1000);
}

void read_all(const std::vector<std::uint8_t>& bytes, std::size_t piece) {
  calot::IgtlReader reader;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = std::min(piece, bytes.size() - at);
    const std::size_t taken = reader.take({bytes.data() + at, size});
    need(taken <= size);
    if (const auto message = reader.message()) look_at(*message);
    if (taken == 0) {
      need(reader.fault() != calot::IgtlFault::none);
      return;
    }
    at += taken;
  }
}

void append(std::vector<std::uint8_t>& bytes, std::uint64_t number) {
  for (int shift = 56; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
}

std::vector<std::uint8_t> with_header(std::uint8_t mode, std::vector<std::uint8_t> body) {
  constexpr std::string_view types[] = {"TRANSFORM", "POSITION", "SENSOR", "STATUS"};
  const std::string_view type = types[mode >> 1 & 3];
  std::vector<std::uint8_t> bytes = {0, static_cast<std::uint8_t>(1 + (mode >> 3 & 1))};
  bytes.insert(bytes.end(), type.begin(), type.end());
  bytes.resize(14);
  bytes.push_back('L');
  bytes.resize(42);
  append(bytes, body.size());
  append(bytes, crc64(body.data(), body.size(), crc64(nullptr, 0, 0)));
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> rest(data + 1, data + size);
  if (data[0] % 2 == 0)
    read_all(rest, 1 + data[0]);
  else
    read_all(with_header(data[0], std::move(rest)), 4096);
  return 0;
}
