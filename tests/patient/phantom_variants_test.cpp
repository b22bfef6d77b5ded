// Each variant has what it is named for, measured on lines and voxels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calot/image/voxel_parts.h"
#include "calot/patient/phantom.h"
#include "calot/patient/sweep.h"

namespace calot {
namespace {

Phantom phantom_of(std::uint64_t seed, PhantomVariant variant) {
  PhantomOptions options;
  options.seed = seed;
  options.variant = variant;
  options.voxel = 1e-3;
  Progress silent;
  return make_phantom(options, silent);
}

const Centreline& line_of(const Phantom& phantom, Structure s) {
  return *std::find_if(phantom.lines.begin(), phantom.lines.end(),
                       [&](const Centreline& line) { return line.name == name_of(s); });
}

std::size_t voxels_of(const Phantom& phantom, Structure s) {
  const auto counts = voxel_counts(phantom.labels);
  const auto found = counts.find(label_of(s));
  return found == counts.end() ? 0 : found->second;
}

void expect_whole(const Phantom& phantom) {
  std::vector<std::uint8_t> regions(phantom.labels.voxels.begin(), phantom.labels.voxels.end());
  const auto parts = keep_largest_parts(regions, phantom.labels.grid.size, all_structures().size());
  for (std::size_t p = 0; p < parts.size(); ++p) EXPECT_EQ(parts[p].specks, 0u) << "label " << p + 1;
  for (const auto& [label, count] : voxel_counts(phantom.labels))
    EXPECT_EQ(phantom.labels.names.at(label), name_of(static_cast<Structure>(label)));
}

/// Length of the cystic duct's line outside the bile duct.
double free_length(const Phantom& phantom) {
  const Curve& line = line_of(phantom, Structure::cystic_duct).points;
  double sum = 0;
  for (std::size_t p = 1; p < line.size(); ++p) {
    const Vec3 middle = (line[p] + line[p - 1]) / 2;
    double gap = 1;
    for (const Structure s : {Structure::common_bile_duct, Structure::common_hepatic_duct})
      gap = std::min(gap, distance_to(line_of(phantom, s).points, middle));
    if (gap > line_of(phantom, Structure::common_bile_duct).radii[0] && (middle - line.front()).norm() > 2.6e-3)
      sum += (line[p] - line[p - 1]).norm();
  }
  return sum;
}

TEST(Variants, have_names) {
  for (const char* name :
       {"usual", "short-cystic-duct", "low-insertion", "aberrant-right-duct", "second-cystic-artery", "inflamed"}) {
    ASSERT_TRUE(variant_named(name)) << name;
    EXPECT_EQ(name_of(*variant_named(name)), name);
  }
  EXPECT_FALSE(variant_named("Usual"));
  EXPECT_FALSE(variant_named(""));
}

TEST(Variants, short_cystic_duct) {
  for (const std::uint64_t seed : {6u}) {
    const Phantom phantom = phantom_of(seed, PhantomVariant::short_cystic_duct);
    expect_whole(phantom);
    EXPECT_GE(phantom.facts.cystic_duct_length, 0.008);
    EXPECT_LE(phantom.facts.cystic_duct_length, 0.012);
    EXPECT_NEAR(free_length(phantom), phantom.facts.cystic_duct_length, 0.0005);
  }
}

TEST(Variants, low_insertion) {
  for (const std::uint64_t seed : {8u}) {
    const Phantom phantom = phantom_of(seed, PhantomVariant::low_insertion);
    expect_whole(phantom);
    EXPECT_NEAR(free_length(phantom), phantom.facts.cystic_duct_length, 0.001);
    const Centreline &duct = line_of(phantom, Structure::cystic_duct),
                     &hepatic = line_of(phantom, Structure::common_hepatic_duct);
    EXPECT_TRUE(duct.points.back().isZero(1e-9)) << "the junction is the origin";
    double beside = 0;  // along the hepatic duct, with a gap of less than 3 mm between the walls
    for (std::size_t p = 1; p < duct.points.size(); ++p) {
      const double gap = distance_to(hepatic.points, duct.points[p]) - duct.radii[0] - hepatic.radii[0];
      if (gap > 0.5e-3 && gap < 3e-3) beside += (duct.points[p] - duct.points[p - 1]).norm();
    }
    EXPECT_GE(beside, 0.020);
    EXPECT_LE(beside, 0.045);
    EXPECT_GT(length(hepatic), 0.050) << "so the hepatic duct is long";
  }
}

TEST(Variants, aberrant_right_duct) {
  for (const std::uint64_t seed : {5u}) {
    const Phantom phantom = phantom_of(seed, PhantomVariant::aberrant_right_duct);
    expect_whole(phantom);
    EXPECT_GT(voxels_of(phantom, Structure::aberrant_right_duct), 40u);
    const Centreline &aberrant = line_of(phantom, Structure::aberrant_right_duct),
                     &hepatic = line_of(phantom, Structure::common_hepatic_duct);
    EXPECT_LT(distance_to(hepatic.points, aberrant.points.back()), 1e-3) << "joins the hepatic duct";
    // Seen across the triangle of junction, neck and hilum, it runs inside.
    const Vec3 junction = hepatic.points.back(), hilum = hepatic.points.front(),
               neck = line_of(phantom, Structure::cystic_duct).points.front();
    const Vec3 u = neck - junction, v = hilum - junction, normal = u.cross(v);
    int inside = 0;
    for (const Vec3& p : aberrant.points) {
      const Vec3 w = p - junction;
      const double b = w.cross(v).dot(normal) / normal.squaredNorm(), c = u.cross(w).dot(normal) / normal.squaredNorm();
      if (b > 0 && c > 0 && b + c < 1) ++inside;
    }
    EXPECT_GT(inside * 0.2, 6) << "millimetres";
  }
}

TEST(Variants, second_cystic_artery) {
  for (const std::uint64_t seed : {7u}) {
    const Phantom phantom = phantom_of(seed, PhantomVariant::second_cystic_artery);
    expect_whole(phantom);
    const Centreline &second = line_of(phantom, Structure::second_cystic_artery),
                     &duct = line_of(phantom, Structure::cystic_duct);
    EXPECT_LT(distance_to(line_of(phantom, Structure::right_hepatic_artery).points, second.points.front()), 1e-3);
    EXPECT_LE(second.radii[0], 0.8e-3);
    double nearest = 1, behind = 0;
    for (const Vec3& p : second.points)
      for (const Vec3& q : duct.points)
        if ((p - q).norm() < nearest) nearest = (p - q).norm(), behind = q[1] - p[1];
    EXPECT_GT(behind, 0) << "passes behind the cystic duct";
    EXPECT_GT(nearest, second.radii[0] + duct.radii[0]);
    EXPECT_GT(voxels_of(phantom, Structure::second_cystic_artery), 15u);
  }
}

TEST(Variants, inflamed) {
  const Phantom phantom = phantom_of(4, PhantomVariant::inflamed), usual = phantom_of(4, PhantomVariant::usual);
  expect_whole(phantom);
  EXPECT_GE(phantom.facts.wall_thickness, 0.004);
  EXPECT_LE(phantom.facts.wall_thickness, 0.007);
  EXPECT_EQ(usual.facts.wall_thickness, 0);
  // Thickness: volume of the wall against the lumen's grown by it, as if both were balls along the same axis.
  const double lumen = static_cast<double>(voxels_of(phantom, Structure::gallbladder));
  const double wall = static_cast<double>(voxels_of(phantom, Structure::gallbladder_wall));
  const double radius = phantom.facts.gallbladder_width / 2 * 1e3, thickness = phantom.facts.wall_thickness * 1e3;
  EXPECT_GT(wall / lumen, 1.2 * thickness / radius);
  EXPECT_LT(wall / lumen, 5 * thickness / radius);
  const auto mean = [](const Phantom& p, Structure s) {
    double sum = 0, count = 0;
    for (std::size_t v = 0; v < p.labels.voxels.size(); ++v)
      if (p.labels.voxels[v] == label_of(s)) sum += p.ct.hounsfield[v], ++count;
    return sum / count;
  };
  EXPECT_GT(mean(phantom, Structure::gallbladder_wall), mean(phantom, Structure::gallbladder) + 15);
  EXPECT_GT(mean(phantom, Structure::hepatocystic_fat), mean(usual, Structure::hepatocystic_fat) + 8) << "stranding";
  // The lumen is enclosed: it touches wall and cystic duct alone.
  const auto& n = phantom.labels.grid.size;
  const std::array<std::size_t, 3> stride{1, n[0], n[0] * n[1]};
  for (std::size_t v = stride[2]; v + stride[2] < phantom.labels.voxels.size(); ++v) {
    if (phantom.labels.voxels[v] != label_of(Structure::gallbladder)) continue;
    for (const std::size_t step : stride)
      for (const Label other : {phantom.labels.voxels[v - step], phantom.labels.voxels[v + step]})
        ASSERT_TRUE(other == label_of(Structure::gallbladder) || other == label_of(Structure::gallbladder_wall) ||
                    other == label_of(Structure::cystic_duct))
            << other;
  }
}

}  // namespace
}  // namespace calot
