#include "calot/device/devices.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/files.h"

namespace calot::test {
namespace {

TEST(Devices, ChoicesAreRead) {
  EXPECT_EQ(read_device_choice("mouse").kind, DeviceKind::mouse);
  EXPECT_EQ(read_device_choice("gamepad").kind, DeviceKind::gamepad);
  EXPECT_EQ(read_device_choice("mock").kind, DeviceKind::mock);
  EXPECT_EQ(read_device_choice("network").address, "127.0.0.1");
  EXPECT_EQ(read_device_choice("network").port, 18944);
  const DeviceChoice far = read_device_choice("network:10.0.0.7:2000");
  EXPECT_EQ(far.address, "10.0.0.7");
  EXPECT_EQ(far.port, 2000);
  EXPECT_EQ(message_of([] { (void)read_device_choice("mice"); }),
            "device: there is no device \"mice\"; give mouse, gamepad, network, network:ADDRESS[:PORT] or mock");
  for (const char* bad : {"network:", "network:1.2.3.4:", "network:1.2.3.4:99999", "network:1.2.3.4:8x", ""})
    EXPECT_NE(message_of([&] { (void)read_device_choice(bad); }), "") << bad;
}

TEST(Devices, AreListedAndCanBeChosen) {
  const std::vector<DeviceInfo> list = list_devices();
  ASSERT_GE(list.size(), 4u);
  for (const DeviceInfo& info : list) EXPECT_NO_THROW((void)read_device_choice(info.choice)) << info.choice;
  for (const char* choice : {"mouse", "gamepad", "network", "mock"})
    EXPECT_TRUE(std::any_of(list.begin(), list.end(), [&](const auto& info) { return info.choice == choice; }))
        << choice;
  EXPECT_TRUE(list[0].present);
}

TEST(Devices, TheMockCirclesClosesAndYields) {
  const auto mock = make_mock_device(Pose{}, 0.01, 1.0);
  double widest = 0;
  bool closed = false, opened = false;
  for (int k = 0; k < 2000; ++k) {
    const DeviceState state = mock->read();
    widest = std::max(widest, state.handle.position.norm());
    closed = closed || (k > 1000 && state.opening == 0 && state.grip > 0);
    opened = opened || state.opening > 0;
    mock->write({0, 0, 3}, Vec3::Zero());
  }
  EXPECT_GT(widest, 0.015);
  EXPECT_LT(widest, 0.05);
  EXPECT_TRUE(closed && opened);
  EXPECT_GT(mock->read().handle.position.z(), 0.005);  // 3 N on 300 N/m
}

}  // namespace
}  // namespace calot::test
