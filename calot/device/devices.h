// Which devices there are, and what was chosen of them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "calot/sim/haptic_device.h"

namespace calot {

enum class DeviceKind : std::uint8_t { mouse, gamepad, network, mock };

/// A choice as people write it: "mouse", "gamepad", "network", "network:192.168.0.7", "network:127.0.0.1:18950",
/// "mock".
struct DeviceChoice {
  DeviceKind kind = DeviceKind::mouse;
  std::string address = "127.0.0.1";  ///< network's
  std::uint16_t port = 18944;
};
/// Throws InputError.
DeviceChoice read_device_choice(const std::string& text);

struct DeviceInfo {
  std::string choice;    ///< what to write for it
  std::string words;     ///< what it is
  bool present = false;  ///< plugged in, or needs nothing
};
/// All kinds, and each gamepad that is plugged in. Looks at no network.
std::vector<DeviceInfo> list_devices();

/// The mock as a choice: a simulated hand around `rest` that goes round a circle, across z, once in `period` seconds
/// and closes its jaws for half of it. It bears forces as a real device does.
std::unique_ptr<HapticDevice> make_mock_device(const Pose& rest, double radius = 0.01, double period = 4.0);

}  // namespace calot
