// Inside this room only: small motions of rigid bodies along world axes, as haptic_constraints.h means them.
#pragma once
#include "calot/sim/haptic_constraints.h"

namespace calot {

/// Rotation vector [rad], at most π long, of the shorter way.
inline Vec3 rotation_vector(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1, sine = q.vec().norm();
  if (sine < 1e-12) return 2 * sign * q.vec();
  return 2 * sign * std::atan2(sine, sign * q.w()) / sine * q.vec();
}

/// What takes `from` to `to`: displacement of the origin and rotation vector.
inline Vector6 twist_between(const Pose& from, const Pose& to) {
  Vector6 twist;
  twist << to.position - from.position, rotation_vector(to.rotation * from.rotation.conjugate());
  return twist;
}

/// A pose after such a motion.
inline Pose moved(const Pose& pose, const Vector6& twist) {
  const double angle = twist.tail<3>().norm();
  Pose after{pose.rotation, pose.position + twist.head<3>()};
  if (angle > 0) after.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, twist.tail<3>() / angle)) * pose.rotation;
  after.rotation.normalize();
  return after;
}

/// Part of the way from a to b, 0 … 1.
inline Pose between(const Pose& a, const Pose& b, double share) {
  return moved(a, share * twist_between(a, b));
}

inline bool is_finite(const Pose& pose) {
  return pose.position.allFinite() && pose.rotation.coeffs().allFinite();
}

}  // namespace calot
