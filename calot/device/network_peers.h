// Inside this room only: the peers of a server, as its one thread keeps them.
#pragma once
#include <atomic>
#include <deque>
#include <mutex>

#include "calot/base/triple_buffer.h"
#include "calot/device/network.h"

namespace calot::detail {

double seconds_now();

/// A hand on the network: what the peer said last and what it shall feel.
class NetworkHand final : public HapticDevice {
 public:
  NetworkHand(std::string device_name, const DeviceLimits& limits) : name(std::move(device_name)), limits_(limits) {}
  [[nodiscard]] DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override;
  void write(const Vec3& force, const Vec3& torque) noexcept override;

  struct Felt {
    HandWrench wrench;
    double time = 0;  // [s]
  };
  const std::string name;
  TripleBuffer<DeviceState> samples;
  TripleBuffer<Felt> forces;
  std::atomic<bool> clutch = false, ratchet = false;

  // The network thread's alone:
  int owner = -1;         // file descriptor of the peer that is this hand
  DeviceState sample;     // that will be published next
  double last_pose = 0;   // when [s]
  double next_force = 0;  // not before [s]
  bool new_sample = false, has_pose = false, shows_force = false;

 private:
  DeviceLimits limits_;
};

struct Peer {
  int socket = -1;
  std::string name;  // address and port
  IgtlReader reader;
  std::vector<std::uint8_t> out;
  std::size_t sent = 0;
  bool is_hand = false;                                                     // one or more; else it looks on
  double opened = 0, heard = 0, whole = 0, moved_on = 0, next_surface = 0;  // times [s]
  std::uint64_t surface = 0;                                                // number of the last one sent
  bool told_of_nonsense = false, told_of_name = false, told_of_jump = false;
};

/// Lines for people, the newest 64.
class StatusLines {
 public:
  void add(std::string line);
  std::vector<std::string> take();

 private:
  std::mutex mutex_;
  std::deque<std::string> lines_;
  std::uint64_t lost_ = 0;
};

/// Everything that the thread does. Only the buffers in the hands, `surfaces` and `status` are shared.
class PeerKeeper {
 public:
  PeerKeeper(const NetworkOptions& options, int listener);
  ~PeerKeeper();
  PeerKeeper(const PeerKeeper&) = delete;
  PeerKeeper& operator=(const PeerKeeper&) = delete;

  /// Waits for something to do, 50 ms at most, and does it; not more than 2000 times a second.
  void turn();
  /// Leaves all peers.
  void close_all(const std::string& why);

  std::vector<std::unique_ptr<NetworkHand>> hands;
  TripleBuffer<OrganSurface> surfaces;
  StatusLines status;

 private:
  void wait();
  void accept_peers();
  void hear(Peer& peer);
  void understand(Peer& peer, const IgtlMessage& message);
  bool claim(Peer& peer, int hand);
  void take_pose(Peer& peer, NetworkHand& hand, const Pose& pose);
  void publish_samples();
  void give_forces();
  void give_surfaces();
  void send_on(Peer& peer);
  void check_times(Peer& peer);
  void leave(Peer& peer, const std::string& why);

  NetworkOptions options_;
  int listener_;
  double now_ = 0, last_turn_ = 0;
  std::vector<std::unique_ptr<Peer>> peers_;
  IgtlSurfacePacker packer_;
  std::vector<std::uint8_t> packed_;  // the newest surface
  std::uint64_t surface_ = 0, packed_surface_ = 0;
};

}  // namespace calot::detail
