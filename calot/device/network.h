// Manipulators on the network, and organs for others to see: a server for OpenIGTLink.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "calot/device/igtl_message.h"

namespace calot {

constexpr std::uint16_t igtl_port = 18944;  ///< what OpenIGTLink programs expect

struct NetworkOptions {
  std::string address = "127.0.0.1";  ///< IPv4; any other than this machine's own loopback only when asked for by name
  std::uint16_t port = igtl_port;     ///< 0: any that is free
  std::vector<std::string> hands = {"Left", "Right"};  ///< device names, 1 … 19 printable letters each, 1 … 8 of them
  std::string organ = "Tissue";                        ///< device name of the surface
  double organ_rate = 10;                              ///< surfaces a second at most, 0.1 … 60
  double force_rate = 1000;                            ///< forces a second at most, 1 … 2000
  double silence = 0.5;                                ///< a hand without a pose for so long is not connected, > 0 [s]
  DeviceLimits limits = {6.0, 0.2, 1000.0};            ///< of the manipulators
};

/// Listens from the beginning to the end of its life, in a thread of its own; the devices never wait for it. What peers
/// may send and do is bounded (docs/devices.md); whoever doesn't keep to it is left, with a status line.
class NetworkDevices {
 public:
  /// Throws InputError for options out of range, FailedError where the address can't be had.
  explicit NetworkDevices(const NetworkOptions& options = {});
  ~NetworkDevices();
  NetworkDevices(const NetworkDevices&) = delete;
  NetworkDevices& operator=(const NetworkDevices&) = delete;

  /// By its place in `hands`. Its handle is in world axes, as the peer sent it. Lives as long as this.
  [[nodiscard]] HapticDevice& device(int hand);
  /// Clutch and ratchet as the peer asks; from any thread.
  [[nodiscard]] HandControls controls(int hand) const;

  /// One thread's: the next surface to fill (it holds an earlier one) and hand over. Only the newest is sent.
  OrganSurface& next_surface();
  void publish_surface();

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] bool is_loopback() const;
  /// What has happened since the last call, a line each, the last 64 at most. From any thread, but not the devices'.
  std::vector<std::string> take_status();

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace calot
