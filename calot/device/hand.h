// From what a device says to what an instrument does through its port: 4 degrees of freedom, jaws, ratchet, clutch.
#pragma once
#include "calot/sim/haptic_device.h"
#include "calot/sim/instrument.h"

namespace calot {

/// What of the instrument the device's handle moves.
enum class HandMap : std::uint8_t {
  tip,     ///< its tip; turning the handle about its own z axis rolls it. Mice, gamepads, telemanipulators
  handle,  ///< its handle, outside the port: the tip goes the other way (fulcrum). Box trainers, real instruments
};

struct HandOptions {
  HandMap map = HandMap::tip;
  Vec3 port = Vec3::Zero();                                  ///< world [m]
  Vec3 inward = Vec3::Zero();                                ///< middle of the cone of tilts; zero: where it starts
  double max_tilt = 1.3;                                     ///< from there, 0.1 … 1.5 [rad]
  double min_depth = 0.02, max_depth = 0.30;                 ///< from the port to the tip [m]
  double shaft_length = 0.40;                                ///< from the handle to the tip, > max_depth [m]
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();  ///< from the device's axes to the world's
  double scale = 1;                                          ///< of displacements, > 0
  bool absolute = false;       ///< the handle's place counts, not how far it came since the hand took hold of it
  Vec3 origin = Vec3::Zero();  ///< absolute: where the device's origin is [m]
  double max_speed = 0.5;      ///< of the tip, > 0 [m/s]
  double max_roll_speed = 12;  ///< > 0 [rad/s]
  double max_jaw_speed = 12;   ///< > 0 [rad/s]
};

/// What a device can't say in a DeviceState.
struct HandControls {
  bool clutch = false;   ///< the handle moves, the instrument stays
  bool ratchet = false;  ///< the jaws can close, not open
};

/// Force and torque on a handle.
struct HandWrench {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  ///< [N], about the handle [N·m]
};

/// The pose with the same tip and nearly the same roll whose axis goes through a port. A tip nearer to it than 1 mm
/// leaves the axis as it is.
Pose through_port(const Pose& pose, double reach, const Vec3& port);

/// Not for two threads at a time. Nothing allocates but the constructor.
class Hand {
 public:
  /// @param start  its axis is brought through the port, its tip within reach. Throws InputError for options out of
  /// range
  Hand(const InstrumentGeometry& geometry, const HandOptions& options, const Pose& start);

  /// One step, `elapsed` long [s]. The first good sample, and the first after a clutch or a silence, takes hold of the
  /// handle where it is. Without a connected, finite sample the instrument stays, its jaws too; pedal and button are
  /// off.
  const InstrumentInput& update(const DeviceState& state, const HandControls& controls, double elapsed);
  /// Another instrument through the same port; its tip comes where the last one's was.
  void change(const InstrumentGeometry& geometry);

  [[nodiscard]] const InstrumentInput& input() const { return input_; }
  [[nodiscard]] Vec3 axis() const { return input_.pose.rotation * Vec3::UnitZ(); }
  [[nodiscard]] double depth() const { return depth_; }  ///< from the port to the tip [m]
  [[nodiscard]] Vec3 tip() const { return options_.port + depth_ * axis(); }
  [[nodiscard]] bool at_limit() const { return at_limit_; }  ///< of tilt or depth
  [[nodiscard]] const HandOptions& options() const { return options_; }

  /// What a wrench on the instrument (torque about its frame's origin) is at the handle: the same virtual work for
  /// every motion that the port allows.
  [[nodiscard]] HandWrench at_handle(const HandWrench& on_instrument) const;
  /// A device that renders walls up to a stiffness lets the instrument feel at most this [N/m].
  [[nodiscard]] double stiffness_through(double of_device) const;

 private:
  struct Aim {
    Vec3 tip;                     // in the cone
    Eigen::Quaterniond rotation;  // its z may point elsewhere
  };
  void take_hold(const Pose& handle);
  Aim aim(const Pose& handle);
  Vec3 into_reach(const Vec3& tip, const Vec3& axis_if_none);
  void go(const Aim& aim, double elapsed);
  void move_jaws(const DeviceState& state, bool ratchet, double elapsed);
  void place(const Vec3& tip, const Eigen::Quaterniond& rotation);

  HandOptions options_;
  double reach_ = 0, max_opening_ = 0, max_grip_ = 0;
  InstrumentInput input_;
  double depth_ = 0;
  bool held_ = false, at_limit_ = false;
  Pose taken_;        // the device's handle when the hand took hold of it
  Vec3 taken_point_;  // what it moves, then: tip or handle of the instrument
  Eigen::Quaterniond taken_rotation_;
  Eigen::Quaterniond handle_rotation_ = Eigen::Quaterniond::Identity();  // now, device's axes
};

}  // namespace calot
