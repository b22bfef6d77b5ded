#include "calot/contact/detect.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <numbers>
#include <set>

#include "calot/base/parallel.h"
#include "calot/contact/simplex_distance.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

using namespace test;

Vec3 random_direction(Random& random) {
  while (true) {
    const Vec3 d(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    if (d.norm() > 0.1 && d.norm() < 1) return d.normalized();
  }
}

/// A round duct along x, 3 mm thick and 30 mm long, centred at the origin.
TetMesh duct(int around = 4, double radius = 1.5e-3) {
  TetMesh mesh = box_mesh(24, around, around, {0.03, 2, 2});
  for (Vec3& p : mesh.positions) {
    // A square turned into a disc ring by ring.
    const Eigen::Vector2d square(p.y() - 1, p.z() - 1);
    const double ring = square.cwiseAbs().maxCoeff();
    const Eigen::Vector2d round = ring > 0 ? Eigen::Vector2d(square.normalized() * ring * radius) : square;
    p = {p.x() - 0.015, round.x(), round.y()};
  }
  return mesh;
}

RigidShape rod(double radius, double length) {
  RigidShape shape;
  shape.pieces.push_back({{Vec3(0, 0, -length / 2), Vec3(0, 0, length / 2), Vec3::Zero()}, 2, radius});
  return shape;
}
RigidShape ball(double radius) {
  RigidShape shape;
  shape.pieces.push_back({{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, 1, radius});
  return shape;
}
MovingShape moved(const RigidShape& shape, const Vec3& from, const Vec3& to) {
  MovingShape moving{&shape, {}, {}, 0.2};
  moving.from.position = from;
  moving.to.position = to;
  return moving;
}
std::vector<TissueContact> detect_shapes(const TetMesh& mesh, std::vector<MovingShape> shapes,
                                         ContactOptions options = {}) {
  ContactSurface surface(mesh);
  return detect(surface, mesh.positions, {}, {shapes, {}}, options);
}
/// The gap at the step's end while the tissue stays.
double ending(const TissueContact& c) {
  return c.gap - c.normal.dot(c.partner_motion);
}

TEST(Detect, BallOverAFlatBlock) {
  const TetMesh mesh = box_mesh(6, 6, 3, {0.06, 0.06, 0.03});
  const RigidShape shape = ball(0.004);
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    const Vec3 above(random.between(0.01, 0.05), random.between(0.01, 0.05),
                     0.03 + 0.004 + random.between(-0.003, 1e-3));
    const auto contacts = detect_shapes(mesh, {moved(shape, above, above)});
    ASSERT_FALSE(contacts.empty());
    const TissueContact& c = contacts.front();
    EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(c.gap, above.z() - 0.034, 1e-12);
    EXPECT_LT((c.place - (above - Vec3(0, 0, 0.004))).norm(), 1e-9);
    EXPECT_NEAR(c.point.weights.sum(), 1, 1e-12);
  }
  const Vec3 far(0.03, 0.03, 0.0361);
  EXPECT_TRUE(detect_shapes(mesh, {moved(shape, far, far)}).empty());
}

TEST(Detect, LyingRodTouchesAtSpreadPoints) {
  const TetMesh mesh = box_mesh(6, 6, 3, {0.06, 0.06, 0.03});
  const RigidShape shape = rod(0.0025, 0.02);
  MovingShape lying = moved(shape, {0.031, 0.029, 0.0325}, {0.031, 0.029, 0.0322});
  lying.from.rotation = lying.to.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3(1, 0.3, 0).normalized()));
  const auto contacts = detect_shapes(mesh, {lying});
  ASSERT_GE(contacts.size(), 3u);
  double reach = 0;
  for (const auto& c : contacts) {
    EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 1e-6);
    EXPECT_NEAR(c.gap, 0, 1e-9);
    EXPECT_NEAR(ending(c), -0.3e-3, 1e-9);
    for (const auto& d : contacts) reach = std::max(reach, (c.place - d.place).norm());
  }
  EXPECT_GT(reach, 0.015);
}

TEST(Detect, PlateTouchesAtSpreadPointsEvenInsideOneTriangle) {
  const TetMesh mesh = box_mesh(1, 1, 1, {0.06, 0.06, 0.03});
  RigidShape plate;
  plate.pieces.push_back({{Vec3(0, 0, 0), Vec3(0.008, 0, 0), Vec3(0, 0.008, 0)}, 3, 0.001});
  const auto contacts = detect_shapes(mesh, {moved(plate, {0.04, 0.01, 0.0311}, {0.04, 0.01, 0.0309})});
  EXPECT_EQ(contacts.size(), 3u);
  for (const auto& c : contacts) EXPECT_NEAR(c.gap, 0.1e-3, 1e-9);
}

TEST(Detect, SlidingOverFlatTrianglesMeetsNoEdges) {
  const TetMesh mesh = box_mesh(12, 12, 3, {0.06, 0.06, 0.03});
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    const RigidShape shape = n % 2 == 0 ? ball(0.0025) : rod(0.0025, 0.01);
    const Vec3 from(random.between(0.02, 0.04), random.between(0.02, 0.04), 0.0325 + random.between(0, 2e-4));
    const double angle = random.between(0, 6.28);
    MovingShape moving = moved(shape, from, from + 0.0083 * Vec3(std::cos(angle), std::sin(angle), 0));
    moving.from.rotation = moving.to.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(random.between(0, 3), Vec3::UnitZ())) *
        Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
    for (const auto& c : detect_shapes(mesh, {moving})) EXPECT_GT(ending(c), -3e-5) << n;
  }
}

TEST(Detect, NoToolPassesThroughADuct) {
  // 0.5 m/s at 60 Hz, with and without turning; thick tools and the thinnest.
  const TetMesh mesh = duct();
  ContactSurface surface(mesh);
  Random random(3);
  const double travel = 0.5 / 60;
  int crossing = 0, missing = 0;
  for (int n = 0; n < 1500; ++n) {
    const double radius = std::array{0.0025, 0.001, 0.0005}[n % 3];
    const RigidShape shape = n % 4 == 3 ? ball(radius) : rod(radius, 0.03);
    MovingShape moving = moved(shape, Vec3::Zero(), Vec3::Zero());
    const Vec3 way = random_direction(random);
    const double aside = n % 3 == 0 ? 6e-3 : 2e-3;
    const Vec3 through(random.between(-0.01, 0.01), random.between(-aside, aside), random.between(-aside, aside));
    moving.from.position = through - way * random.between(0.2, 0.9) * travel;
    moving.to.position = moving.from.position + way * travel;
    moving.from.rotation = moving.to.rotation =
        Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), random_direction(random));
    if (n % 2 == 1)
      moving.to.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(random.between(-0.4, 0.4), random_direction(random))) *
                           moving.from.rotation;
    // Judge: how near the core comes to the duct's axis, sampled finely.
    const Vec3 a0(-0.015, 0, 0), a1(0.015, 0, 0);
    double nearest = 1, start = 1;
    for (int k = 0; k <= 200; ++k) {
      const Pose pose = pose_between(moving.from, moving.to, k / 200.0);
      const auto& p = shape.pieces[0];
      const Vec3 p0 = pose * p.corners[0], p1 = pose * p.corners[p.corner_count - 1];
      const auto [s, t] = detail::closest_on_segments(p0, p1, a0, a1);
      const double d = (p0 + s * (p1 - p0) - a0 - t * (a1 - a0)).norm() - radius - 1.5e-3;
      if (k == 0) start = d;
      nearest = std::min(nearest, d);
    }
    if (start < 1e-4) continue;
    const std::vector<MovingShape> shapes{moving};
    const auto contacts = detect(surface, mesh.positions, {}, {shapes, {}}, {});
    double least = 1;
    for (const auto& c : contacts) {
      least = std::min(least, ending(c));
      EXPECT_TRUE(c.normal.allFinite());
      EXPECT_NEAR(c.normal.norm(), 1, 1e-9);
    }
    if (nearest < -3e-4) {
      ++crossing;
      // The condition takes tissue along, by at least some of what it is overrun.
      EXPECT_LT(least, 0) << n << " radius " << radius << " overlap " << nearest << " contacts " << contacts.size();
    }
    if (nearest > 2e-4) {
      ++missing;
      EXPECT_GT(least, -1e-5) << n << " distance " << nearest;
    }
  }
  EXPECT_GT(crossing, 400);
  EXPECT_GT(missing, 50);
}

TEST(Detect, TissueThatWouldRunOverAToolMeetsItWithItsNearSideOnly) {
  const TetMesh mesh = box_mesh(10, 6, 2, {0.02, 0.012, 0.004});
  ContactSurface surface(mesh);
  RigidShape rod;
  rod.pieces = {{{Vec3(-0.01, 0, 0), Vec3(0.01, 0, 0), Vec3::Zero()}, 2, 0.8e-3}};
  const Pose pose{Eigen::Quaterniond::Identity(), Vec3(0.01, 0.006, -0.003)};
  for (const double fall : {0.003, 0.005, 0.0065, 0.007, 0.0075, 0.009, 0.015, 0.03}) {
    const std::vector<Vec3> falling(mesh.vertex_count(), Vec3(0, 0, -fall));
    const std::vector<MovingShape> shapes{{&rod, pose, pose, 0.1}};
    const auto contacts = detect(surface, mesh.positions, falling, {shapes, {}}, {});
    EXPECT_FALSE(contacts.empty()) << fall;
    for (const TissueContact& contact : contacts) {
      EXPECT_NEAR(contact.gap, 2.2e-3, 1e-6) << fall;
      EXPECT_GT(contact.normal.z(), 0.99) << fall;
    }
  }
}

TEST(Detect, AToolInsideTissueIsShownTheNearestWayOut) {
  const TetMesh mesh = box_mesh(6, 6, 3, {0.06, 0.06, 0.03});
  const RigidShape shape = ball(0.001);
  const Vec3 inside(0.03, 0.031, 0.026);
  const auto contacts = detect_shapes(mesh, {moved(shape, inside, inside)});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].normal + Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(contacts[0].gap, -0.005, 1e-12);
  // In the duct, beside its axis: out sideways.
  const TetMesh tube = duct();
  const RigidShape thin = ball(0.0003);
  const auto out = detect_shapes(tube, {moved(thin, {0, 0, 0.8e-3}, {0, 0, 0.8e-3})});
  ASSERT_FALSE(out.empty());
  EXPECT_LT((out[0].normal + Vec3::UnitZ()).norm(), 0.3);  // of a duct with sixteen sides
  EXPECT_LT(out[0].gap, -0.7e-3);
  EXPECT_GT(out[0].gap, -1.2e-3);
}

/// A block of two halves that touch at x = 10 mm and share no vertex there.
TetMesh separated_block() {
  TetMesh mesh = cell_mesh(4, 3, 3, {0.02, 0.012, 0.012}, [](int i, int, int) { return i < 2 ? 1 : 2; });
  const std::size_t n = mesh.vertex_count();
  std::vector<VertexId> twin(n);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (VertexId& v : mesh.tets[t]) {
      if (mesh.regions[t] != 2 || std::abs(mesh.position(v).x() - 0.01) > 1e-9) continue;
      if (!twin[v.index()].valid()) {
        twin[v.index()] = VertexId(mesh.vertex_count());
        mesh.positions.push_back(mesh.position(v));
      }
      v = twin[v.index()];
    }
  return mesh;
}

TEST(Detect, FreshlySeparatedFacesRestAgainstEachOther) {
  const TetMesh mesh = separated_block();
  for (const double shift : {0.0, 0.4e-3, -0.4e-3}) {
    std::vector<Vec3> positions = mesh.positions;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
      for (const VertexId v : mesh.tets[t])
        if (mesh.regions[t] == 2) positions[v.index()].x() = mesh.position(v).x() + shift;
    ContactSurface surface(mesh);
    const auto contacts = detect(surface, positions, {}, {}, {});
    ASSERT_GE(contacts.size(), 4u) << shift;
    double reach = 0;
    for (const auto& c : contacts) {
      EXPECT_EQ(c.partner, ContactPartner::tissue);
      EXPECT_NEAR(std::abs(c.normal.x()), 1, 1e-9);
      EXPECT_NEAR(c.gap, shift, 1e-12);
      // The normal leads from the partner to the tissue: towards +x for the right half.
      EXPECT_EQ(c.normal.x() > 0, mesh.regions[c.point.tet.index()] == 2);
      EXPECT_NE(mesh.regions[c.point.tet.index()], mesh.regions[c.other.tet.index()]);
      for (const auto& d : contacts) reach = std::max(reach, (c.place - d.place).norm());
    }
    EXPECT_GT(reach, 0.01);
  }
}

TEST(Detect, TissueThatOnlyBendsOrIsSqueezedDoesNotTouchItself) {
  TetMesh mesh = biliary_mesh();
  ContactSurface surface(mesh);
  std::vector<Vec3> positions = mesh.positions;
  for (Vec3& p : positions) p.y() += 0.004 * std::sin(60 * p.x());
  EXPECT_TRUE(detect(surface, positions, {}, {}, {}).empty());
  // A sheet 1.5 mm thick, pressed to 0.6 mm: its two sides aren't in contact through the tissue.
  const TetMesh sheet = box_mesh(10, 10, 1, {0.03, 0.03, 0.0015});
  ContactSurface thin(sheet);
  positions = sheet.positions;
  for (Vec3& p : positions) p.z() *= 0.4;
  EXPECT_TRUE(detect(thin, positions, {}, {}, {}).empty());
}

TEST(Detect, AnEdgeThatJawsSqueezeToALipDoesNotTouchItself) {
  const TetMesh mesh = box_mesh(6, 6, 2, {0.012, 0.012, 0.004});
  ContactSurface surface(mesh);
  // Top and bottom of the free edge flow out over its middle: the upper half of the edge's face then looks down, a
  // millimetre or two below the top, which looks up.
  for (const double flow : {0.5e-3, 1.0e-3, 1.5e-3, 2.5e-3}) {
    std::vector<Vec3> squeezed = mesh.positions;
    for (Vec3& p : squeezed) {
      const double share = std::max(0.0, (p.x() - 0.006) / 0.006);
      const double height = (p.z() - 0.002) / 0.002;
      p.z() -= 0.7e-3 * share * height;
      p.x() += share * (height == 0 ? -flow : flow);
    }
    EXPECT_TRUE(detect(surface, squeezed, {}, {}, {}).empty()) << flow;
  }
}

/// A block with a wedge opened down to its middle: triangles of the crease's two sides that an edge joins don't touch,
/// also where it is pressed together; farther out, where the sides meet, they do.
TEST(Detect, SidesOfACreaseTouchOnlyAwayFromIt) {
  const double slope = 0.1;
  TetMesh mesh = box_mesh(8, 2, 8, {0.016, 0.004, 0.016});
  // Above half height the halves are parted at x = 8 mm and drawn to both sides by the slope.
  std::vector<VertexId> twin(mesh.vertex_count(), VertexId::none());
  const std::size_t count = mesh.vertex_count();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    double x = 0;
    for (const VertexId v : mesh.tets[t]) x += mesh.position(v).x() / 4;
    if (x < 0.008) continue;
    for (VertexId& v : mesh.tets[t]) {
      if (v.index() >= count || std::abs(mesh.position(v).x() - 0.008) > 1e-9 || mesh.position(v).z() < 0.0081)
        continue;
      if (!twin[v.index()].valid()) {
        twin[v.index()] = VertexId(mesh.vertex_count());
        mesh.positions.push_back(mesh.position(v));
      }
      v = twin[v.index()];
    }
  }
  const auto drawn = [&](double by) {
    std::vector<Vec3> positions = mesh.positions;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const double height = mesh.positions[v].z() - 0.008;
      const bool right = v >= count || mesh.positions[v].x() > 0.0081;
      if (height > 0) positions[v].x() += (right ? by : -by) * height;
    }
    return positions;
  };
  TetMesh creased = mesh;
  creased.positions = drawn(slope);
  ContactSurface surface(creased);
  std::set<std::pair<VertexId, VertexId>> joined;
  for (const ContactTriangle& t : surface.triangles())
    for (const VertexId a : t.vertices)
      for (const VertexId b : t.vertices) joined.insert({a, b});
  for (const double by : {slope, 0.05, 0.01}) {
    const auto contacts = detect(surface, drawn(by), {}, {}, {});
    ASSERT_FALSE(contacts.empty()) << by;
    double high = 0;
    for (const auto& c : contacts) {
      high = std::max(high, c.place.z());
      for (const VertexId a : c.point.vertices)
        for (const VertexId b : c.other.vertices) EXPECT_FALSE(joined.contains({a, b})) << by << " " << c.place.z();
    }
    EXPECT_GT(high, by < slope ? 0.0139 : 0.0099) << by;
  }
}

TEST(Detect, AFoldedStripTouchesItself) {
  // Bent half round with an inner radius of 0.3 mm: its ends face each other 0.6 mm apart.
  const double thickness = 0.002, inner = 0.3e-3, middle = 0.03, bend = std::numbers::pi * (inner + thickness / 2);
  const TetMesh strip = box_mesh(60, 4, 1, {0.06, 0.008, thickness});
  std::vector<Vec3> positions = strip.positions;
  for (Vec3& p : positions) {
    const double along = p.x() - middle, height = p.z();  // the top becomes the inside
    const double r = inner + thickness - height;
    const double angle = std::clamp(along / bend, -0.5, 0.5) * std::numbers::pi;
    const double straight = std::max(0.0, std::abs(along) - bend / 2);
    p = Vec3(-straight, p.y(), r * std::sin(angle)) + Vec3(r * std::cos(angle), 0, 0);
  }
  ContactSurface surface(strip);
  const auto contacts = detect(surface, positions, {}, {}, {});
  int across = 0;
  for (const auto& c : contacts) {
    if (c.place.x() > -0.002) continue;
    ++across;
    EXPECT_NEAR(c.gap, 2 * inner, 1e-9);
    EXPECT_NEAR(std::abs(c.normal.z()), 1, 1e-9);
  }
  EXPECT_GT(across, 6);
}

Surface sheet_at(double z) {
  Surface sheet;
  sheet.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  return sheet;
}

TEST(Detect, StillSurfaces) {
  const TetMesh mesh = box_mesh(4, 4, 3, {0.02, 0.02, 0.012});
  ContactSurface surface(mesh);
  std::vector<StillSurface> floor;
  floor.emplace_back(sheet_at(-0.3e-3), 0.4, false);
  auto contacts = detect(surface, mesh.positions, {}, {{}, floor}, {});
  ASSERT_GE(contacts.size(), 4u);
  for (const auto& c : contacts) {
    EXPECT_EQ(c.partner, ContactPartner::still);
    EXPECT_LT((c.normal - Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(c.gap, 0.3e-3, 1e-12);
    EXPECT_EQ(c.friction, 0.4);
  }
  // A lid seen from below holds only as a sheet with two sides.
  std::vector<StillSurface> lid;
  lid.emplace_back(sheet_at(0.0122), 0.4, false);
  EXPECT_TRUE(detect(surface, mesh.positions, {}, {{}, lid}, {}).empty());
  lid.clear();
  lid.emplace_back(sheet_at(0.0122), 0.4, true);
  contacts = detect(surface, mesh.positions, {}, {{}, lid}, {});
  ASSERT_GE(contacts.size(), 4u);
  for (const auto& c : contacts) {
    EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(c.gap, 0.2e-3, 1e-12);
  }
}

TEST(Detect, FastTissueMeetsAStillSurfaceBeforeItPasses) {
  const TetMesh mesh = box_mesh(4, 4, 3, {0.02, 0.02, 0.012});
  ContactSurface surface(mesh);
  std::vector<StillSurface> floor;
  floor.emplace_back(sheet_at(-0.005), 0.4, false);
  const std::vector<Vec3> falling(mesh.vertex_count(), Vec3(0, 0, -0.009));
  const auto contacts = detect(surface, mesh.positions, falling, {{}, floor}, {});
  ASSERT_GE(contacts.size(), 4u);
  for (const auto& c : contacts) EXPECT_NEAR(c.gap, 0.005, 1e-12);
}

TEST(Detect, ManyContactsAreThinnedOutStably) {
  const TetMesh mesh = box_mesh(20, 20, 3, {0.06, 0.06, 0.01});
  ContactSurface surface(mesh);
  std::vector<StillSurface> floor;
  floor.emplace_back(sheet_at(0), 0.4, false);
  ContactOptions options;
  options.max_contacts = 12;
  const auto contacts = detect(surface, mesh.positions, {}, {{}, floor}, options);
  EXPECT_LE(contacts.size(), 12u);
  EXPECT_GE(contacts.size(), 5u);
  Eigen::AlignedBox3d box;
  for (const auto& c : contacts) box.extend(c.place);
  EXPECT_GT(box.sizes().x(), 0.03);
  EXPECT_GT(box.sizes().y(), 0.03);
}

TEST(Detect, SameBytesOnAnyNumberOfThreadsAndKeysStay) {
  const TetMesh mesh = biliary_mesh();
  const RigidShape shape = rod(0.0025, 0.03);
  const auto run = [&](double down) {
    const Vec3 at(0.045, 0.036 - down, 0.035);
    std::vector<MovingShape> shapes{moved(shape, at, at - Vec3(0, 0.003, 0))};
    ContactSurface surface(mesh);
    return detect(surface, mesh.positions, {}, {shapes, {}}, {});
  };
  const int threads = thread_count();
  const auto one = run(0);
  ASSERT_FALSE(one.empty());
  for (const int count : {1, 2, 4}) {
    set_thread_count(count);
    const auto again = run(0);
    ASSERT_EQ(again.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(again[i].key, one[i].key);
      EXPECT_EQ(std::memcmp(&again[i].gap, &one[i].gap, sizeof(double)), 0);
      EXPECT_EQ(again[i].normal, one[i].normal);
      EXPECT_EQ(again[i].place, one[i].place);
    }
  }
  set_thread_count(threads);
  // A tool that moved a hair touches the same features.
  const auto next = run(1e-6);
  std::size_t same = 0;
  for (const auto& c : next)
    for (const auto& d : one) same += c.key == d.key ? 1 : 0;
  EXPECT_GE(2 * same, one.size());
}

TEST(Detect, BadInputIsRefused) {
  const TetMesh mesh = box_mesh(1, 1, 1, {1, 1, 1});
  EXPECT_NE(message_of([&] { detect_shapes(mesh, {MovingShape{}}); }), "");
  RigidShape sharp = ball(0);
  EXPECT_NE(message_of([&] { detect_shapes(mesh, {moved(sharp, {2, 2, 2}, {2, 2, 2})}); }), "");
  ContactSurface surface(mesh);
  const std::vector<Vec3> few(3, Vec3::Zero());
  EXPECT_NE(message_of([&] { detect(surface, few, {}, {}, {}); }), "");
  Surface broken = sheet_at(0);
  broken.triangles.push_back({0, 1, 9});
  EXPECT_NE(message_of([&] { StillSurface(broken, 0.1, false); }), "");
}

}  // namespace
}  // namespace calot
