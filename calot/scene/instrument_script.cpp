#include "calot/scene/instrument_script.h"

#include <algorithm>
#include <cmath>

#include "calot/scene/turn.h"

namespace calot {
namespace {

/// The slope at the middle of three values: none at a turning point, else the weighted harmonic mean of both sides'.
double slope(double before, double here, double after, double left, double right) {
  const double a = (here - before) / left, b = (after - here) / right;
  if (a * b <= 0) return 0;
  const double wa = 2 * right + left, wb = right + 2 * left;
  return (wa + wb) / (wa / a + wb / b);
}

/// One number of the keys at a time between keys k and k + 1; at rest at both ends of the script.
template <class Key, class Value>
double cubic(const std::vector<Key>& keys, std::size_t k, double time, const Value& value) {
  const auto slope_at = [&](std::size_t i) {
    if (i == 0 || i + 1 == keys.size()) return 0.0;
    return slope(value(keys[i - 1]), value(keys[i]), value(keys[i + 1]), keys[i].time - keys[i - 1].time,
                 keys[i + 1].time - keys[i].time);
  };
  if (keys.size() == 1) return value(keys[0]);
  const double width = keys[k + 1].time - keys[k].time, s = (time - keys[k].time) / width;
  const double a = value(keys[k]), b = value(keys[k + 1]);
  const double rise = s * s * (3 - 2 * s);
  return a + rise * (b - a) + width * s * (1 - s) * ((1 - s) * slope_at(k) - s * slope_at(k + 1));
}

template <class Key, class Point>
Vec3 cubic_point(const std::vector<Key>& keys, std::size_t k, double time, const Point& point) {
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = cubic(keys, k, time, [&](const Key& key) { return point(key)[axis]; });
  return out;
}

/// The last key at or before a time that has another one after it; `time` is brought into their range.
template <class Key>
std::size_t stretch_of(const std::vector<Key>& keys, double& time) {
  time = std::clamp(time, keys.front().time, keys.back().time);
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const Key& key) { return t < key.time; });
  const auto k = static_cast<std::size_t>(after - keys.begin()) - 1;
  return std::min(k, std::max<std::size_t>(keys.size(), 2) - 2);
}

Eigen::Quaterniond level(const Vec3& axis) {
  Vec3 x = Vec3::UnitZ().cross(axis);
  if (x.norm() < 1e-6) x = Vec3::UnitX();
  x.normalize();
  Eigen::Matrix3d frame;
  frame << x, axis.cross(x), axis;
  return Eigen::Quaterniond(frame).normalized();
}

Vec3 axis_of(const Vec3& tip, const Vec3& direction, const std::optional<Vec3>& port) {
  constexpr double nearest = 1e-3;  // m; a tip within its port has no direction from there
  if (port && (tip - *port).norm() > nearest) return (tip - *port).normalized();
  return direction.norm() > 1e-9 ? Vec3(direction.normalized()) : Vec3(-Vec3::UnitZ());
}

template <class Key>
InstrumentInput fingers(const std::vector<Key>& keys, std::size_t k, double time) {
  InstrumentInput input;
  const Key& now = time >= keys.back().time ? keys.back() : keys[k];
  input.opening = cubic(keys, k, time, [](const Key& key) { return key.opening; });
  input.grip = cubic(keys, k, time, [](const Key& key) { return key.grip; });
  input.energy = now.energy;
  input.fire = now.fire;
  return input;
}

InstrumentInput at_keys(const std::vector<InstrumentKey>& keys, double reach, const std::optional<Vec3>& port,
                        double time) {
  const std::size_t k = stretch_of(keys, time);
  InstrumentInput input = fingers(keys, k, time);
  const Vec3 tip = cubic_point(keys, k, time, [](const InstrumentKey& key) { return key.tip; });
  const Vec3 direction = cubic_point(keys, k, time, [](const InstrumentKey& key) { return key.direction; });
  const Vec3 axis = axis_of(tip, direction, port), home = axis_of(keys[0].tip, keys[0].direction, port);
  const double roll = cubic(keys, k, time, [](const InstrumentKey& key) { return key.roll; });
  input.pose.rotation =
      (detail::shortest_turn(home, axis) * level(home) * Eigen::Quaterniond(Eigen::AngleAxisd(roll, Vec3::UnitZ())))
          .normalized();
  input.pose.position = tip - reach * axis;
  return input;
}

InstrumentInput at_poses(const std::vector<InstrumentPoseKey>& keys, double time) {
  const std::size_t k = stretch_of(keys, time);
  InstrumentInput input = fingers(keys, k, time);
  input.pose.position = cubic_point(keys, k, time, [](const InstrumentPoseKey& key) { return key.pose.position; });
  input.pose.rotation = keys[k].pose.rotation;
  if (keys.size() == 1) return input;
  const double share = (time - keys[k].time) / (keys[k + 1].time - keys[k].time);
  input.pose.rotation = input.pose.rotation.slerp(share, keys[k + 1].pose.rotation).normalized();
  return input;
}

}  // namespace

double InstrumentScript::end() const {
  if (empty()) return 0;
  return keys.empty() ? poses.back().time : keys.back().time;
}

InstrumentInput input_at(const InstrumentScript& script, double reach, const std::optional<Vec3>& port, double time) {
  return script.poses.empty() ? at_keys(script.keys, reach, port, time) : at_poses(script.poses, time);
}

}  // namespace calot
