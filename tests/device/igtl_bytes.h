// Messages packed by OpenIGTLink's own library, as bytes that a test can spoil.
#pragma once
#include <igtlPositionMessage.h>
#include <igtlSensorMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_util.h>

#include <cstdint>
#include <string>
#include <vector>

namespace calot::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes packed(igtl::MessageBase* message) {
  message->Pack();
  const auto* begin = static_cast<const std::uint8_t*>(message->GetPackPointer());
  return {begin, begin + message->GetPackSize()};
}

/// At x, y, z [mm].
inline Bytes transform_bytes(const char* name, float x, float y = 20, float z = 30, float diagonal = 1) {
  igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
  igtl::Matrix4x4 matrix = {{0, -diagonal, 0, x}, {diagonal, 0, 0, y}, {0, 0, diagonal, z}, {0, 0, 0, 1}};
  message->SetDeviceName(name);
  message->SetMatrix(matrix);
  return packed(message);
}

inline Bytes sensor_bytes(const char* name, std::vector<double> values) {
  igtl::SensorMessage::Pointer message = igtl::SensorMessage::New();
  message->SetDeviceName(name);
  message->SetLength(static_cast<unsigned>(values.size()));
  message->SetValue(values.data());
  return packed(message);
}

inline Bytes status_bytes(const char* name) {
  igtl::StatusMessage::Pointer message = igtl::StatusMessage::New();
  message->SetDeviceName(name);
  message->SetStatusString("fine");
  return packed(message);
}

/// After a change to the body: its right checksum.
inline void set_checksum(Bytes& bytes) {
  const std::uint64_t sum = crc64(bytes.data() + 58, bytes.size() - 58, crc64(nullptr, 0, 0));
  for (int k = 0; k < 8; ++k) bytes[static_cast<std::size_t>(50 + k)] = static_cast<std::uint8_t>(sum >> (56 - 8 * k));
}

inline void set_body_size(Bytes& bytes, std::uint64_t size) {
  for (int k = 0; k < 8; ++k) bytes[static_cast<std::size_t>(42 + k)] = static_cast<std::uint8_t>(size >> (56 - 8 * k));
}

}  // namespace calot::test
