#include "calot/cut/split.h"

#include <gtest/gtest.h>

#include <numbers>

#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/surface.h"
#include "tests/cut/split_scene.h"

namespace calot::test {
namespace {

double surface_area(const TetMesh& mesh) {
  const Surface surface = boundary_surface(mesh);
  double area = 0;
  for (const Triangle& t : surface.triangles)
    area += (surface.positions[t[1]] - surface.positions[t[0]])
                .cross(surface.positions[t[2]] - surface.positions[t[0]])
                .norm() /
            2;
  return area;
}

/// Area of the mesh's section with a plane, tet by tet.
double section_area(const TetMesh& mesh, const Plane& plane) {
  const Vec3 n = plane.normal.normalized();
  double area = 0;
  for (const Tet& tet : mesh.tets) {
    std::vector<Vec3> above, below;
    for (const VertexId v : tet)
      (n.dot(mesh.position(v) - plane.point) > 0 ? above : below).push_back(mesh.position(v));
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < above.size(); ++i)
      for (std::size_t k = 0; k < below.size(); ++k) {
        const Vec3 &a = above[i], &b = below[i % 2 == 1 ? below.size() - 1 - k : k];  // in order around a quadrangle
        points.push_back(a + (b - a) * n.dot(a - plane.point) / n.dot(a - b));
      }
    for (std::size_t i = 2; i < points.size(); ++i)
      area += (points[i - 1] - points[0]).cross(points[i] - points[0]).norm() / 2;
  }
  return area;
}

/// After a transection no part reaches over the plane, and no two parts share a vertex.
void expect_parted(const TetMesh& mesh, const Plane& plane, double reach) {
  const Parts parts = face_connected_parts(mesh);
  const Vec3 n = plane.normal.normalized();
  for (const std::vector<VertexId>& part : parts.vertices) {
    double low = 0, high = 0;
    for (const VertexId v : part) {
      low = std::min(low, n.dot(mesh.position(v) - plane.point));
      high = std::max(high, n.dot(mesh.position(v) - plane.point));
    }
    EXPECT_TRUE(low >= -reach || high <= reach) << low << " " << high;
  }
  EXPECT_TRUE(hinges(mesh, parts).empty());
}

std::vector<TetMesh> meshes_to_cut() {
  return {box_mesh(10, 8, 6, {0.05, 0.04, 0.03}), shaken_box(10, 8, 6, {0.05, 0.04, 0.03}, 3),
          shaken_box(12, 8, 4, {0.012, 0.008, 0.004}, 4), round_bar(30, 6, 0.03, 0.002)};
}

Plane random_plane(const TetMesh& mesh, Random& random) {
  return {mesh.positions[random.below(mesh.vertex_count())] + 0.01 * random_direction(random),
          random_direction(random)};
}

TEST(Split, RandomPlanesPartEveryMesh) {
  Random random(21);
  for (const TetMesh& mesh : meshes_to_cut()) {
    ASSERT_GE(quality(mesh).min_dihedral, 12);
    int cuts = 0;
    for (int i = 0; i < 20; ++i) {
      const Plane plane = random_plane(mesh, random);
      CutScene scene(mesh);
      const SplitReport report = scene.cut(plane);
      if (report.separated == 0) continue;
      ++cuts;
      EXPECT_LE(report.largest_distance, 0.2e-3 + 1e-9);
      EXPECT_GE(report.angle_after, 3);
      EXPECT_GE(quality(scene.mesh).min_dihedral, std::min(3.0, quality(mesh).min_dihedral));
      EXPECT_NEAR(report.volume_change, 0, 1e-4 * scene.total());
      expect_parted(scene.mesh, plane, 0.21e-3);
      // What opened is the section, twice.
      const double opened = surface_area(scene.mesh) - surface_area(mesh), section = section_area(mesh, plane);
      // A section's edge may run within the flatness of the plane's.
      EXPECT_NEAR(opened / 2, section, 0.01 * section + 4 * std::sqrt(section) * 0.2e-3);
    }
    EXPECT_GT(cuts, 8);
  }
}

// The reported angle is that of the mesh, also where it falls short of what was wanted.
TEST(Split, OrganLikeMeshesKeepTheirAngles) {
  const TetMesh mesh = biliary_mesh();
  Random random(5);
  int cuts = 0, short_of = 0;
  for (int i = 0; i < 40; ++i) {
    CutScene scene(mesh);
    const Plane plane = random_plane(mesh, random);
    const SplitReport report = scene.cut(plane);
    if (report.separated == 0) continue;
    ++cuts;
    expect_parted(scene.mesh, plane, 0.21e-3);
    const double smallest = quality(scene.mesh).min_dihedral;
    EXPECT_NEAR(std::min(report.angle_after, quality(mesh).min_dihedral), smallest, 1e-6);
    EXPECT_EQ(report.too_sharp > 0, smallest < 3);
    short_of += smallest < 3 ? 1 : 0;
  }
  EXPECT_GT(cuts, 20);
  EXPECT_LE(short_of, 1);
}

TEST(Split, InTheFacesOfAGridOpensThemAlone) {
  for (const double sign : {1.0, -1.0}) {
    CutScene scene(box_mesh(4, 3, 3, {0.04, 0.03, 0.03}));
    const SplitReport report = scene.cut(Plane{{0.02, 0, 0}, {sign, 0, 0}});
    EXPECT_EQ(report.separated, 2u * 3 * 3);
    EXPECT_EQ(report.copies, 16u);
    EXPECT_EQ(report.snapped + report.bisected + report.taken_as_on, 0u);
    EXPECT_EQ(face_connected_parts(scene.mesh).count(), 2u);
    EXPECT_DOUBLE_EQ(report.largest_distance, 0);
  }
}

TEST(Split, ThroughVerticesAndAlongEdges) {
  const TetMesh mesh = shaken_box(6, 5, 4, {0.03, 0.025, 0.02}, 9);
  Random random(31);
  for (int i = 0; i < 40; ++i) {
    const Tet& tet = mesh.tets[random.below(mesh.tet_count())];
    const Vec3 a = mesh.position(tet[0]), b = mesh.position(tet[1]), c = mesh.position(tet[2]);
    // In a face, along an edge, through a vertex.
    const Vec3 normal = i % 3 == 0   ? Vec3((b - a).cross(c - a))
                        : i % 3 == 1 ? Vec3((b - a).cross(random_direction(random)))
                                     : random_direction(random);
    CutScene scene(mesh);
    const SplitReport report = scene.cut(Plane{a, normal});
    EXPECT_LE(report.largest_distance, 0.2e-3 + 1e-9);
    EXPECT_GE(report.angle_after, 3);
    expect_parted(scene.mesh, {a, normal}, 0.21e-3);
  }
}

TEST(Split, GrazingAndMissingCutNothing) {
  const TetMesh mesh = box_mesh(4, 4, 4, {0.04, 0.04, 0.04});
  for (const Plane& plane :
       {Plane{{0.04, 0, 0}, {1, 0, 0}}, Plane{{0.04 - 1e-4, 0, 0}, {1, 0, 0}}, Plane{{0, 0, 0}, {1, 1, 1}},
        Plane{{0.05, 0, 0}, {1, 0, 0}}, Plane{{0, 0, 0}, {0, 1, 1}}}) {
    const SplitEdit edit = split(mesh, plane);
    EXPECT_TRUE(edit.empty());
    ASSERT_FALSE(edit.report.notes.empty());
    EXPECT_NE(edit.report.notes[0].find("nothing is cut"), std::string::npos);
  }
  const VertexTets around = vertex_tets(mesh);
  EXPECT_TRUE(split(mesh, around, mesh.positions, Sweep{}).empty());
  const Vec3 p(0.02, 0.02, 0.02);
  EXPECT_TRUE(split(mesh, around, mesh.positions, Sweep{{{p, p, p}}}).empty());
}

TEST(Split, APartialCutStaysJoinedAtItsFront) {
  CutScene scene(shaken_box(8, 8, 4, {0.04, 0.04, 0.02}, 2));
  const SplitReport report = scene.cut(BladePatch{{0.02, 0, 0.01}, {1, 0, 0}, {0, 1, 0}, 0.04, 0.05});
  EXPECT_GT(report.separated, 20u);
  EXPECT_GT(report.copies, 5u);
  EXPECT_EQ(face_connected_parts(scene.mesh).count(), 1u);
  EXPECT_FALSE(report.stroke.front.empty());
  // What opened lies inside the patch.
  std::map<std::array<double, 3>, int> places;
  for (const Vec3& p : scene.mesh.positions) ++places[{p.x(), p.y(), p.z()}];
  std::size_t doubled = 0;
  for (const auto& [p, count] : places)
    if (count > 1) {
      ++doubled;
      EXPECT_NEAR(p[0], 0.02, 0.21e-3);
      EXPECT_LT(p[1], 0.02 + 0.3e-3);
    }
  EXPECT_EQ(doubled, report.copies);
}

/// 60 strips through a mesh along y; the blade's edge stands about along z.
void stroke(CutScene& scene, Random& random, double wobble) {
  Vec3 low = scene.mesh.positions[0], high = low;
  for (const Vec3& p : scene.mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double length = high.y() - low.y(), half = high.z() - low.z() + 0.6 * length;
  const Vec3 ahead = Vec3(0.2 * random.between(-1, 1), 1, 0.2 * random.between(-1, 1)).normalized();
  const Vec3 wish(0.2 * random.between(-1, 1), 0, 1);
  const Vec3 along = (wish - wish.dot(ahead) * ahead).normalized();
  Vec3 at((low.x() + high.x()) / 2 + 0.1 * (high.x() - low.x()) * random.between(-1, 1), low.y() - 0.1 * length,
          (low.z() + high.z()) / 2);
  double angle = 0;
  for (int i = 0; i < 60; ++i) {
    angle = std::clamp(angle + wobble * random.between(-1, 1), -3 * wobble, 3 * wobble);
    const Vec3 way = Eigen::AngleAxisd(angle, along) * ahead;
    const Vec3 next = at + 1.3 * length / 60 * way, behind = at - 0.1e-3 * way;
    scene.cut(strip(behind - half * along, behind + half * along, next - half * along, next + half * along));
    at = next;
  }
}

TEST(Split, SixtyStepsTransectADuctAndASlab) {
  for (const double wobble : {0.0, 0.05, 0.15})
    for (int kind = 0; kind < 4; ++kind) {
      Random random(static_cast<std::uint64_t>(100 + kind));
      CutScene scene(kind % 2 == 0 ? round_bar(20, 6, 0.02, 0.002)
                                   : shaken_box(10, 10, 3, {0.02, 0.02, 0.006}, static_cast<std::uint64_t>(kind)));
      stroke(scene, random, wobble);
      const Parts parts = face_connected_parts(scene.mesh);
      EXPECT_EQ(parts.count(), 2u) << wobble << " " << kind;
      EXPECT_TRUE(hinges(scene.mesh, parts).empty());
      EXPECT_LE(scene.farthest, 0.2e-3 + 1e-9);
      EXPECT_GE(scene.smallest, 2.5);
    }
}

TEST(Split, ASecondCutCrossesTheFirstAndAThirdMeetsBoth) {
  Random random(8);
  for (int i = 0; i < 10; ++i) {
    CutScene scene(shaken_box(8, 8, 6, {0.04, 0.04, 0.03}, static_cast<std::uint64_t>(i + 1)));
    const Vec3 centre = Vec3(0.02, 0.02, 0.015) + 0.003 * random_direction(random);
    const auto near = [&](const Vec3& axis) { return (axis + 0.3 * random_direction(random)).normalized(); };
    scene.cut(Plane{centre, near({1, 0, 0})});
    EXPECT_EQ(face_connected_parts(scene.mesh).count(), 2u);
    scene.cut(Plane{centre, near({0, 1, 0})});
    EXPECT_EQ(face_connected_parts(scene.mesh).count(), 4u);
    const Plane third{centre + 0.002 * random_direction(random), near({0, 0, 1})};
    scene.cut(third);
    EXPECT_EQ(face_connected_parts(scene.mesh).count(), 8u);
    expect_parted(scene.mesh, third, 0.21e-3);
    EXPECT_LE(scene.farthest, 0.2e-3 + 1e-9);
    EXPECT_GE(scene.smallest, 2);
  }
}

TEST(Split, CutsWhereTheTissueIsNow) {
  const double length = 0.06;
  const auto twisted = [&](const Vec3& p) -> Vec3 {
    return Vec3(p.x(), 0, 0) + Eigen::AngleAxisd(std::numbers::pi / 2 * p.x() / length, Vec3::UnitX()) *
                                   Vec3(0, p.y() - 0.01, p.z() - 0.01);
  };
  const auto bent = [&](const Vec3& p) -> Vec3 {
    const double radius = 0.04, angle = p.x() / radius;
    return Vec3((radius + p.y()) * std::sin(angle), (radius + p.y()) * std::cos(angle), p.z());
  };
  Random random(6);
  for (int i = 0; i < 12; ++i) {
    CutScene scene(shaken_box(18, 6, 6, {length, 0.02, 0.02}, static_cast<std::uint64_t>(i + 1)));
    if (i % 2 == 0)
      scene.deform(twisted);
    else
      scene.deform(bent);
    const Vec3 at = i % 2 == 0 ? Vec3(0.03, 0, 0) : bent({0.03, 0.01, 0.01});
    const Vec3 across = i % 2 == 0 ? Vec3(1, 0, 0) : (bent({0.031, 0.01, 0.01}) - at).normalized();
    const Vec3 n = (across + 0.4 * random_direction(random)).normalized(), u = n.unitOrthogonal(), v = n.cross(u);
    const double half = 0.03;
    const SplitReport report = scene.cut(
        strip(at - half * u - half * v, at + half * u - half * v, at - half * u + half * v, at + half * u + half * v));
    EXPECT_EQ(face_connected_parts(scene.mesh).count(), 2u);
    EXPECT_LE(report.largest_distance, 0.2e-3 + 1e-9);
    EXPECT_GE(report.angle_after, 3);
    TetMesh moved = scene.mesh;
    moved.positions = scene.now;
    EXPECT_FALSE(validate(moved).fatal()) << validate(moved).describe();
    expect_parted(moved, {at, n}, 0.21e-3);
  }
}

TEST(Split, KeepsToTheRegionAndStaysJoinedToOthers) {
  TetMesh mesh = round_bar(20, 6, 0.02, 0.003, true);
  CutScene whole(mesh), part(mesh);
  const Plane lengthwise{{0.01, 0.0004, 0}, {0.05, 1, 0.1}};
  whole.cut(lengthwise);
  EXPECT_EQ(face_connected_parts(whole.mesh).count(), 2u);
  part.cut(lengthwise, {.region = "near"});
  EXPECT_EQ(face_connected_parts(part.mesh).count(), 1u);
  TetMesh near;
  near.positions = part.mesh.positions;
  for (std::size_t t = 0; t < part.mesh.tet_count(); ++t)
    if (part.mesh.regions[t] == 1) {
      near.tets.push_back(part.mesh.tets[t]);
      near.regions.push_back(1);
    }
  EXPECT_EQ(face_connected_parts(near).count(), 2u);
  EXPECT_THROW(split(mesh, lengthwise, {.region = "spleen"}), InputError);
}

TEST(Split, FixedVerticesStay) {
  const TetMesh mesh = shaken_box(6, 6, 6, {0.03, 0.03, 0.03}, 5);
  const std::vector<std::uint8_t> fixed(mesh.vertex_count(), 1);
  const Plane plane{{0.0152, 0.015, 0.015}, {1, 0.2, 0.1}};
  EXPECT_FALSE(split(mesh, plane).moved.empty());
  const SplitEdit edit = split(mesh, plane, {.fixed = fixed});
  EXPECT_TRUE(edit.moved.empty());
  EXPECT_GT(edit.report.separated, 0u);
}

TEST(Split, TheSameCallGivesTheSameEdit) {
  const TetMesh mesh = shaken_box(8, 6, 4, {0.04, 0.03, 0.02}, 5);
  const Plane plane{{0.021, 0.015, 0.01}, {1, 0.3, 0.2}};
  const SplitEdit a = split(mesh, plane), b = split(mesh, plane);
  EXPECT_EQ(a.removed, b.removed);
  ASSERT_EQ(a.tets.size(), b.tets.size());
  for (std::size_t i = 0; i < a.tets.size(); ++i) EXPECT_EQ(a.tets[i].vertices, b.tets[i].vertices);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) EXPECT_EQ(a.vertices[i].position, b.vertices[i].position);
}

TEST(Split, SweepingAgainOpensNothingMore) {
  CutScene scene(shaken_box(8, 6, 4, {0.04, 0.03, 0.02}, 5));
  const Plane plane{{0.021, 0.015, 0.01}, {1, 0.3, 0.2}};
  scene.cut(plane);
  const std::size_t parts = face_connected_parts(scene.mesh).count();
  const SplitReport again = scene.cut(plane);
  EXPECT_EQ(again.separated, 0u);
  EXPECT_EQ(face_connected_parts(scene.mesh).count(), parts);
}

// Anything goes: short and long patches, anywhere, one after another, each mesh cut until little is left of it.
TEST(Split, FiveHundredRandomSweeps) {
  Random random(77);
  std::size_t opened = 0;
  for (int mesh = 0; mesh < 25; ++mesh) {
    CutScene scene(shaken_box(5, 5, 4, {0.025, 0.025, 0.02}, static_cast<std::uint64_t>(mesh + 1)));
    for (int i = 0; i < 20; ++i) {
      const Vec3 at(random.between(0, 0.025), random.between(0, 0.025), random.between(0, 0.02));
      const Vec3 u = random_direction(random), v = u.cross(random_direction(random)).normalized();
      const double a = random.between(0.001, 0.02), b = random.between(0.0005, 0.01);
      scene.cut(strip(at - a * u, at + a * u, at - a * u + b * v, at + a * u + b * v));
      if (i % 4 == 3) scene.stroke = {};
    }
    opened += scene.separated;
  }
  EXPECT_GT(opened, 1500u);
}

TEST(Split, RefusesBadInput) {
  const TetMesh mesh = regular_tet(0.01);
  const VertexTets around = vertex_tets(mesh);
  const Plane plane{{0, 0, 0}, {1, 0, 0}};
  EXPECT_THROW(split(mesh, plane, {.flatness = 0}), InputError);
  EXPECT_THROW(split(mesh, plane, {.margin = -1}), InputError);
  EXPECT_THROW(split(mesh, plane, {.smallest_angle = NAN}), InputError);
  EXPECT_THROW(split(mesh, plane, {.fixed = std::vector<std::uint8_t>(3)}), InputError);
  EXPECT_THROW(split(mesh, Plane{{0, 0, 0}, {0, 0, 0}}), InputError);
  const Stroke unknown{{VertexId(9)}, {}};
  EXPECT_THROW(split(mesh, plane, {.stroke = &unknown}), InputError);
  const Vec3 o = Vec3::Zero(), x(1, 0, 0), bad(0, NAN, 0);
  EXPECT_THROW(split(mesh, around, mesh.positions, Sweep{{{o, x, bad}}}), InputError);
  EXPECT_THROW(split(mesh, around, std::vector<Vec3>(3, o), Sweep{}), InputError);
}

}  // namespace
}  // namespace calot::test
