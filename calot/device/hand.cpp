#include "calot/device/hand.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot {
namespace {

/// Takes unit vector a to unit vector b by the shortest way.
Eigen::Quaterniond shortest_turn(const Vec3& a, const Vec3& b) {
  const double cosine = a.dot(b);
  if (!(cosine > -1 + 1e-12)) {
    const Vec3 axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const Vec3 axis = a.cross(b);
  return Eigen::Quaterniond(1 + cosine, axis.x(), axis.y(), axis.z()).normalized();
}

Eigen::Quaterniond brought_to(const Eigen::Quaterniond& rotation, const Vec3& axis) {
  return (shortest_turn(rotation * Vec3::UnitZ(), axis) * rotation).normalized();
}

/// The part of a rotation that is about its own z axis [rad], −π … π; none where it is half a turn about another.
double roll_in(const Eigen::Quaterniond& q) {
  if (std::hypot(q.w(), q.z()) < 1e-9) return 0;
  return std::remainder(2 * std::atan2(q.z(), q.w()), 2 * M_PI);
}

Eigen::Quaterniond about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
}

bool is_sound(const DeviceState& state) {
  const double norm = state.handle.rotation.norm();
  return state.connected && state.handle.position.allFinite() && state.handle.position.cwiseAbs().maxCoeff() < 1e3 &&
         norm > 0.9 && norm < 1.1 && std::isfinite(state.opening) && std::isfinite(state.grip);
}

Vec3 across(const Vec3& v, const Vec3& axis) {
  return v - axis * axis.dot(v);
}

void need(bool holds, const char* what, const char* what_to_do) {
  if (!holds) throw InputError("hand", what, what_to_do);
}

void check(const HandOptions& o, const Pose& start) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  need(o.port.allFinite() && o.inward.allFinite() && o.origin.allFinite(), "a point is no number",
       "give three numbers");
  need(start.position.allFinite() && std::abs(start.rotation.norm() - 1) < 1e-3, "the start is no pose",
       "give a position and a unit quaternion");
  need(std::abs(o.axes.norm() - 1) < 1e-3, "the device's axes are no rotation", "give a unit quaternion");
  need(o.max_tilt >= 0.1 && o.max_tilt <= 1.5, "the largest tilt is out of range", "give 0.1 to 1.5 rad");
  need(positive(o.min_depth) && positive(o.max_depth) && o.max_depth > o.min_depth && positive(o.shaft_length) &&
           o.shaft_length > o.max_depth,
       "the depths make no sense", "give 0 < min_depth < max_depth < shaft_length");
  need(positive(o.scale), "the scale is out of range", "give a positive number");
  need(positive(o.max_speed) && positive(o.max_roll_speed) && positive(o.max_jaw_speed), "a speed is out of range",
       "give positive speeds");
}

}  // namespace

Pose through_port(const Pose& pose, double reach, const Vec3& port) {
  constexpr double nearest = 1e-3;  // m
  const Vec3 way = pose * Vec3(0, 0, reach) - port;
  const double depth = way.norm();
  if (!(depth > nearest)) return pose;
  Pose through{brought_to(pose.rotation, way / depth), Vec3::Zero()};
  through.position = port + (depth - reach) * (through.rotation * Vec3::UnitZ());
  return through;
}

Hand::Hand(const InstrumentGeometry& geometry, const HandOptions& options, const Pose& start) : options_(options) {
  check(options, start);
  options_.axes.normalize();
  reach_ = reach_of(geometry);
  max_opening_ = geometry.max_opening;
  max_grip_ = geometry.max_grip;
  const Eigen::Quaterniond rotation = start.rotation.normalized();
  const Vec3 axis = rotation * Vec3::UnitZ(), tip = start.position + reach_ * axis;
  const Vec3 way = tip - options_.port;
  if (options_.inward.norm() < 1e-9) options_.inward = way.norm() > 1e-3 ? way : axis;
  options_.inward.normalize();
  place(into_reach(tip, axis), rotation);
  at_limit_ = false;
}

void Hand::change(const InstrumentGeometry& geometry) {
  const Vec3 at = tip();
  reach_ = reach_of(geometry);
  max_opening_ = geometry.max_opening;
  max_grip_ = geometry.max_grip;
  input_.opening = input_.grip = 0;
  input_.energy = input_.fire = false;
  place(at, input_.pose.rotation);
}

// The shaft's axis is what the rotation makes of z; the pivot is put on the line through the port along it, so that
// nothing but one rounding keeps them apart.
void Hand::place(const Vec3& tip, const Eigen::Quaterniond& rotation) {
  const Vec3 way = tip - options_.port;
  depth_ = way.norm();
  input_.pose.rotation = brought_to(rotation, way / depth_);
  input_.pose.position = options_.port + (depth_ - reach_) * axis();
}

/// The nearest tip, about, that the port's cone and the shaft allow.
Vec3 Hand::into_reach(const Vec3& tip, const Vec3& axis_if_none) {
  const Vec3 way = tip - options_.port;
  const double length = way.norm();
  Vec3 axis = length > 1e-9 ? Vec3(way / length) : axis_if_none;
  double depth = length;
  at_limit_ = false;
  const double along = axis.dot(options_.inward);
  if (along < std::cos(options_.max_tilt)) {
    Vec3 side = across(axis, options_.inward);
    if (side.norm() < 1e-9) side = across(axis_if_none, options_.inward);
    if (side.norm() < 1e-9) side = options_.inward.unitOrthogonal();
    axis = std::cos(options_.max_tilt) * options_.inward + std::sin(options_.max_tilt) * side.normalized();
    axis.normalize();
    depth = way.dot(axis);
    at_limit_ = true;
  }
  if (depth < options_.min_depth || depth > options_.max_depth) at_limit_ = true;
  depth = std::clamp(depth, options_.min_depth, options_.max_depth);
  return options_.port + depth * axis;
}

void Hand::take_hold(const Pose& handle) {
  taken_ = handle;
  taken_rotation_ = input_.pose.rotation;
  taken_point_ = options_.map == HandMap::tip ? tip() : Vec3(options_.port - (options_.shaft_length - depth_) * axis());
  held_ = true;
}

Hand::Aim Hand::aim(const Pose& handle) {
  const HandOptions& o = options_;
  const Vec3 moved = o.scale * (o.axes * Vec3(handle.position - (o.absolute ? Vec3(Vec3::Zero()) : taken_.position)));
  Vec3 tip = (o.absolute ? o.origin : taken_point_) + moved;
  if (o.map == HandMap::handle) {
    const Vec3 way = o.port - tip;
    const double outside = std::max(way.norm(), 1e-6);
    tip = o.port + (o.shaft_length - outside) * (way / outside);
    // A handle pushed to the port leaves nothing of the shaft outside.
    if (outside >= o.shaft_length) tip = o.port + o.min_depth * (way / outside);
  }
  Aim aim{into_reach(tip, axis()), taken_rotation_};
  if (o.absolute)
    aim.rotation = o.axes * handle.rotation;
  else if (o.map == HandMap::tip)
    aim.rotation = taken_rotation_ * about_z(roll_in(taken_.rotation.conjugate() * handle.rotation));
  else
    aim.rotation = o.axes * handle.rotation * taken_.rotation.conjugate() * o.axes.conjugate() * taken_rotation_;
  // At the border the handle slips through the hand, so that the way back begins at once.
  if (at_limit_ && !o.absolute && o.map == HandMap::tip) {
    taken_ = handle;
    taken_point_ = aim.tip;
    taken_rotation_ = brought_to(aim.rotation, (aim.tip - o.port).normalized());
  }
  return aim;
}

void Hand::go(const Aim& aim, double elapsed) {
  const Vec3 from = tip(), way = aim.tip - from;
  const double length = way.norm(), step = options_.max_speed * elapsed;
  const bool limited = at_limit_;
  const Vec3 to = length <= step ? aim.tip : into_reach(from + step / length * way, axis());
  at_limit_ = limited;
  const Vec3 axis = (to - options_.port).normalized();
  const Eigen::Quaterniond kept = brought_to(input_.pose.rotation, axis), wanted = brought_to(aim.rotation, axis);
  const double roll = roll_in(kept.conjugate() * wanted), most = options_.max_roll_speed * elapsed;
  place(to, std::abs(roll) <= most ? wanted : kept * about_z(std::copysign(most, roll)));
}

void Hand::move_jaws(const DeviceState& state, bool ratchet, double elapsed) {
  double opening = std::clamp(state.opening, 0.0, max_opening_), grip = std::clamp(state.grip, 0.0, max_grip_);
  if (ratchet) {
    opening = std::min(opening, input_.opening);
    grip = std::max(grip, input_.grip);
  }
  const double most = options_.max_jaw_speed * elapsed;
  input_.opening += std::clamp(opening - input_.opening, -most, most);
  input_.grip = grip;
}

const InstrumentInput& Hand::update(const DeviceState& state, const HandControls& controls, double elapsed) {
  if (!is_sound(state)) {
    held_ = false;
    input_.energy = input_.fire = false;
    return input_;
  }
  Pose handle = state.handle;
  handle.rotation.normalize();
  handle_rotation_ = handle.rotation;
  move_jaws(state, controls.ratchet, std::max(elapsed, 0.0));
  input_.energy = state.pedal;
  input_.fire = state.button;
  if (controls.clutch) {
    held_ = false;
    return input_;
  }
  if (!held_) take_hold(handle);
  go(aim(handle), std::max(elapsed, 0.0));
  return input_;
}

// With a the axis, d the depth, r the shaft's length outside, P = I − a aᵀ: a tip that moves by δ turns the axis by
// P δ/d and carries the origin along by δ − reach/d P δ; a handle that moves by δ turns it by −P δ/r and carries the
// origin along by a (aᵀ δ) − (d − reach)/r P δ. The handle's force is the transpose of that.
HandWrench Hand::at_handle(const HandWrench& on) const {
  const Vec3 a = axis(), side = across(on.force, a), twist = across(on.torque.cross(a), a);
  const double outside = options_.shaft_length - depth_;
  Vec3 force = on.force - side, handle_axis = a;
  if (options_.map == HandMap::tip) {
    force += (1 - reach_ / depth_) * side + twist / depth_;
    handle_axis = options_.axes * (handle_rotation_ * Vec3::UnitZ());
  } else {
    force -= (depth_ - reach_) / outside * side + twist / outside;
  }
  const Eigen::Quaterniond back = options_.axes.conjugate();
  return {options_.scale * (back * force), back * Vec3(on.torque.dot(a) * handle_axis)};
}

double Hand::stiffness_through(double of_device) const {
  const double longest = options_.max_depth, outside = options_.shaft_length - longest;
  const double lever = options_.map == HandMap::tip ? 1.0 : std::max(1.0, longest / outside);
  const double ratio = std::max(1e-3, options_.scale * lever);
  return of_device / (ratio * ratio);
}

}  // namespace calot
