// Where the laparoscope looks from.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/patient/landmarks_parts.h"

namespace calot::detail {
namespace {

constexpr double mm = 1e-3;
constexpr double usual_distance = 70 * mm;
constexpr double oblique = 30;            // degrees
constexpr double tip_clearance = 8 * mm;  // of the tip from any organ
constexpr double short_of = 5 * mm;       // sight lines end so far before the corner: its own tissue covers it

/// The tip of an oblique laparoscope that looks straight at a target: port, tip and target make a triangle with an
/// angle of 180° − oblique at the tip.
/// @param side  a unit direction across the way from target to port: where the tip leaves it
Vec3 tip_at(const Vec3& port, const Vec3& target, double distance, const Vec3& side) {
  const Vec3 way = port - target;
  const double bend = oblique * M_PI / 180;
  const double at_port = std::asin(std::min(1.0, distance * std::sin(bend) / way.norm()));
  const double at_target = bend - at_port;
  return target + distance * (std::cos(at_target) * way.normalized() + std::sin(at_target) * side);
}

/// What stands between the tip and the triangle.
LabelProbe::Blocked sight(const LabelProbe& probe, const CalotTriangle& triangle, const Vec3& tip) {
  LabelProbe::Blocked worst;
  for (const Vec3& corner : {triangle.duct_corner, triangle.neck_corner, triangle.liver_corner, middle_of(triangle)}) {
    const double length = (corner - tip).norm();
    const LabelProbe::Blocked b = probe.blocked(tip, corner + short_of / length * (tip - corner));
    if (b.length > worst.length) worst.by = b.by;
    worst.length += b.length;
  }
  return worst;
}

/// Liver on top of the picture.
Vec3 up_for(const Vec3& tip, const Vec3& target, const Vec3& liver) {
  const Vec3 view = (target - tip).normalized();
  for (const Vec3& wanted : {Vec3(liver - target), Vec3(Vec3::UnitZ()), Vec3(Vec3::UnitY())}) {
    const Vec3 across = wanted - wanted.dot(view) * view;
    if (across.norm() > 0.25 * wanted.norm() && across.norm() > 1e-9) return across.normalized();
  }
  return view.unitOrthogonal();
}

}  // namespace

CameraPose find_camera(const Port& port, const OrganPlaces& organs, const CalotTriangle& triangle,
                       const LabelProbe& probe, std::vector<std::string>& notes) {
  const Vec3 target = middle_of(triangle), way = (port.position - target).normalized();
  Vec3 forward = Vec3::UnitY() - Vec3::UnitY().dot(way) * way;
  if (forward.norm() < 1e-3) forward = way.unitOrthogonal();
  forward.normalize();
  const Vec3 aside = way.cross(forward);
  CameraPose pose;
  pose.target = target;
  pose.oblique = oblique;
  double least = 1e300;
  LabelProbe::Blocked seen;
  constexpr int turns = 24;
  for (const double distance : {70 * mm, 65 * mm, 75 * mm, 60 * mm, 80 * mm, 90 * mm, 100 * mm, 50 * mm, 110 * mm})
    for (int turn = 0; turn < turns; ++turn) {
      const double angle = 2 * M_PI * turn / turns;
      const Vec3 tip = tip_at(port.position, target, distance, std::cos(angle) * forward + std::sin(angle) * aside);
      const LabelProbe::Blocked blocked = sight(probe, triangle, tip);
      const double shaft = probe.blocked(port.position, tip).length;
      // Free sight first, then a free way for the shaft, then the usual distance, then from the front.
      const double cost = blocked.length / mm + 0.5 * shaft / mm + (probe.organ_within(tip, tip_clearance) ? 50 : 0) +
                          0.05 * std::abs(distance - usual_distance) / mm + 0.5 * (1 - std::cos(angle));
      if (cost >= least) continue;
      least = cost;
      seen = blocked;
      pose.tip = tip;
    }
  pose.up = up_for(pose.tip, target, organs.liver_middle);
  if (seen.length > 1 * mm)
    notes.push_back("with the organs at rest the " + std::string(name_of(seen.by)) +
                    " stands in the laparoscope's sight of Calot's triangle; it is free once the fundus is pushed up");
  return pose;
}

}  // namespace calot::detail
