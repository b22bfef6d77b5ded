#include "calot/contact/rigid_shape.h"

#include <cmath>

namespace calot {
namespace {

Eigen::Matrix3d cross_matrix(const Vec3& w) {
  Eigen::Matrix3d m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

/// V of the exponential map of rigid motions: a body with twist (w, v) comes to lie V v further.
Eigen::Matrix3d drift(const Vec3& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d k = cross_matrix(w);
  const bool small = angle < 1e-4;
  const double a = small ? 0.5 - angle * angle / 24 : (1 - std::cos(angle)) / (angle * angle);
  const double b = small ? 1.0 / 6 - angle * angle / 120 : (angle - std::sin(angle)) / (angle * angle * angle);
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

Eigen::Quaterniond turn_by(const Vec3& w) {
  const double angle = w.norm(), half = 0.5 * angle;
  const double share = angle < 1e-8 ? 0.5 : std::sin(half) / angle;
  return Eigen::Quaterniond(std::cos(half), share * w.x(), share * w.y(), share * w.z());
}

}  // namespace

Screw screw_between(const Pose& from, const Pose& to) {
  Eigen::Quaterniond change = to.rotation * from.rotation.conjugate();
  if (change.w() < 0) change.coeffs() = -change.coeffs();
  const double sine = change.vec().norm();
  Screw screw;
  screw.turn = change.vec() * (sine < 1e-9 ? 2.0 : 2 * std::atan2(sine, change.w()) / sine);
  screw.shift = drift(screw.turn).inverse() * (to.position - from.position);
  return screw;
}

Pose pose_on(const Pose& from, const Screw& screw, double share) {
  const Vec3 turn = share * screw.turn;
  return {(turn_by(turn) * from.rotation).normalized(), from.position + drift(turn) * (share * screw.shift)};
}

Pose pose_between(const Pose& from, const Pose& to, double share) {
  return pose_on(from, screw_between(from, to), share);
}

}  // namespace calot
