#include "calot/device/devices.h"

#include <SDL.h>

#include <charconv>
#include <cmath>

#include "calot/base/error.h"
#include "calot/sim/haptic_mock.h"

namespace calot {
namespace {

/// A mock that moves its fingers too.
class CirclingMock final : public HapticDevice {
 public:
  CirclingMock(const Pose& rest, double radius, double period)
      : period_(period), mock_([rest, radius, period](double time) {
          const double angle = 2 * M_PI * time / period;
          return Pose{rest.rotation, rest.position + rest.rotation * Vec3(radius * (std::cos(angle) - 1),
                                                                          radius * std::sin(angle), 0)};
        }) {}
  [[nodiscard]] DeviceLimits limits() const override { return mock_.limits(); }
  DeviceState read() noexcept override {
    constexpr double open = 0.6, firm = 3;  // rad, N
    const bool closed = std::fmod(mock_.time(), period_) > period_ / 2;
    mock_.set_fingers(closed ? 0 : open, closed ? firm : 0, false, false);
    return mock_.read();
  }
  void write(const Vec3& force, const Vec3& torque) noexcept override { mock_.write(force, torque); }

 private:
  double period_;
  MockHapticDevice mock_;
};

void read_address(DeviceChoice& choice, std::string_view text, const std::string& whole) {
  const auto colon = text.find(':');
  choice.address = text.substr(0, colon);
  if (choice.address.empty())
    throw InputError("device", "\"" + whole + "\" has no address", "write e.g. network:127.0.0.1");
  if (colon == std::string_view::npos) return;
  const std::string_view port = text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), choice.port);
  if (error != std::errc() || end != port.data() + port.size())
    throw InputError("device", "\"" + whole + "\" has no port", "write e.g. network:127.0.0.1:18944");
}

}  // namespace

DeviceChoice read_device_choice(const std::string& text) {
  DeviceChoice choice;
  constexpr std::string_view network = "network";
  if (text == "mouse") return choice;
  if (text == "gamepad") {
    choice.kind = DeviceKind::gamepad;
  } else if (text == "mock") {
    choice.kind = DeviceKind::mock;
  } else if (text == network || text.starts_with("network:")) {
    choice.kind = DeviceKind::network;
    if (text != network) read_address(choice, std::string_view(text).substr(network.size() + 1), text);
  } else {
    throw InputError("device", "there is no device \"" + text.substr(0, 60) + "\"",
                     "give mouse, gamepad, network, network:ADDRESS[:PORT] or mock");
  }
  return choice;
}

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> list = {{"mouse", "mouse and keyboard, without force", true}};
  SDL_SetMainReady();
  if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) == 0) {
    SDL_GameControllerUpdate();
    for (int k = 0; k < SDL_NumJoysticks(); ++k) {
      if (SDL_IsGameController(k) == SDL_FALSE) continue;
      const char* name = SDL_GameControllerNameForIndex(k);
      list.push_back({"gamepad", std::string(name == nullptr ? "gamepad" : name) + ", without force", true});
    }
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }
  if (list.size() == 1) list.push_back({"gamepad", "one or two gamepads, without force; none is plugged in", false});
  list.push_back({"network", "manipulators that speak OpenIGTLink, with force; listens at 127.0.0.1:18944", true});
  list.push_back({"mock", "a simulated hand that goes round a circle, with force", true});
  return list;
}

std::unique_ptr<HapticDevice> make_mock_device(const Pose& rest, double radius, double period) {
  if (!(period > 0) || !std::isfinite(radius)) throw InputError("mock", "the circle makes no sense", "give m and s");
  return std::make_unique<CirclingMock>(rest, radius, period);
}

}  // namespace calot
