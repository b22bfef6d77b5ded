#include "calot/sim/haptic_mock.h"

#include <cmath>
#include <limits>

#include "calot/sim/haptic_twist.h"

namespace calot {

MockHapticDevice::MockHapticDevice(Script wanted, MockHand hand, DeviceLimits limits, double period)
    : wanted_(std::move(wanted)), hand_(hand), limits_(limits), period_(period), handle_(wanted_(0)) {}

void MockHapticDevice::set_fingers(double opening, double grip, bool pedal, bool button) {
  opening_ = opening;
  grip_ = grip;
  pedal_ = pedal;
  button_ = button;
}

void MockHapticDevice::write(const Vec3& force, const Vec3& torque) noexcept {
  force_ = force;
  torque_ = torque;
}

// The shown force holds between two ticks while the hand moves on, as at a real device: in steps so short that what
// the integration loses or gains doesn't matter beside that.
void MockHapticDevice::advance(double seconds) {
  constexpr int parts = 20;
  const double step = seconds / parts;
  for (int i = 0; i < parts; ++i) {
    time_ += step;
    const Vector6 away = twist_between(handle_, wanted_(time_));
    const Vec3 pull = hand_.stiffness * away.head<3>() - (hand_.damping + hand_.friction) * velocity_;
    const Vec3 turn = hand_.turning * away.tail<3>() - hand_.turn_damping * spin_;
    velocity_ += step / hand_.mass * (pull + force_);
    spin_ += step / hand_.inertia * (turn + torque_);
    Vector6 motion;
    motion << step * velocity_, step * spin_;
    handle_ = moved(handle_, motion);
  }
}

DeviceState MockHapticDevice::read() noexcept {
  advance(period_);
  const MockFault fault = fault_;
  if (fault == MockFault::silent) return last_;
  last_ = {time_, true, handle_, opening_, grip_, pedal_, button_};
  if (fault == MockFault::not_a_number) last_.handle.position.y() = std::numeric_limits<double>::quiet_NaN();
  if (fault == MockFault::jump) last_.handle.position.x() += 1.0;
  if (fault == MockFault::disconnected) {
    last_ = DeviceState();
    last_.time = time_;
  }
  return last_;
}

}  // namespace calot
