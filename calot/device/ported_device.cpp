#include "calot/device/ported_device.h"

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

Vec3 at_most(const Vec3& v, double length) {
  const double norm = v.norm();
  if (!std::isfinite(norm)) return Vec3::Zero();
  return norm <= length ? v : Vec3(length / norm * v);
}

}  // namespace

DeviceState PortedDevice::read() noexcept {
  constexpr double longest = 0.05;  // s; after a gap the hand doesn't make up for all of it at once
  DeviceState state = device_.read();
  const bool timed = state.connected && std::isfinite(state.time);
  const double elapsed = timed && started_ ? std::clamp(state.time - last_, 0.0, longest) : 0.0;
  if (timed) {
    last_ = state.time;
    started_ = true;
  }
  const InstrumentInput& input = hand_.update(state, {clutch_, ratchet_}, elapsed);
  // What isn't sound goes on as it is: the loop's guard says what is wrong with it.
  if (state.connected && state.handle.position.allFinite() && state.handle.rotation.coeffs().allFinite())
    state.handle = input.pose;
  state.opening = std::isfinite(state.opening) ? input.opening : state.opening;
  state.grip = std::isfinite(state.grip) ? input.grip : state.grip;
  return state;
}

void PortedDevice::write(const Vec3& force, const Vec3& torque) noexcept {
  const DeviceLimits own = device_.limits();
  const HandWrench at = hand_.at_handle({force, torque});
  device_.write(at_most(at.force, own.max_force), at_most(at.torque, own.max_torque));
}

}  // namespace calot
