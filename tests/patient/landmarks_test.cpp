// Ports, camera, clips and Calot's triangle on anatomies whose answers are known.
#include "calot/patient/landmarks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "tests/patient/synthetic_anatomy.h"
#include "tests/support/files.h"

using namespace calot;
using namespace calot::test;

namespace {

constexpr double mm = 1e-3;

const CompletedAnatomy& whole() {
  static const CompletedAnatomy anatomy = synthetic_anatomy();
  return anatomy;
}
const Landmarks& whole_landmarks() {
  static const Landmarks landmarks = find_landmarks(whole());
  return landmarks;
}

Structure label_at(const CompletedAnatomy& a, const Vec3& p) {
  const Vec3 v = a.labels.grid.to_world.inverse() * p;
  std::array<std::size_t, 3> i{};
  for (std::size_t d = 0; d < 3; ++d) {
    const long rounded = std::lround(v[static_cast<Eigen::Index>(d)]);
    if (rounded < 0 || rounded >= static_cast<long>(a.labels.grid.size[d])) return Structure::none;
    i[d] = static_cast<std::size_t>(rounded);
  }
  return static_cast<Structure>(a.labels.voxels[a.labels.grid.index(i[0], i[1], i[2])]);
}

bool in_the_way(Structure s) {
  return s == Structure::liver || s == Structure::gallbladder || s == Structure::gallbladder_wall;
}

/// The least distance of a point from any organ, over all voxels.
double distance_to_organs(const CompletedAnatomy& a, const Vec3& p) {
  double nearest = 1e9;
  const auto& n = a.labels.grid.size;
  for (std::size_t v = 0; v < a.labels.voxels.size(); ++v) {
    const auto s = static_cast<Structure>(a.labels.voxels[v]);
    if (s == Structure::none || s == Structure::hepatocystic_fat) continue;
    const Vec3 q = a.labels.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                                 static_cast<double>(v / (n[0] * n[1])));
    nearest = std::min(nearest, (q - p).squaredNorm());
  }
  return std::sqrt(nearest);
}

double degrees(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

bool notes_say(const Landmarks& l, const std::string& words) {
  return std::any_of(l.notes.begin(), l.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

Vec3 middle(const CalotTriangle& t) {
  return (t.duct_corner + t.neck_corner + t.liver_corner) / 3;
}

std::vector<TubeSite> sites_of(const std::vector<TubeSite>& all, Structure tube) {
  std::vector<TubeSite> result;
  std::copy_if(all.begin(), all.end(), std::back_inserter(result), [&](const TubeSite& s) { return s.tube == tube; });
  return result;
}

/// Clips and cut of one tube: in order along it, apart, on it.
void expect_sites(const CompletedAnatomy& a, const Landmarks& l, Structure tube, double least_gap) {
  const std::vector<TubeSite> clips = sites_of(l.clips, tube), cuts = sites_of(l.cuts, tube);
  ASSERT_EQ(clips.size(), 3u);
  ASSERT_EQ(cuts.size(), 1u);
  EXPECT_GE(clips[1].arc_length - clips[0].arc_length, least_gap);
  EXPECT_GE(cuts[0].arc_length - clips[1].arc_length, 0.7 * least_gap);
  EXPECT_GE(clips[2].arc_length - cuts[0].arc_length, 0.7 * least_gap);
  const auto line =
      std::find_if(a.lines.begin(), a.lines.end(), [&](const auto& c) { return c.name == name_of(tube); });
  for (const TubeSite& s : {clips[0], clips[1], cuts[0], clips[2]}) {
    double nearest = 1e9;
    for (double arc = 0; arc <= length(*line); arc += 0.05 * mm)
      nearest = std::min(nearest, (place_at(*line, arc).point - s.position).norm());
    EXPECT_LT(nearest, 0.05 * mm) << s.name;
    EXPECT_NEAR(s.direction.norm(), 1, 1e-9);
    EXPECT_GT(s.direction.dot(l.triangle.neck_corner - l.triangle.duct_corner), 0) << "towards the gallbladder";
    EXPECT_NEAR(s.radius, line->radii[0], 1e-12);
    EXPECT_NE(label_at(a, s.position), Structure::gallbladder);
  }
  EXPECT_GT((clips[2].position - clips[0].position).dot(clips[0].direction), 0);
}

TEST(Landmarks, TheTrianglesCornersAreWhereTheTubesMeet) {
  const CalotTriangle& t = whole_landmarks().triangle;
  EXPECT_NEAR(t.duct_corner.norm(), 3.0 * mm, 1 * mm);  // on the bile duct's wall
  const Vec3 along = Vec3(22, 10, 6).normalized();
  EXPECT_LT((t.duct_corner - t.duct_corner.dot(along) * along).norm(), 0.01 * mm);
  EXPECT_NEAR(t.neck_corner.dot(along), 28 * mm, 2.5 * mm);
  EXPECT_LT((t.neck_corner - t.neck_corner.dot(along) * along).norm(), 0.01 * mm);
  const Vec3 in_liver = (t.liver_corner - Vec3(30, -10, 75) * mm).cwiseQuotient(Vec3(78, 70, 60) * mm);
  EXPECT_NEAR(in_liver.norm(), 1, 0.12);  // 1 on the liver's surface; the duct is 2.5 mm thick
  EXPECT_GT(t.liver_corner.z(), t.duct_corner.z() + 5 * mm);
}

TEST(Landmarks, TwoClipsOnThePatientsSideOneOnTheGallbladdersAndTheCutBetween) {
  const Landmarks& l = whole_landmarks();
  expect_sites(whole(), l, Structure::cystic_duct, 3.5 * mm);
  expect_sites(whole(), l, Structure::cystic_artery, 2.2 * mm);
  EXPECT_EQ(l.clips.size(), 6u);
  EXPECT_EQ(l.cuts.size(), 2u);
  const std::vector<TubeSite> duct = sites_of(l.clips, Structure::cystic_duct);
  EXPECT_GT((duct[0].position - l.triangle.duct_corner).norm(), 4.5 * mm) << "away from the bile duct";
  EXPECT_GT((duct[2].position - l.triangle.neck_corner).norm(), 2.5 * mm);
}

TEST(Landmarks, AShortDuctGetsItsClipsCloserAndSaysSo) {
  SyntheticOptions options;
  options.duct_length = 12 * mm;  // 9 mm between the walls
  options.with_artery = false;
  options.voxel = 2 * mm;
  const CompletedAnatomy a = synthetic_anatomy(options);
  const Landmarks l = find_landmarks(a);
  expect_sites(a, l, Structure::cystic_duct, 1.9 * mm);
  EXPECT_EQ(l.clips.size(), 3u);
  EXPECT_TRUE(notes_say(l, "the cystic duct is free over"));
}

TEST(Landmarks, FourPortsOutsideOfEveryOrganOnTheLiftedWall) {
  const Landmarks& l = whole_landmarks();
  ASSERT_EQ(l.ports.size(), 4u);
  const Vec3 target = middle(l.triangle);
  for (const Port& port : l.ports) {
    EXPECT_GT(distance_to_organs(whole(), port.position), 8 * mm) << port.name;
    // The wall's inner side at rest is an ellipse; the gas lifts it by up to 40 mm.
    const double u = (port.position.x() - synthetic_midline) / (165 * mm - synthetic_wall);
    const double rest = -15 * mm + (120 * mm - synthetic_wall) * std::sqrt(1 - u * u);
    EXPECT_GT(port.position.y(), rest - 8 * mm) << port.name;
    EXPECT_LT(port.position.y(), rest + 48 * mm) << port.name;
    EXPECT_TRUE(port.diameter == 5 * mm || port.diameter == 10 * mm);
    for (const Port& other : l.ports) {
      EXPECT_TRUE(&other == &port || (other.position - port.position).norm() > 40 * mm) << port.name;
    }
  }
  const Vec3 camera = l.ports[0].position, epigastric = l.ports[1].position, mid = l.ports[2].position,
             lateral = l.ports[3].position;
  EXPECT_NEAR(camera.x(), synthetic_midline, 3 * mm);
  EXPECT_NEAR(camera.y(), synthetic_skin - synthetic_wall + 40 * mm, 8 * mm);
  EXPECT_GT(epigastric.x(), synthetic_midline + 5 * mm);  // right of the falciform ligament
  EXPECT_LT(epigastric.x(), synthetic_midline + 30 * mm);
  EXPECT_LT(epigastric.x(), mid.x());
  EXPECT_LT(mid.x(), lateral.x());
  EXPECT_GT(epigastric.z(), mid.z());
  EXPECT_GT(mid.z(), camera.z());
  const double angle = degrees(epigastric - target, mid - target);
  EXPECT_GT(angle, 30);
  EXPECT_LT(angle, 90);
  for (const Vec3& working : {epigastric, mid}) {
    EXPECT_GT((working - target).norm(), 100 * mm);
    EXPECT_LT((working - target).norm(), 200 * mm);
  }
}

TEST(Landmarks, TheLaparoscopeSeesTheTriangle) {
  const Landmarks& l = whole_landmarks();
  const CameraPose& camera = l.camera;
  const Vec3 view = camera.target - camera.tip, shaft = camera.tip - l.ports[0].position;
  EXPECT_LT((camera.target - middle(l.triangle)).norm(), 1e-9);
  EXPECT_GE(view.norm(), 50 * mm - 1e-9);
  EXPECT_LE(view.norm(), 110 * mm + 1e-9);
  EXPECT_NEAR(degrees(shaft, view), camera.oblique, 0.01) << "the optic looks to the side by its angle";
  EXPECT_NEAR(camera.up.norm(), 1, 1e-9);
  EXPECT_NEAR(camera.up.dot(view.normalized()), 0, 1e-9);
  EXPECT_GT(camera.up.dot(Vec3(30, -10, 75) * mm - camera.target), 0) << "liver on top";
  EXPECT_GT(distance_to_organs(whole(), camera.tip), 7 * mm);
  for (const Vec3& corner : {l.triangle.duct_corner, l.triangle.neck_corner, l.triangle.liver_corner}) {
    const double length = (corner - camera.tip).norm();
    for (double s = 0; s < length - 6 * mm; s += 0.5 * mm)
      ASSERT_FALSE(in_the_way(label_at(whole(), camera.tip + s / length * (corner - camera.tip))));
  }
  for (const Vec3& corner : {l.triangle.duct_corner, l.triangle.neck_corner, l.triangle.liver_corner})
    EXPECT_LT(degrees(view, corner - camera.tip), camera.field_of_view / 2);
}

TEST(Landmarks, TheWallsThicknessIsMeasured) {
  const Landmarks& l = whole_landmarks();
  EXPECT_TRUE(notes_say(l, "26 mm thick") || notes_say(l, "27 mm thick") || notes_say(l, "28 mm thick"));
}

TEST(Landmarks, AFieldCloseAroundTheOrgansShowsTheFlankAndThatIsEnough) {
  SyntheticOptions options;
  options.whole_body = false;
  const Landmarks l = find_landmarks(synthetic_anatomy(options));
  EXPECT_NEAR(l.ports[0].position.x(), synthetic_midline, 4 * mm);
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_LT((l.ports[p].position - whole_landmarks().ports[p].position).norm(), 25 * mm) << l.ports[p].name;
}

TEST(Landmarks, AFieldThatEndsBeforeTheSkinIsFilledInAndSaidSo) {
  SyntheticOptions options;
  options.whole_body = false;
  options.more_fat = 70 * mm;
  const CompletedAnatomy cropped = synthetic_anatomy(options);
  const Landmarks l = find_landmarks(cropped);
  EXPECT_TRUE(notes_say(l, "the skin isn't in the CT"));
  EXPECT_FALSE(notes_say(whole_landmarks(), "isn't in the CT"));
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_LT((l.ports[p].position - whole_landmarks().ports[p].position).norm(), 40 * mm) << l.ports[p].name;
    EXPECT_GT(distance_to_organs(cropped, l.ports[p].position), 8 * mm);
  }
}

TEST(Landmarks, TheyDontDependOnHowTheVoxelsRunNorWhereLinesStart) {
  SyntheticOptions options;
  options.flipped = options.reversed_lines = true;
  const Landmarks l = find_landmarks(synthetic_anatomy(options));
  const Landmarks& expected = whole_landmarks();
  EXPECT_LT((l.triangle.duct_corner - expected.triangle.duct_corner).norm(), 1 * mm);
  EXPECT_LT((l.triangle.neck_corner - expected.triangle.neck_corner).norm(), 2 * mm);
  EXPECT_LT((l.triangle.liver_corner - expected.triangle.liver_corner).norm(), 2 * mm);
  for (std::size_t s = 0; s < l.clips.size(); ++s)
    EXPECT_LT((l.clips[s].position - expected.clips[s].position).norm(), 2 * mm);
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_LT((l.ports[p].position - expected.ports[p].position).norm(), 12 * mm) << l.ports[p].name;
}

TEST(Landmarks, WhatIsMissingIsNamed) {
  CompletedAnatomy a = whole();
  std::erase_if(a.lines, [](const Centreline& l) { return l.name == "cystic duct"; });
  EXPECT_NE(message_of([&] { find_landmarks(a); }).find("cystic duct"), std::string::npos);
  a = whole();
  std::erase_if(a.lines, [](const Centreline& l) { return l.name == "common bile duct"; });
  EXPECT_EQ(message_of([&] { find_landmarks(a); }), "") << "the hepatic duct is enough";
  std::erase_if(a.lines, [](const Centreline& l) { return l.name == "common hepatic duct"; });
  EXPECT_NE(message_of([&] { find_landmarks(a); }).find("bile duct"), std::string::npos);
  a = whole();
  for (Label& label : a.labels.voxels)
    if (label == label_of(Structure::gallbladder)) label = 0;
  EXPECT_NE(message_of([&] { find_landmarks(a); }).find("gallbladder"), std::string::npos);
}

}  // namespace
