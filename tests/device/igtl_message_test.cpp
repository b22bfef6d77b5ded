// Messages of the library's own packing are read; anything else is refused.
#include "calot/device/igtl_message.h"

#include <gtest/gtest.h>
#include <igtlPolyDataMessage.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/device/igtl_bytes.h"

namespace calot::test {
namespace {

/// The first message in bytes that come in pieces of a size.
std::optional<IgtlMessage> first_of(IgtlReader& reader, std::span<const std::uint8_t> bytes, std::size_t piece) {
  while (!bytes.empty()) {
    const std::size_t taken = reader.take(bytes.first(std::min(piece, bytes.size())));
    if (const auto message = reader.message()) return message;
    if (taken == 0) return {};
    bytes = bytes.subspan(taken);
  }
  return {};
}

std::optional<Pose> pose_of(const Bytes& bytes) {
  IgtlReader reader;
  const auto message = first_of(reader, bytes, bytes.size());
  return message ? igtl_pose(*message) : std::nullopt;
}

std::optional<IgtlFingers> fingers_of(const Bytes& bytes) {
  IgtlReader reader;
  const auto message = first_of(reader, bytes, bytes.size());
  return message ? igtl_fingers(*message) : std::nullopt;
}

IgtlFault fault_of(const Bytes& bytes) {
  IgtlReader reader;
  (void)first_of(reader, bytes, bytes.size());
  return reader.fault();
}

TEST(IgtlMessage, PosesInPiecesOfAnySize) {
  const Bytes bytes = transform_bytes("Left", 100);
  for (const std::size_t piece : {1u, 7u, 58u, 59u, 1000u}) {
    IgtlReader reader;
    const auto message = first_of(reader, bytes, piece);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->type, "TRANSFORM");
    EXPECT_EQ(message->device, "Left");
    const auto pose = igtl_pose(*message);
    ASSERT_TRUE(pose);
    EXPECT_NEAR((pose->position - Vec3(0.1, 0.02, 0.03)).norm(), 0, 1e-9);
    EXPECT_NEAR((pose->rotation * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-7);
    EXPECT_FALSE(reader.is_within());
  }
}

TEST(IgtlMessage, OneAfterTheOther) {
  Bytes bytes = status_bytes("x");
  const Bytes second = sensor_bytes("Left", {0.5, 2, 0, 1});
  bytes.insert(bytes.end(), second.begin(), second.end());
  IgtlReader reader;
  std::span<const std::uint8_t> rest(bytes);
  rest = rest.subspan(reader.take(rest));
  EXPECT_EQ(reader.message()->type, "STATUS");
  EXPECT_FALSE(reader.message());
  EXPECT_EQ(reader.take(rest), second.size());
  const auto fingers = igtl_fingers(*reader.message());
  ASSERT_TRUE(fingers);
  EXPECT_EQ(fingers->opening, 0.5);
  EXPECT_EQ(fingers->grip, 2);
  EXPECT_TRUE(!fingers->pedal && fingers->button && !fingers->controls.clutch && !fingers->controls.ratchet);
  EXPECT_TRUE(fingers_of(sensor_bytes("L", {0, 0, 1, 0, 0, 1}))->controls.ratchet);
}

TEST(IgtlMessage, SecondVersionWithExtendedHeader) {
  const Bytes plain = transform_bytes("Left", 100);
  Bytes bytes(plain.begin(), plain.begin() + 58);
  bytes[1] = 2;
  const Bytes extended = {0, 12, 0, 2, 0, 0, 0, 3, 0, 0, 0, 9};
  bytes.insert(bytes.end(), extended.begin(), extended.end());
  bytes.insert(bytes.end(), plain.begin() + 58, plain.end());
  bytes.insert(bytes.end(), {0, 0, 'm', 'e', 't'});
  set_body_size(bytes, bytes.size() - 58);
  set_checksum(bytes);
  ASSERT_TRUE(pose_of(bytes));
  EXPECT_NEAR(pose_of(bytes)->position.x(), 0.1, 1e-9);
  for (const auto& [at, value] :
       std::vector<std::pair<std::size_t, std::uint8_t>>{{58, 1}, {59, 11}, {62, 255}, {60, 9}}) {
    Bytes bad = bytes;
    bad[at] = value;
    set_checksum(bad);
    EXPECT_EQ(fault_of(bad), IgtlFault::not_igtl) << at;
  }
}

TEST(IgtlMessage, WhatIsNoMessageIsAFault) {
  const Bytes good = transform_bytes("Left", 100);
  Bytes bad = good;
  bad[1] = 3;
  EXPECT_EQ(fault_of(bad), IgtlFault::version);
  bad = good;
  bad[2] = 0x07;
  EXPECT_EQ(fault_of(bad), IgtlFault::not_igtl);
  bad = good;
  bad[2] = 0;
  EXPECT_EQ(fault_of(bad), IgtlFault::not_igtl);
  for (const std::uint64_t size : {std::uint64_t{4097}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    bad = good;
    set_body_size(bad, size);
    EXPECT_EQ(fault_of(bad), IgtlFault::too_large);
  }
  for (const std::size_t at : {55u, 58u, 105u}) {
    bad = good;
    bad[at] ^= 1;
    EXPECT_EQ(fault_of(bad), IgtlFault::checksum);
  }
  IgtlReader reader;
  (void)first_of(reader, bad, 1000);
  EXPECT_EQ(reader.take(good), 0u);  // nothing any more
}

TEST(IgtlMessage, NumbersThatMakeNoSenseAreNone) {
  EXPECT_FALSE(pose_of(transform_bytes("Left", NAN)));
  EXPECT_FALSE(pose_of(transform_bytes("Left", INFINITY)));
  EXPECT_FALSE(pose_of(transform_bytes("Left", 20000)));
  EXPECT_FALSE(pose_of(transform_bytes("Left", 0, 0, 0, 1.1F)));  // no rotation
  EXPECT_FALSE(pose_of(transform_bytes("Left", 0, 0, 0, -1)));    // a mirror
  EXPECT_FALSE(fingers_of(sensor_bytes("Left", {0, 0, 0})));      // too few
  EXPECT_FALSE(fingers_of(sensor_bytes("Left", {0, 0, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(fingers_of(sensor_bytes("Left", {NAN, 0, 0, 0})));
  EXPECT_FALSE(fingers_of(sensor_bytes("Left", {-0.1, 0, 0, 0})));
  EXPECT_FALSE(fingers_of(sensor_bytes("Left", {0, 1e6, 0, 0})));
  Bytes lying = sensor_bytes("Left", {0, 0, 0, 0});
  lying[58] = 6;  // more values than there are
  set_checksum(lying);
  EXPECT_FALSE(fingers_of(lying));
  Bytes short_one = transform_bytes("Left", 1);
  short_one.resize(short_one.size() - 4);
  set_body_size(short_one, short_one.size() - 58);
  set_checksum(short_one);
  EXPECT_EQ(fault_of(short_one), IgtlFault::none);
  EXPECT_FALSE(pose_of(short_one));
}

TEST(IgtlMessage, AnyDamageIsSurvived) {
  std::mt19937 random(3);
  Bytes good = transform_bytes("Left", 100);
  const Bytes more = sensor_bytes("Left", {0.5, 2, 0, 1});
  good.insert(good.end(), more.begin(), more.end());
  for (int round = 0; round < 20000; ++round) {
    Bytes bad = good;
    for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    IgtlReader reader;
    std::span<const std::uint8_t> rest(bad);
    while (!rest.empty()) {
      const std::size_t taken = reader.take(rest.first(std::min<std::size_t>(rest.size(), 1 + random() % 64)));
      if (const auto message = reader.message()) {
        const auto pose = igtl_pose(*message);
        const auto fingers = igtl_fingers(*message);
        ASSERT_TRUE(!pose || (pose->position.allFinite() && std::abs(pose->rotation.norm() - 1) < 1e-9));
        ASSERT_TRUE(!fingers || (fingers->opening >= 0 && std::isfinite(fingers->grip)));
      }
      if (taken == 0) break;
      rest = rest.subspan(taken);
    }
  }
}

TEST(IgtlMessage, ForcesAreReadByTheLibrary) {
  Bytes bytes;
  write_igtl_wrench(bytes, "Left", {{1, -2, 3.5}, {0.1, 0.2, -0.3}});
  igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
  header->InitPack();
  std::memcpy(header->GetPackPointer(), bytes.data(), 58);
  header->Unpack();
  EXPECT_STREQ(header->GetDeviceType(), "SENSOR");
  EXPECT_STREQ(header->GetDeviceName(), "Left");
  igtl::SensorMessage::Pointer message = igtl::SensorMessage::New();
  message->SetMessageHeader(header);
  message->AllocatePack();
  ASSERT_EQ(static_cast<std::size_t>(message->GetPackBodySize()), bytes.size() - 58);
  std::memcpy(message->GetPackBodyPointer(), bytes.data() + 58, bytes.size() - 58);
  ASSERT_TRUE(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY);
  const double wanted[] = {1, -2, 3.5, 0.1, 0.2, -0.3};
  for (unsigned k = 0; k < 6; ++k) EXPECT_EQ(message->GetValue(k), wanted[k]);
}

TEST(IgtlMessage, SurfacesThatCantBeSent) {
  IgtlSurfacePacker packer;
  Bytes out;
  EXPECT_FALSE(packer.pack(out, "Tissue", {}));
  OrganSurface surface{1, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}};
  EXPECT_FALSE(packer.pack(out, "Tissue", surface));
  EXPECT_TRUE(out.empty());
  surface.triangles[0][2] = 2;
  EXPECT_TRUE(packer.pack(out, "Tissue", surface));
  EXPECT_EQ(out.size(), 58u + 40 + 36 + 16);
}

}  // namespace
}  // namespace calot::test
