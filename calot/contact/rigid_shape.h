// Rigid shapes: what instruments and still organs are made of when they meet tissue.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Where a rigid body is: x_world = rotation · x_body + position.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit
  Vec3 position = Vec3::Zero();                                  ///< [m]
  [[nodiscard]] Vec3 operator*(const Vec3& x) const { return rotation * x + position; }
  [[nodiscard]] Pose operator*(const Pose& inner) const { return {rotation * inner.rotation, *this * inner.position}; }
  [[nodiscard]] Pose inverse() const { return {rotation.conjugate(), rotation.conjugate() * -position}; }
};

/// A point, segment or triangle swept by a sphere: ball, capsule or rounded plate.
struct RoundedPiece {
  std::array<Vec3, 3> corners;  ///< [m], body frame; only the first `corner_count` count
  int corner_count = 1;         ///< 1 … 3
  double radius = 0;            ///< of the sphere, > 0 [m]
};

struct RigidShape {
  std::vector<RoundedPiece> pieces;
};

/// A rigid shape on its way through one step; between the poses it moves evenly (screw motion).
struct MovingShape {
  const RigidShape* shape = nullptr;
  Pose from, to;
  double friction = 0.1;  ///< Coulomb's coefficient against tissue, ≥ 0
};

/// The pose at `share` (0 … 1) of the way from one pose to another on a screw: constant twist, the shorter way round.
Pose pose_between(const Pose& from, const Pose& to, double share);

/// The twist of that screw: a point x of the body moves off with turn × (x − from.position) + shift per whole way, and
/// keeps that speed.
struct Screw {
  Vec3 turn = Vec3::Zero();   ///< axis times angle, ≤ π [rad]
  Vec3 shift = Vec3::Zero();  ///< of from.position [m]
};
Screw screw_between(const Pose& from, const Pose& to);
Pose pose_on(const Pose& from, const Screw& screw, double share);

}  // namespace calot
