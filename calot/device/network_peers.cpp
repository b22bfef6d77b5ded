#include "calot/device/network_peers.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <utility>

namespace calot::detail {
namespace {

constexpr std::size_t most_peers = 8;
constexpr std::size_t bytes_a_turn = 16 << 10;  // of one peer
constexpr double shortest_turn = 0.5e-3;        // s: 2 kHz
constexpr double mute_after = 5;                // s: a hand's peer that says nothing is left
constexpr double whole_after = 2;               // s: a message must have come whole
constexpr double stuck_after = 10;              // s: a peer that takes nothing of what is sent is left
constexpr double let_go_after = 0.02;           // s without a force from the loop
constexpr double looks_on_after = 0.3;          // s until a peer that says nothing gets surfaces
constexpr double fastest = 5, slack = 0.02;     // m/s, m: further is a jump …
constexpr double new_place_after = 0.1;         // s: … until it has lasted so long

Vec3 at_most(const Vec3& v, double length) {
  const double norm = v.norm();
  if (!std::isfinite(norm)) return Vec3::Zero();
  return norm <= length ? v : Vec3(length / norm * v);
}

void sleep_for(double seconds) {
  if (!(seconds > 0)) return;
  timespec time{0, static_cast<long>(std::min(seconds, 0.9) * 1e9)};
  (void)nanosleep(&time, nullptr);
}

}  // namespace

double seconds_now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

DeviceState NetworkHand::read() noexcept {
  (void)samples.fetch();
  return samples.reading();
}

void NetworkHand::write(const Vec3& force, const Vec3& torque) noexcept {
  forces.writing() = {{at_most(force, limits_.max_force), at_most(torque, limits_.max_torque)}, seconds_now()};
  forces.publish();
}

void StatusLines::add(std::string line) {
  constexpr std::size_t most = 64;
  const std::lock_guard lock(mutex_);
  if (lines_.size() == most) {
    lines_.pop_front();
    ++lost_;
  }
  lines_.push_back(std::move(line));
}

std::vector<std::string> StatusLines::take() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken(lines_.begin(), lines_.end());
  if (lost_ > 0) taken.insert(taken.begin(), std::to_string(lost_) + " earlier lines are left out");
  lines_.clear();
  lost_ = 0;
  return taken;
}

PeerKeeper::PeerKeeper(const NetworkOptions& options, int listener) : options_(options), listener_(listener) {
  for (const std::string& name : options.hands) hands.push_back(std::make_unique<NetworkHand>(name, options.limits));
}

PeerKeeper::~PeerKeeper() {
  for (const auto& peer : peers_) close(peer->socket);
  close(listener_);
}

void PeerKeeper::turn() {
  wait();
  now_ = seconds_now();
  sleep_for(shortest_turn - (now_ - last_turn_));
  now_ = last_turn_ = seconds_now();
  accept_peers();
  for (const auto& peer : peers_) hear(*peer);
  publish_samples();
  give_forces();
  give_surfaces();
  for (const auto& peer : peers_) send_on(*peer);
  for (const auto& peer : peers_) check_times(*peer);
  std::erase_if(peers_, [](const auto& peer) { return peer->socket < 0; });
}

void PeerKeeper::wait() {
  constexpr int with_hands = 1, with_lookers = 10, alone = 50;  // ms
  std::vector<pollfd> sockets = {{listener_, POLLIN, 0}};
  int timeout = peers_.empty() ? alone : with_lookers;
  for (const auto& peer : peers_) {
    const bool waits = peer->sent < peer->out.size();
    sockets.push_back({peer->socket, static_cast<short>(waits ? POLLIN | POLLOUT : POLLIN), 0});
    if (peer->is_hand) timeout = with_hands;
  }
  (void)poll(sockets.data(), sockets.size(), timeout);
}

void PeerKeeper::accept_peers() {
  for (std::size_t k = 0; k < most_peers; ++k) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    const int socket = accept4(listener_, reinterpret_cast<sockaddr*>(&address), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    std::array<char, INET_ADDRSTRLEN> text{};
    (void)inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
    const std::string name = std::string(text.data()) + ":" + std::to_string(ntohs(address.sin_port));
    if (peers_.size() >= most_peers) {
      close(socket);
      status.add(name + ": left at once, as 8 are here already");
      continue;
    }
    const int on = 1;
    (void)setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    auto peer = std::make_unique<Peer>();
    peer->socket = socket;
    peer->name = name;
    peer->opened = peer->heard = peer->whole = peer->moved_on = now_;
    status.add(name + ": is here");
    peers_.push_back(std::move(peer));
  }
}

void PeerKeeper::leave(Peer& peer, const std::string& why) {
  if (peer.socket < 0) return;
  status.add(peer.name + ": " + why);
  for (const auto& hand : hands) {
    if (hand->owner != peer.socket) continue;
    hand->owner = -1;
    hand->sample = DeviceState();
    hand->new_sample = true;
    hand->has_pose = hand->shows_force = false;
    hand->clutch = hand->ratchet = false;
  }
  close(peer.socket);
  peer.socket = -1;
}

void PeerKeeper::close_all(const std::string& why) {
  now_ = seconds_now();
  for (const auto& peer : peers_) leave(*peer, why);
  publish_samples();
  peers_.clear();
}

void PeerKeeper::hear(Peer& peer) {
  std::array<std::uint8_t, bytes_a_turn> buffer;
  if (peer.socket < 0) return;
  const ssize_t count = recv(peer.socket, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (count == 0) return leave(peer, "has gone");
  if (count < 0) {
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
      leave(peer, std::string("has gone: ") + std::strerror(errno));
    return;
  }
  std::span<const std::uint8_t> bytes(buffer.data(), static_cast<std::size_t>(count));
  while (!bytes.empty() && peer.socket >= 0) {
    if (!peer.reader.is_within()) peer.whole = now_;
    bytes = bytes.subspan(peer.reader.take(bytes));
    if (const auto message = peer.reader.message()) understand(peer, *message);
    if (peer.reader.fault() != IgtlFault::none)
      leave(peer, "left, as it sent " + std::string(words_of(peer.reader.fault())));
  }
}

/// One peer may be several hands, but each hand is one peer's.
bool PeerKeeper::claim(Peer& peer, int hand) {
  NetworkHand& wanted = *hands[static_cast<std::size_t>(hand)];
  if (wanted.owner == peer.socket) return true;
  if (wanted.owner >= 0) {
    leave(peer, "left, as \"" + wanted.name + "\" is somebody else's already");
    return false;
  }
  wanted.owner = peer.socket;
  peer.is_hand = true;
  status.add(peer.name + ": is the hand \"" + wanted.name + "\"");
  return true;
}

void PeerKeeper::understand(Peer& peer, const IgtlMessage& message) {
  const bool is_pose = message.type == "TRANSFORM" || message.type == "POSITION", is_fingers = message.type == "SENSOR";
  peer.heard = now_;
  if (!is_pose && !is_fingers) return;  // for others than a simulator of hands
  const auto found =
      std::find_if(hands.begin(), hands.end(), [&](const auto& hand) { return hand->name == message.device; });
  if (found == hands.end()) {
    if (!std::exchange(peer.told_of_name, true)) {
      std::string names;
      for (const auto& hand : hands) names += (names.empty() ? "\"" : ", \"") + hand->name + "\"";
      status.add(peer.name + ": there is no hand \"" + std::string(message.device) + "\"; there are: " + names);
    }
    return;
  }
  const auto pose = igtl_pose(message);
  const auto fingers = igtl_fingers(message);
  if (!pose && !fingers) {
    if (!std::exchange(peer.told_of_nonsense, true))
      status.add(peer.name + ": sends a " + std::string(message.type) + " that makes no sense; such are left out");
    return;
  }
  if (!claim(peer, static_cast<int>(found - hands.begin()))) return;
  NetworkHand& hand = **found;
  if (pose) take_pose(peer, hand, *pose);
  if (fingers) {
    hand.sample.opening = fingers->opening;
    hand.sample.grip = fingers->grip;
    hand.sample.pedal = fingers->pedal;
    hand.sample.button = fingers->button;
    hand.clutch = fingers->controls.clutch;
    hand.ratchet = fingers->controls.ratchet;
    hand.new_sample = hand.has_pose;
  }
}

/// Leaves out a pose too far from the last good one, unless such have come for so long that the hand really is there.
void PeerKeeper::take_pose(Peer& peer, NetworkHand& hand, const Pose& pose) {
  const double elapsed = now_ - hand.last_pose;
  const double way = (pose.position - hand.sample.handle.position).norm();
  if (hand.has_pose && elapsed < new_place_after && way > slack + fastest * elapsed) {
    if (!std::exchange(peer.told_of_jump, true))
      status.add(peer.name + ": jumps by " + std::to_string(std::lround(1e3 * way)) + " mm; such poses are left out");
    return;
  }
  hand.sample.handle = pose;
  hand.sample.connected = true;
  hand.last_pose = now_;
  hand.has_pose = hand.new_sample = true;
}

void PeerKeeper::publish_samples() {
  for (const auto& hand : hands) {
    if (hand->has_pose && now_ - hand->last_pose > options_.silence) {
      hand->has_pose = false;
      hand->sample.connected = false;
      hand->new_sample = true;
    }
    if (!std::exchange(hand->new_sample, false)) continue;
    hand->sample.time = now_;
    hand->samples.writing() = hand->sample;
    hand->samples.publish();
  }
}

/// The newest force; none any more when the loop has stopped giving any.
void PeerKeeper::give_forces() {
  for (const auto& peer : peers_) {
    if (peer->socket < 0 || peer->sent < peer->out.size()) continue;
    for (const auto& hand : hands) {
      if (hand->owner != peer->socket || now_ < hand->next_force) continue;
      const bool fresh = hand->forces.fetch();
      const NetworkHand::Felt& felt = hand->forces.reading();
      const bool stale = now_ - felt.time > let_go_after;
      if (!(fresh && !stale) && !(stale && hand->shows_force)) continue;
      hand->shows_force = !stale;
      hand->next_force = now_ + 1 / options_.force_rate;
      if (peer->sent == peer->out.size()) {
        peer->out.clear();
        peer->sent = 0;
        peer->moved_on = now_;
      }
      write_igtl_wrench(peer->out, hand->name, stale ? HandWrench() : felt.wrench);
    }
  }
}

/// To those who look on and have taken all of the one before.
void PeerKeeper::give_surfaces() {
  if (surfaces.fetch()) ++surface_;
  for (const auto& peer : peers_) {
    if (peer->socket < 0 || peer->is_hand || surface_ == 0 || peer->surface == surface_) continue;
    if (peer->sent < peer->out.size() || now_ < peer->next_surface || now_ < peer->opened + looks_on_after) continue;
    if (packed_surface_ != surface_) {
      packed_.clear();
      packed_surface_ = surface_;
      if (!packer_.pack(packed_, options_.organ, surfaces.reading())) packed_.clear();
    }
    peer->surface = surface_;
    peer->next_surface = now_ + 1 / options_.organ_rate;
    peer->out = packed_;
    peer->sent = 0;
    peer->moved_on = now_;
  }
}

void PeerKeeper::send_on(Peer& peer) {
  if (peer.socket < 0 || peer.sent == peer.out.size()) return;
  const ssize_t count =
      send(peer.socket, peer.out.data() + peer.sent, peer.out.size() - peer.sent, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count > 0) {
    peer.sent += static_cast<std::size_t>(count);
    peer.moved_on = now_;
  } else if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
    leave(peer, std::string("has gone: ") + std::strerror(errno));
  }
}

void PeerKeeper::check_times(Peer& peer) {
  if (peer.socket < 0) return;
  if (peer.reader.is_within() && now_ - peer.whole > whole_after)
    leave(peer, "left, as the rest of its message didn't come");
  else if (peer.is_hand && now_ - peer.heard > mute_after)
    leave(peer, "left, as it has said nothing for 5 s");
  else if (peer.sent < peer.out.size() && now_ - peer.moved_on > stuck_after)
    leave(peer, "left, as it takes nothing of what is sent");
}

}  // namespace calot::detail
