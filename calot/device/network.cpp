#include "calot/device/network.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <set>
#include <thread>

#include "calot/base/error.h"
#include "calot/device/network_peers.h"

namespace calot {
namespace {

void need(bool holds, const std::string& what, const std::string& what_to_do) {
  if (!holds) throw InputError("network", what, what_to_do);
}

bool is_device_name(const std::string& name) {
  const auto printable = [](char c) { return c >= 0x20 && c < 0x7f; };
  return !name.empty() && name.size() <= 19 && std::all_of(name.begin(), name.end(), printable);
}

in_addr address_of(const std::string& text) {
  in_addr address{};
  const bool is_one = inet_pton(AF_INET, text == "localhost" ? "127.0.0.1" : text.c_str(), &address) == 1;
  std::string quoted(1, '"');
  quoted += text.substr(0, 60);
  need(is_one, quoted + "\" is no IPv4 address", "give e.g. 127.0.0.1");
  return address;
}

NetworkOptions checked(const NetworkOptions& o) {
  (void)address_of(o.address);
  need(!o.hands.empty() && o.hands.size() <= 8, "has no hands, or too many", "give 1 to 8 names");
  for (const std::string& name : o.hands)
    need(is_device_name(name), "a hand's name can't be sent", "give 1 to 19 printable letters");
  need(is_device_name(o.organ), "the organ's name can't be sent", "give 1 to 19 printable letters");
  need(std::set<std::string>(o.hands.begin(), o.hands.end()).size() == o.hands.size(), "two hands have the same name",
       "give each its own");
  need(o.organ_rate >= 0.1 && o.organ_rate <= 60, "the rate of surfaces is out of range", "give 0.1 to 60 a second");
  need(o.force_rate >= 1 && o.force_rate <= 2000, "the rate of forces is out of range", "give 1 to 2000 a second");
  need(o.silence > 0 && std::isfinite(o.silence), "the silence is out of range", "give seconds");
  need(o.limits.max_force >= 0 && o.limits.max_torque >= 0 && o.limits.max_stiffness > 0,
       "what the manipulators bear makes no sense", "give a force, a torque and a stiffness");
  return o;
}

int listen_at(const NetworkOptions& options) {
  const std::string where = options.address + ":" + std::to_string(options.port);
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) throw FailedError(where, std::string("no socket: ") + std::strerror(errno));
  const int on = 1;
  (void)setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  address.sin_addr = address_of(options.address);
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(socket, 8) != 0) {
    const std::string why = std::strerror(errno);
    close(socket);
    throw FailedError(where, "can't be listened at: " + why, "end what listens there, or choose another port");
  }
  return socket;
}

std::uint16_t port_of(int listener) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  (void)getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

}  // namespace

struct NetworkDevices::Inside {
  explicit Inside(const NetworkOptions& options, int listener)
      : port(port_of(listener)),
        loopback(ntohl(address_of(options.address).s_addr) >> 24 == 127),
        keeper(options, listener) {
    const std::string where = options.address + ":" + std::to_string(port);
    keeper.status.add("OpenIGTLink at " + where +
                      (loopback ? ", for this machine only" : ", for everybody who can reach this machine"));
    thread = std::thread([this] { run(); });
  }
  ~Inside() {
    stop = true;
    thread.join();
  }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

  void run() {
    try {
      while (!stop) keeper.turn();
      keeper.close_all("left, as Calot ends");
    } catch (const std::exception& wrong) {
      keeper.close_all(std::string("left, as the network can't go on: ") + wrong.what());
    }
  }

  std::uint16_t port;
  bool loopback;
  detail::PeerKeeper keeper;
  std::atomic<bool> stop = false;
  std::thread thread;  // last: it uses all of the above
};

NetworkDevices::NetworkDevices(const NetworkOptions& options) {
  const NetworkOptions sound = checked(options);
  inside_ = std::make_unique<Inside>(sound, listen_at(sound));
}

NetworkDevices::~NetworkDevices() = default;

HapticDevice& NetworkDevices::device(int hand) {
  need(hand >= 0 && hand < static_cast<int>(inside_->keeper.hands.size()), "there is no hand " + std::to_string(hand),
       "");
  return *inside_->keeper.hands[static_cast<std::size_t>(hand)];
}

HandControls NetworkDevices::controls(int hand) const {
  const detail::NetworkHand& state = *inside_->keeper.hands.at(static_cast<std::size_t>(hand));
  return {state.clutch, state.ratchet};
}

OrganSurface& NetworkDevices::next_surface() {
  return inside_->keeper.surfaces.writing();
}

void NetworkDevices::publish_surface() {
  inside_->keeper.surfaces.publish();
}

std::uint16_t NetworkDevices::port() const {
  return inside_->port;
}

bool NetworkDevices::is_loopback() const {
  return inside_->loopback;
}

std::vector<std::string> NetworkDevices::take_status() {
  return inside_->keeper.status.take();
}

}  // namespace calot
