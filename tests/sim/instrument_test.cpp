#include "calot/sim/instrument.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

TEST(Articulate, OpensBothJawsByHalfTheAngle) {
  const ArticulatedPoses poses = articulate({}, 0.6);
  const Vec3 a = poses.jaw_a * Vec3(0, 0, 0.02), b = poses.jaw_b * Vec3(0, 0, 0.02);
  EXPECT_NEAR(std::acos(a.dot(b) / (a.norm() * b.norm())), 0.6, 1e-12);
  EXPECT_EQ(poses.shaft * Vec3(1, 2, 3), Vec3(1, 2, 3));
}

TEST(InstrumentGeometry, EveryInstrumentGoesThroughItsPort) {
  for (const InstrumentKind kind :
       {InstrumentKind::bowel_grasper, InstrumentKind::curved_forceps, InstrumentKind::clip_applier,
        InstrumentKind::scissors, InstrumentKind::hook, InstrumentKind::suction, InstrumentKind::fan_retractor}) {
    const InstrumentGeometry g = instrument_geometry(kind);
    const double port = kind == InstrumentKind::clip_applier ? 5e-3 : 2.5e-3;
    ASSERT_FALSE(g.shaft.pieces.empty()) << name_of(kind);
    double far = 0;
    for (const RigidShape* shape : {&g.jaw_a, &g.jaw_b})
      for (const RoundedPiece& piece : shape->pieces)
        for (int k = 0; k < piece.corner_count; ++k) {
          const Vec3& corner = piece.corners[static_cast<std::size_t>(k)];
          far = std::max(far, corner.z() + piece.radius);
          // Curved jaws reach aside: they go through on the bend.
          if (g.jaw_curve == 0) {
            EXPECT_LE(std::hypot(corner.x(), corner.y()) + piece.radius, port + 0.35e-3) << name_of(kind);
          }
        }
    if (g.has_jaws()) {
      EXPECT_NEAR(far, g.jaw_length, 0.2e-3) << name_of(kind);
    }
    EXPECT_EQ(g.jaw_a.pieces.size(), g.jaw_b.pieces.size());
  }
}

TEST(InstrumentGeometry, ClosedJawsMeetInThePlaneBetweenThem) {
  for (const InstrumentKind kind :
       {InstrumentKind::bowel_grasper, InstrumentKind::curved_forceps, InstrumentKind::clip_applier}) {
    const InstrumentGeometry g = instrument_geometry(kind);
    for (const RoundedPiece& piece : g.jaw_a.pieces)
      for (int k = 0; k < piece.corner_count; ++k)
        EXPECT_NEAR(piece.corners[static_cast<std::size_t>(k)].y() + piece.radius, 0, 1e-12) << name_of(kind);
  }
  const InstrumentGeometry blades = instrument_geometry(InstrumentKind::scissors);
  double edge = -1;
  for (const RoundedPiece& piece : blades.jaw_a.pieces)
    for (const Vec3& corner : piece.corners) {
      edge = std::max(edge, corner.y() + piece.radius);
      EXPECT_LE(corner.x() + piece.radius, 1e-12);  // side by side
    }
  EXPECT_NEAR(edge, blades.blade_offset, 1e-12);
}

}  // namespace
}  // namespace calot
