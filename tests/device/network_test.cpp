// The server against the library's own client in another process, and against peers that mean harm.
#include "calot/device/network.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <future>
#include <random>
#include <sstream>
#include <thread>

#include "tests/device/igtl_bytes.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

NetworkOptions any_port() {
  NetworkOptions options;
  options.port = 0;
  return options;
}

/// Waits until something is so, five seconds at most.
bool soon(const std::function<bool()>& is_so) {
  for (int k = 0; k < 2500; ++k) {
    if (is_so()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

/// A plain socket that sends what it likes.
class RawPeer {
 public:
  explicit RawPeer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~RawPeer() { close(socket_); }
  RawPeer(const RawPeer&) = delete;
  RawPeer& operator=(const RawPeer&) = delete;
  void send(const Bytes& bytes) const { (void)::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  /// The other side has hung up.
  [[nodiscard]] bool is_left() const {
    std::array<char, 4096> rest{};
    const ssize_t count = recv(socket_, rest.data(), rest.size(), MSG_DONTWAIT);
    return count == 0 || (count < 0 && errno == ECONNRESET);
  }
  /// Bytes that have come.
  [[nodiscard]] std::size_t drain() const {
    std::array<char, 65536> rest{};
    const ssize_t count = recv(socket_, rest.data(), rest.size(), MSG_DONTWAIT);
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

 private:
  int socket_;
};

struct Server {
  NetworkDevices devices{any_port()};
  std::string lines;
  DeviceState read(int hand) { return devices.device(hand).read(); }
  bool says(const std::string& words) {
    return soon([&] {
      for (const std::string& line : devices.take_status()) lines += line + "\n";
      return lines.find(words) != std::string::npos;
    });
  }
  std::future<CommandResult> client(const std::string& words) {
    const std::string command = std::string(CALOT_IGTL_CLIENT) + " " + std::to_string(devices.port()) + " " + words;
    return std::async(std::launch::async, [command] { return run_command(command); });
  }
};

TEST(Network, ListensAtLoopbackOnlyAndSaysSo) {
  Server server;
  EXPECT_TRUE(server.devices.is_loopback());
  EXPECT_TRUE(server.says("for this machine only"));
  EXPECT_EQ(NetworkOptions().address, "127.0.0.1");
  EXPECT_EQ(NetworkOptions().port, 18944);
  EXPECT_FALSE(server.read(0).connected);
  NetworkOptions same = any_port();
  same.port = server.devices.port();
  EXPECT_NE(message_of([&] { NetworkDevices second(same); }).find("can't be listened at"), std::string::npos);
  NetworkOptions bad = any_port();
  bad.address = "nowhere";
  EXPECT_EQ(message_of([&] { NetworkDevices second(bad); }),
            "network: \"nowhere\" is no IPv4 address; give e.g. 127.0.0.1");
  bad = any_port();
  bad.hands = {"Left", "Left"};
  EXPECT_NE(message_of([&] { NetworkDevices second(bad); }), "");
}

TEST(Network, TheLibrarysClientHoldsAndFeels) {
  int k = 0;
  for (const std::string kind : {"transform", "position", "quaternion3"}) {
    Server server;
    const int hand = k++ % 2;
    auto client = server.client("hand " + std::string(hand == 0 ? "Left" : "Right") + " 50 " + kind);
    ASSERT_TRUE(soon([&] { return server.read(hand).connected && server.read(hand).grip > 0; })) << kind;
    HapticDevice& device = server.devices.device(hand);
    double last = -1;
    bool grows = true;
    // As the haptic loop does, for longer than the client sends.
    for (int tick = 0; tick < 250; ++tick) {
      const DeviceState state = device.read();
      grows = grows && state.time >= last;
      last = state.time;
      device.write({1.5, -0.25, 100}, {0.1, 0, -0.05});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(grows);
    EXPECT_TRUE(soon([&] { return std::abs(device.read().handle.position.x() - 0.149) < 1e-6; })) << kind;
    const DeviceState state = device.read();
    EXPECT_NEAR((state.handle.rotation * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-6);
    EXPECT_EQ(state.opening, 0.25);
    EXPECT_EQ(state.grip, 3.5);
    EXPECT_TRUE(state.pedal && !state.button);
    EXPECT_TRUE(server.devices.controls(hand).clutch);
    const CommandResult result = client.get();
    EXPECT_EQ(result.status, 0) << result.output;
    std::istringstream words(result.output);
    std::string word;
    Vec3 force, torque;
    words >> word >> force.x() >> force.y() >> force.z() >> word >> torque.x() >> torque.y() >> torque.z();
    const double limit = device.limits().max_force;  // within what the device bears
    EXPECT_NEAR((force - limit * Vec3(1.5, -0.25, 100).normalized()).norm(), 0, 1e-12) << result.output;
    EXPECT_NEAR((torque - Vec3(0.1, 0, -0.05)).norm(), 0, 1e-12);
    EXPECT_TRUE(soon([&] { return !device.read().connected; }));
    EXPECT_TRUE(server.says("has gone"));
  }
}

TEST(Network, HandsComeBack) {
  Server server;
  for (int round = 0; round < 3; ++round) {
    {
      const RawPeer peer(server.devices.port());
      peer.send(transform_bytes("Left", 10.0F * static_cast<float>(round)));
      EXPECT_TRUE(soon([&] { return server.read(0).connected; }));
      EXPECT_NEAR(server.read(0).handle.position.x(), 0.01 * round, 1e-9);
      peer.send(sensor_bytes("Left", {0.1, 1, 0, 0}));
      EXPECT_TRUE(soon([&] { return server.read(0).grip == 1; }));
    }
    EXPECT_TRUE(soon([&] { return !server.read(0).connected; }));
  }
}

TEST(Network, ASilentHandIsNotConnected) {
  NetworkOptions options = any_port();
  options.silence = 0.05;
  NetworkDevices devices(options);
  const RawPeer peer(devices.port());
  peer.send(transform_bytes("Left", 0));
  EXPECT_TRUE(soon([&] { return devices.device(0).read().connected; }));
  EXPECT_TRUE(soon([&] { return !devices.device(0).read().connected; }));
  peer.send(transform_bytes("Left", 500));  // after a gap it may be anywhere
  EXPECT_TRUE(soon([&] { return devices.device(0).read().connected; }));
}

TEST(Network, EachHandIsOnePeers) {
  Server server;
  const RawPeer both(server.devices.port()), late(server.devices.port());
  both.send(transform_bytes("Left", 1));
  both.send(transform_bytes("Right", 2));
  EXPECT_TRUE(soon([&] { return server.read(0).connected && server.read(1).connected; }));
  late.send(transform_bytes("Left", 7));
  EXPECT_TRUE(soon([&] { return late.is_left(); }));
  EXPECT_TRUE(server.says("\"Left\" is somebody else's already"));
  EXPECT_NEAR(server.read(0).handle.position.x(), 1e-3, 1e-9);
  // An unknown name is told, and left alone.
  const RawPeer stranger(server.devices.port());
  stranger.send(transform_bytes("Stylus", 7));
  EXPECT_TRUE(server.says("there is no hand \"Stylus\"; there are: \"Left\", \"Right\""));
  EXPECT_FALSE(stranger.is_left());
}

TEST(Network, WhoSendsNonsenseIsLeftWithOneLine) {
  Server server;
  std::mt19937 random(5);
  Bytes noise(3000);
  for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
  noise[0] = 0x47;
  Bytes oversized = transform_bytes("Left", 1), future = oversized, spoilt = oversized;
  set_body_size(oversized, std::uint64_t{1} << 33);
  future[1] = 4;
  spoilt[70] ^= 1;
  const std::vector<std::pair<Bytes, std::string>> attacks = {
      {noise, "that Calot doesn't know"},
      {oversized, "larger than 4096 bytes"},
      {future, "that Calot doesn't know"},
      {spoilt, "whose checksum is wrong"},
  };
  const RawPeer hand(server.devices.port());
  hand.send(transform_bytes("Right", 1));
  for (const auto& [bytes, words] : attacks) {
    server.lines.clear();
    const RawPeer peer(server.devices.port());
    peer.send(bytes);
    EXPECT_TRUE(soon([&] { return peer.is_left(); })) << words;
    EXPECT_TRUE(server.says(words)) << server.lines;
  }
  {
    const RawPeer peer(server.devices.port());  // goes in the middle of a message
    const Bytes whole = transform_bytes("Left", 1);
    peer.send(Bytes(whole.begin(), whole.begin() + 70));
  }
  server.lines.clear();
  EXPECT_TRUE(server.says("has gone"));
  const RawPeer slow(server.devices.port());  // never ends its message
  const Bytes half = transform_bytes("Left", 1);
  slow.send(Bytes(half.begin(), half.begin() + 60));
  EXPECT_TRUE(server.says("the rest of its message didn't come"));
  EXPECT_FALSE(server.read(0).connected);
  EXPECT_TRUE(server.read(1).time > 0);  // the others are still served
  hand.send(transform_bytes("Right", 2));
  EXPECT_TRUE(soon([&] { return server.read(1).connected; }));
}

TEST(Network, NumbersThatMakeNoSenseAreLeftOut) {
  Server server;
  const RawPeer peer(server.devices.port());
  peer.send(transform_bytes("Left", 10));
  EXPECT_TRUE(soon([&] { return server.read(0).connected; }));
  peer.send(transform_bytes("Left", NAN));
  peer.send(sensor_bytes("Left", {NAN, 0, 0, 0}));
  EXPECT_TRUE(server.says("sends a TRANSFORM that makes no sense"));
  EXPECT_NEAR(server.read(0).handle.position.x(), 0.01, 1e-9);
  EXPECT_EQ(server.read(0).opening, 0);
  EXPECT_FALSE(peer.is_left());
}

TEST(Network, JumpsAreLeftOutUntilTheyLast) {
  Server server;
  const RawPeer peer(server.devices.port());
  peer.send(transform_bytes("Left", 0));
  EXPECT_TRUE(soon([&] { return server.read(0).connected; }));
  peer.send(transform_bytes("Left", 0));
  peer.send(transform_bytes("Left", 2000));
  EXPECT_TRUE(server.says("jumps by"));
  EXPECT_LT(server.read(0).handle.position.x(), 0.1);
  EXPECT_TRUE(soon([&] {
    peer.send(transform_bytes("Left", 2000));
    return server.read(0).handle.position.x() > 1.9;
  }));
}

TEST(Network, AFloodIsServedAndTheNewestWins) {
  Server server;
  const RawPeer peer(server.devices.port());
  Bytes flood;
  for (int k = 0; k <= 20000; ++k) {
    const Bytes one = transform_bytes("Left", 0.001F * static_cast<float>(k));
    flood.insert(flood.end(), one.begin(), one.end());
  }
  auto sending = std::async(std::launch::async, [&] { peer.send(flood); });
  EXPECT_TRUE(soon([&] { return std::abs(server.read(0).handle.position.x() - 0.02) < 1e-9; }));
  sending.get();
}

TEST(Network, NoMoreThanEightAtATime) {
  Server server;
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (int k = 0; k < 12; ++k) peers.push_back(std::make_unique<RawPeer>(server.devices.port()));
  EXPECT_TRUE(server.says("as 8 are here already"));
  EXPECT_TRUE(soon([&] { return peers.back()->is_left(); }));
  for (int k = 0; k < 80; ++k) {  // whoever comes and goes leaves no growing list
    const RawPeer guest(server.devices.port());
    EXPECT_TRUE(soon([&] { return guest.is_left(); }));
  }
  EXPECT_LE(server.devices.take_status().size(), 65u);
}

/// A wavy square of n × n points.
void wave(OrganSurface& surface, std::uint32_t n, float height, std::uint64_t topology) {
  surface.topology = topology;
  surface.positions.clear();
  surface.triangles.clear();
  for (std::uint32_t i = 0; i < n * n; ++i) {
    const float x = static_cast<float>(i % n), y = static_cast<float>(i / n);
    surface.positions.emplace_back(1e-3F * x, 1e-3F * y, height * std::sin(x) * std::cos(y));
  }
  for (std::uint32_t i = 0; i + n < n * n; ++i)
    if (i % n + 1 < n) surface.triangles.push_back({i, i + 1, i + n});
}

std::string text_of(const OrganSurface& surface) {
  std::string text = "surface Tissue\n";
  std::array<char, 200> line;
  for (const Eigen::Vector3f& x : surface.positions) {
    const Eigen::Vector3f mm = 1000.0F * x;
    std::snprintf(line.data(), line.size(), "v %a %a %a\n", static_cast<double>(mm.x()), static_cast<double>(mm.y()),
                  static_cast<double>(mm.z()));
    text += line.data();
  }
  for (const auto& t : surface.triangles) {
    std::snprintf(line.data(), line.size(), "f %u %u %u\n", t[0], t[1], t[2]);
    text += line.data();
  }
  return text;
}

TEST(Network, SurfacesArriveAsTheyAre) {
  Server server;
  OrganSurface first, second;
  wave(first, 40, 0.01F, 1);
  wave(second, 41, 0.02F, 2);  // after a cut
  server.devices.next_surface() = first;
  server.devices.publish_surface();
  auto client = server.client("look 2");
  EXPECT_TRUE(server.says("is here"));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  server.devices.next_surface() = second;
  server.devices.publish_surface();
  const CommandResult result = client.get();
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output, text_of(first) + text_of(second));
}

TEST(Network, SurfacesAreNoMoreThanTenASecondAndSlowPeersMissSome) {
  Server server;
  const RawPeer quick(server.devices.port()), stuck(server.devices.port());
  OrganSurface surface;
  wave(surface, 150, 0.01F, 1);  // 626 kB a message: more than a socket takes at once
  const auto begin = std::chrono::steady_clock::now();
  std::size_t bytes = 0;
  while (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(1300)) {
    server.devices.next_surface() = surface;
    server.devices.publish_surface();
    while (const std::size_t count = quick.drain()) bytes += count;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const std::size_t message = 58 + 40 + surface.positions.size() * 12 + surface.triangles.size() * 16;
  EXPECT_GE(bytes, 2 * message);
  EXPECT_LE(bytes, 11 * message);
}

}  // namespace
}  // namespace calot::test
