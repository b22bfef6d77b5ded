#include "calot/sim/hook.h"

#include <gtest/gtest.h>

namespace calot {
namespace {

constexpr double mm = 1e-3;

/// A plate of two triangles at this height z, 40 × 40 mm.
struct Plate {
  explicit Plate(double z)
      : positions{{-20 * mm, -20 * mm, z}, {20 * mm, -20 * mm, z}, {20 * mm, 20 * mm, z}, {-20 * mm, 20 * mm, z}} {}
  [[nodiscard]] TissueSurface surface() const { return {triangles, positions}; }
  std::vector<Vec3> positions;
  std::vector<std::array<VertexId, 3>> triangles{{VertexId(0), VertexId(1), VertexId(2)},
                                                 {VertexId(0), VertexId(2), VertexId(3)}};
};

const InstrumentGeometry& geometry() {
  static const InstrumentGeometry g = instrument_geometry(InstrumentKind::hook);
  return g;
}

TEST(Hook, LiesOnTissueWithItsWholeFoot) {
  const Plate plate(12 * mm + geometry().hook_radius);
  const std::optional<HookContact> contact = hook_contact(geometry(), {}, plate.surface());
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->length, 4.5 * mm, 1e-9);
  EXPECT_NEAR(contact->gap, 0, 1e-12);
  EXPECT_NEAR(contact->place.z(), 12 * mm + geometry().hook_radius, 1e-12);
  EXPECT_NEAR(contact->place.y(), 2.25 * mm, 1e-9);
  EXPECT_NEAR(contact->radius, 2.25 * mm, 1e-9);
  EXPECT_NEAR(contact->nearest.weights.sum(), 1, 1e-12);
}

TEST(Hook, TouchesWithItsTipAloneWhenTilted) {
  const Pose tilted{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3::UnitX())), Vec3::Zero()};
  const Vec3 tip = tilted * geometry().hook_tip;
  const Plate plate(tip.z() + geometry().hook_radius);
  const std::optional<HookContact> contact = hook_contact(geometry(), tilted, plate.surface(), 0.1 * mm);
  ASSERT_TRUE(contact.has_value());
  EXPECT_LT(contact->length, 0.5 * mm);
  EXPECT_EQ(contact->radius, geometry().hook_radius);
  EXPECT_NEAR(contact->end.y(), tip.y(), 1e-12);
}

TEST(Hook, TouchesNothingOutOfReach) {
  const Plate plate(14 * mm);
  EXPECT_FALSE(hook_contact(geometry(), {}, plate.surface()).has_value());
  EXPECT_THROW(hook_contact(instrument_geometry(InstrumentKind::suction), {}, plate.surface()), std::runtime_error);
}

}  // namespace
}  // namespace calot
