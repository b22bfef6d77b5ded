// Example 6: a new device is one file against HapticDevice. This one is a stick with two angles, a slide and a squeeze
// bulb, read by a microcontroller that prints a line for each sample:  seconds right forward slide squeeze
// (angles in degrees, the slide in mm, the squeeze 0 … 1). A motor on the slide pushes back.
#include <cmath>
#include <iostream>
#include <sstream>

#include "calot/base/error.h"
#include "calot/device/ported_device.h"
#include "calot/sim/haptic_tick.h"

using namespace calot;

// The device: turns its own numbers into a handle in world axes. read and write are called 1000 times a second; neither
// waits, allocates or throws, so a real one would leave the serial line to a thread of its own and give its last
// sample.
class SlideStick final : public HapticDevice {
 public:
  explicit SlideStick(std::istream& line) : line_(line) {}

  // What it can bear: a weak motor, no torque.
  [[nodiscard]] DeviceLimits limits() const override { return {3.0, 0.0, 800.0}; }

  DeviceState read() noexcept override {
    constexpr double degree = M_PI / 180, mm = 1e-3, length = 0.25;
    double right = 0, forward = 0, slide = 0, squeeze = 0;
    state_.connected = static_cast<bool>(line_ >> state_.time >> right >> forward >> slide >> squeeze);
    if (!state_.connected) return state_;  // unplugged: the rest means nothing
    const Eigen::Quaterniond tilt =
        Eigen::AngleAxisd(right * degree, Vec3::UnitY()) * Eigen::AngleAxisd(forward * degree, Vec3::UnitX());
    state_.handle = {tilt, tilt * Vec3(0, 0, length - slide * mm)};  // the knob, as seen from the stick's joint
    state_.opening = 0.6 * (1 - std::min(1.0, 2 * squeeze));
    state_.grip = 10 * std::max(0.0, 2 * squeeze - 1);
    return state_;
  }

  void write(const Vec3& force, const Vec3&) noexcept override {
    motor_ = force.dot(state_.handle.rotation * Vec3::UnitZ());
  }
  [[nodiscard]] double motor() const { return motor_; }  // [N], > 0 outwards

 private:
  std::istream& line_;
  DeviceState state_;
  double motor_ = 0;
};

// A second of samples: the stick goes 20 degrees to the right, the slide 30 mm in, the bulb is squeezed.
std::string recorded() {
  std::ostringstream text;
  for (int k = 0; k <= 1000; ++k) {
    const double t = 1e-3 * k, share = 0.5 - 0.5 * std::cos(M_PI * t);
    text << t << ' ' << 20 * share << " 0 " << 30 * share << ' ' << share << '\n';
  }
  return text.str();
}

int main() try {
  std::istringstream line(recorded());
  SlideStick stick(line);

  // The stick's joint is the port: its knob moves like the handle of an instrument, so the tip goes the other way.
  HandOptions options;
  options.map = HandMap::handle;
  options.port = {0, 0, 0.2};
  options.shaft_length = 0.40;
  const InstrumentGeometry grasper = instrument_geometry(InstrumentKind::bowel_grasper);
  const Pose start{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Vec3::UnitX())), Vec3(0, 0, 0.05 + reach_of(grasper))};
  PortedDevice device(stick, grasper, options, start);

  // Under the haptic loop's tick, as HapticLoop runs it in a thread; a world would give the constraints.
  HapticTick tick({}, device.limits());
  HapticOutput output;
  double worst = 0;
  for (int k = 0; k <= 1000; ++k) {
    output = tick.run(device.read(), 1e-3 * k);
    device.write({0, 0, 2}, Vec3::Zero());  // tissue that pushes the tip up with 2 N
    if (!output.has_pose) continue;
    const Pose& pose = output.input.pose;
    worst = std::max(worst, (options.port - pose.position).cross(pose.rotation * Vec3::UnitZ()).norm());
  }
  const Vec3 tip = output.input.pose * Vec3(0, 0, reach_of(grasper));
  std::cout << "the tip is at " << 1e3 * tip.transpose() << " mm; jaws " << output.input.opening << " rad, "
            << output.input.grip << " N; the motor gives " << stick.motor() << " N\n"
            << "the shaft passed the port within " << worst << " m; " << name_of(output.status) << '\n';
  const bool inverted = tip.x()<-0.04, deeper = (tip - options.port).norm()> 0.175;
  return inverted && deeper && output.input.opening == 0 && stick.motor() > 1 && worst < 1e-12 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
