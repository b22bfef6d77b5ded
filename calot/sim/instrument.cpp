#include "calot/sim/instrument.h"

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double shaft_length = 0.33;  // of the usual 5 mm instruments

RoundedPiece capsule(const Vec3& a, const Vec3& b, double radius) {
  return {{a, b, b}, 2, radius};
}

RoundedPiece plate(const Vec3& a, const Vec3& b, const Vec3& c, double radius) {
  return {{a, b, c}, 3, radius};
}

/// A tube along −z whose rounded end reaches z = end.
RigidShape tube(double radius, double end) {
  return {{capsule({0, 0, -shaft_length}, {0, 0, end - radius}, radius)}};
}

/// Jaw b from jaw a: mirrored in y = 0.
RigidShape mirrored(RigidShape shape) {
  for (RoundedPiece& piece : shape.pieces)
    for (Vec3& corner : piece.corners) corner.y() = -corner.y();
  return shape;
}

/// Everything that jaws share: stiffness of shaft and faces, forces of the hand.
InstrumentGeometry with_jaws(InstrumentKind kind, double length, double width, double max_opening) {
  InstrumentGeometry g;
  g.kind = kind;
  g.shaft = tube(2.5 * mm, -1 * mm);
  g.max_opening = max_opening;
  g.jaw_length = length;
  g.jaw_width = g.tip_width = width;
  g.face_start = 3 * mm;
  g.grip_stiffness = 3000;
  g.face_stiffness = 20000;
  g.usual_grip = 6.8;
  g.max_grip = 20;
  return g;
}

/// A long window in each jaw, with two rails beside it, closed at the tip.
InstrumentGeometry bowel_grasper() {
  InstrumentGeometry g = with_jaws(InstrumentKind::bowel_grasper, 24 * mm, 5 * mm, 1.05);
  const double r = 0.8 * mm, rail = g.jaw_width / 2 - r, tip = g.jaw_length - r;
  g.jaw_a.pieces = {
      capsule({-rail, -r, g.face_start}, {-rail, -r, tip}, r), capsule({rail, -r, g.face_start}, {rail, -r, tip}, r),
      capsule({-rail, -r, tip}, {rail, -r, tip}, r), capsule({-rail, -r, g.face_start}, {rail, -r, g.face_start}, r),
      capsule({0, -1.2 * mm, 0}, {0, -1.2 * mm, g.face_start}, 1.2 * mm)};
  g.jaw_b = mirrored(g.jaw_a);
  return g;
}

/// Slender jaws that taper and bend to the side.
InstrumentGeometry curved_forceps() {
  InstrumentGeometry g = with_jaws(InstrumentKind::curved_forceps, 20 * mm, 3 * mm, 1.05);
  g.tip_width = 1.6 * mm;
  g.jaw_curve = 1 / (30 * mm);
  const auto along = [&](double z) { return Vec3(g.middle(z), -g.width(z) / 2, z); };
  g.jaw_a.pieces = {capsule({0, -1.5 * mm, 0}, {0, -1.5 * mm, g.face_start}, 1.5 * mm)};
  constexpr int segments = 4;
  for (int k = 0; k < segments; ++k) {
    const double step = (g.jaw_length - g.tip_width / 2 - g.face_start) / segments, z = g.face_start + k * step;
    const double radius = g.width(z + step) / 2;  // the inner face stays in y = 0
    Vec3 from = along(z), to = along(z + step);
    from.y() = to.y() = -radius;
    g.jaw_a.pieces.push_back(capsule(from, to, radius));
  }
  g.jaw_b = mirrored(g.jaw_a);
  return g;
}

InstrumentGeometry clip_applier() {
  InstrumentGeometry g = with_jaws(InstrumentKind::clip_applier, 18 * mm, 2.4 * mm, 0.45);
  g.shaft = tube(5 * mm, -1 * mm);
  const double r = 1.2 * mm;
  g.jaw_a.pieces = {capsule({0, -r, 0}, {0, -r, g.jaw_length - r}, r)};
  g.jaw_b = mirrored(g.jaw_a);
  return g;
}

/// Two flat blades side by side; a lies at −x with its edge on +y, so that the edges shear along x = 0.
InstrumentGeometry scissors() {
  InstrumentGeometry g = with_jaws(InstrumentKind::scissors, 18 * mm, 1.6 * mm, 0.8);
  g.blade_offset = 0.8 * mm;
  g.blade_depth = 3 * mm;
  g.blade_tip_depth = 1.4 * mm;
  g.grip_stiffness = g.face_stiffness = 0;  // they hold nothing
  const double r = 0.4 * mm, edge = g.blade_offset - r, tip = g.jaw_length - r;
  const Vec3 edge_base(-r, edge, 0), edge_tip(-r, edge, tip);
  const Vec3 back_base(-r, g.blade_offset - g.blade_depth + r, 0),
      back_tip(-r, g.blade_offset - g.blade_tip_depth + r, tip);
  g.jaw_a.pieces = {plate(edge_base, edge_tip, back_tip, r), plate(edge_base, back_tip, back_base, r)};
  g.jaw_b = mirrored(g.jaw_a);
  for (RoundedPiece& piece : g.jaw_b.pieces)
    for (Vec3& corner : piece.corners) corner.x() = -corner.x();
  return g;
}

InstrumentGeometry hook() {
  InstrumentGeometry g;
  g.kind = InstrumentKind::hook;
  g.shaft = tube(2.5 * mm, 0);
  g.hook_radius = 0.75 * mm;
  g.hook_heel = {0, 0, 12 * mm};
  g.hook_tip = {0, 4.5 * mm, 12 * mm};
  g.shaft.pieces.push_back(capsule({0, 0, -1 * mm}, g.hook_heel, g.hook_radius));
  g.shaft.pieces.push_back(capsule(g.hook_heel, g.hook_tip, g.hook_radius));
  return g;
}

InstrumentGeometry suction() {
  InstrumentGeometry g;
  g.kind = InstrumentKind::suction;
  g.shaft = tube(2.5 * mm, 0);
  return g;
}

/// Fingers spread in the plane of x and z; the middle one ends in the origin.
InstrumentGeometry fan_retractor() {
  InstrumentGeometry g;
  g.kind = InstrumentKind::fan_retractor;
  const double length = 60 * mm, spread = 0.35, r = 1.75 * mm;
  const Vec3 root(0, 0, -length);
  g.shaft = tube(5 * mm, -length);
  for (const double angle : {-spread, 0.0, spread})
    g.shaft.pieces.push_back(capsule(root, root + (length - r) * Vec3(std::sin(angle), 0, std::cos(angle)), r));
  return g;
}

}  // namespace

double InstrumentGeometry::middle(double z) const {
  const double s = std::clamp(z, face_start, jaw_length) - face_start;
  return jaw_curve * s * s / 2;
}

double InstrumentGeometry::width(double z) const {
  if (jaw_length <= face_start) return jaw_width;
  const double share = (std::clamp(z, face_start, jaw_length) - face_start) / (jaw_length - face_start);
  return jaw_width + share * (tip_width - jaw_width);
}

InstrumentGeometry instrument_geometry(InstrumentKind kind) {
  switch (kind) {
    case InstrumentKind::bowel_grasper:
      return bowel_grasper();
    case InstrumentKind::curved_forceps:
      return curved_forceps();
    case InstrumentKind::clip_applier:
      return clip_applier();
    case InstrumentKind::scissors:
      return scissors();
    case InstrumentKind::hook:
      return hook();
    case InstrumentKind::suction:
      return suction();
    case InstrumentKind::fan_retractor:
      return fan_retractor();
  }
  return {};
}

std::string_view name_of(InstrumentKind kind) {
  switch (kind) {
    case InstrumentKind::bowel_grasper:
      return "bowel grasper";
    case InstrumentKind::curved_forceps:
      return "curved forceps";
    case InstrumentKind::clip_applier:
      return "clip applier";
    case InstrumentKind::scissors:
      return "scissors";
    case InstrumentKind::hook:
      return "hook";
    case InstrumentKind::suction:
      return "suction";
    case InstrumentKind::fan_retractor:
      return "fan retractor";
  }
  return "";
}

double reach_of(const InstrumentGeometry& geometry) {
  return geometry.kind == InstrumentKind::hook ? geometry.hook_heel.z() + geometry.hook_radius : geometry.jaw_length;
}

ArticulatedPoses articulate(const InstrumentGeometry& /*geometry*/, double opening) {
  const auto turned = [](double angle) {
    return Pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitX())), Vec3::Zero()};
  };
  return {Pose{}, turned(opening / 2), turned(-opening / 2)};
}

}  // namespace calot
