// The phantom's facts: within the published ranges, where anatomy has them, and the same every time.
#include "calot/patient/phantom.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/image/voxel_parts.h"
#include "tests/support/files.h"

namespace calot {
namespace {

std::vector<Vec3> places(const LabelMap& map, Label label) {
  std::vector<Vec3> points;
  const auto& n = map.grid.size;
  for (std::size_t v = 0; v < map.voxels.size(); ++v)
    if (map.voxels[v] == label)
      points.push_back(map.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                                static_cast<double>(v / (n[0] * n[1]))));
  return points;
}

Vec3 mean_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Extents [mm] along the main axes, shortest first.
Vec3 extents(const std::vector<Vec3>& points) {
  const Vec3 mean = mean_of(points);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(Vec3(axes.transpose() * p));
  return 1e3 * box.sizes();
}

class PhantomOfSeed : public testing::TestWithParam<int> {};

TEST_P(PhantomOfSeed, is_within_the_published_ranges) {
  const Phantom phantom = make_biliary_tree(static_cast<std::uint64_t>(GetParam()));
  const double voxel = phantom.labels.grid.voxel_volume();
  const std::vector<Vec3> sac = places(phantom.labels, label_of(Structure::gallbladder));
  const double volume = static_cast<double>(sac.size()) * voxel * 1e6;
  EXPECT_GT(volume, 30);
  EXPECT_LT(volume, 50);
  EXPECT_NEAR(volume, phantom.facts.gallbladder_volume * 1e6, 0.03 * volume);
  const Vec3 size = extents(sac);
  EXPECT_GE(size[2], 69);
  EXPECT_LE(size[2], 101);
  EXPECT_GE(size[0], 29);
  EXPECT_LE(size[1], 52);

  const PhantomFacts& f = phantom.facts;
  EXPECT_GE(f.cystic_duct_length, 0.020);
  EXPECT_LE(f.cystic_duct_length, 0.040);
  EXPECT_GE(f.cystic_duct_diameter / phantom.labels.grid.spacing()[0], 4 - 1e-9) << "voxels across";
  EXPECT_LE(f.cystic_duct_diameter, 0.005);
  const auto duct = static_cast<double>(places(phantom.labels, label_of(Structure::cystic_duct)).size()) * voxel;
  const double tube = M_PI / 4 * f.cystic_duct_diameter * f.cystic_duct_diameter * f.cystic_duct_length;
  EXPECT_NEAR(duct / tube, 1, 0.12) << "the label is as long and as thick as drawn";

  EXPECT_GE(f.bile_duct_length, 0.070);
  EXPECT_LE(f.bile_duct_length, 0.080);
  EXPECT_LE(f.bile_duct_diameter, 0.006);
  const auto bile = static_cast<double>(places(phantom.labels, label_of(Structure::common_bile_duct)).size()) * voxel;
  EXPECT_NEAR(
      bile / (M_PI / 4 * f.bile_duct_diameter * f.bile_duct_diameter * (f.bile_duct_length + f.hepatic_duct_length)), 1,
      0.06);
}

TEST_P(PhantomOfSeed, lies_as_in_the_body) {
  const Phantom phantom = make_biliary_tree(static_cast<std::uint64_t>(GetParam()));
  const std::vector<Vec3> sac = places(phantom.labels, label_of(Structure::gallbladder));
  const Vec3 middle = mean_of(sac);
  EXPECT_GT(middle[0], 0.010) << "right of the bile duct";
  EXPECT_GT(middle[1], 0.010) << "in front of it";
  const Centreline& cystic = phantom.lines.at(0);
  const Centreline& common = phantom.lines.at(1);
  EXPECT_LT(middle[2], cystic.points.front()[2]) << "the fundus hangs below the neck";
  EXPECT_GT(cystic.points.front()[2], cystic.points.back()[2]) << "the duct descends";
  EXPECT_LT(cystic.points.back().norm(), 1e-6) << "into the junction, the origin";
  EXPECT_GT(common.points.front()[2], 0.02) << "hilum above";
  EXPECT_LT(common.points.back()[2], -0.055) << "papilla below";
  const auto& n = phantom.labels.grid.size;
  std::vector<std::uint8_t> regions(phantom.labels.voxels.begin(), phantom.labels.voxels.end());
  for (const RegionCleaning& region : keep_largest_parts(regions, n, 4))
    EXPECT_EQ(region.specks, 0u) << "one part a label";
  for (std::size_t v = 0; v < regions.size(); ++v) regions[v] = regions[v] > 0 ? 1 : 0;
  EXPECT_EQ(keep_largest_parts(regions, n, 1)[0].specks, 0u) << "and all of them joined";
}

INSTANTIATE_TEST_SUITE_P(Seeds, PhantomOfSeed, testing::Range(0, 8));

TEST(Phantom, lengths_scatter_about_the_published_mean) {
  double length = 0, diameter = 0;
  constexpr int count = 20;
  for (int seed = 0; seed < count; ++seed) {
    const PhantomFacts facts = make_biliary_tree(static_cast<std::uint64_t>(seed), 0.7e-3).facts;
    length += facts.cystic_duct_length / count;
    diameter += facts.cystic_duct_diameter / count;
  }
  EXPECT_NEAR(length, 0.0274, 0.003);
  EXPECT_NEAR(diameter, 0.00284, 0.0002);
}

TEST(Phantom, ct_shows_bile_in_fat) {
  const Phantom phantom = make_biliary_tree(3, 0.7e-3);
  double bile = 0, fat = 0, bile_count = 0, fat_count = 0;
  for (std::size_t v = 0; v < phantom.labels.voxels.size(); ++v) {
    const Label label = phantom.labels.voxels[v];
    if (label == label_of(Structure::gallbladder)) bile += phantom.ct.hounsfield[v], ++bile_count;
    if (label == 0) fat += phantom.ct.hounsfield[v], ++fat_count;
  }
  EXPECT_NEAR(bile / bile_count, 3, 4);
  EXPECT_NEAR(fat / fat_count, -75, 2);
}

TEST(Phantom, the_same_seed_gives_the_same_bytes_on_any_number_of_threads) {
  const test::TempFolder folder;
  const int threads = thread_count();
  for (const int count : {1, 3}) {
    set_thread_count(count);
    const Phantom phantom = make_biliary_tree(5, 0.7e-3);
    const std::string name = std::to_string(count);
    write_label_map(folder / ("labels" + name + ".nii.gz"), phantom.labels);
    write_ct(folder / ("ct" + name + ".nii.gz"), phantom.ct);
    write_markups(folder / ("ducts" + name + ".mrk.json"), phantom.lines);
  }
  set_thread_count(threads);
  EXPECT_EQ(test::read_bytes(folder / "labels1.nii.gz"), test::read_bytes(folder / "labels3.nii.gz"));
  EXPECT_EQ(test::read_bytes(folder / "ct1.nii.gz"), test::read_bytes(folder / "ct3.nii.gz"));
  EXPECT_EQ(test::read_bytes(folder / "ducts1.mrk.json"), test::read_bytes(folder / "ducts3.mrk.json"));
  EXPECT_NE(make_biliary_tree(6, 0.7e-3).labels.voxels, make_biliary_tree(5, 0.7e-3).labels.voxels);
}

TEST(Phantom, refuses_voxels_that_are_too_large) {
  EXPECT_NE(test::message_of([] { make_biliary_tree(1, 2e-3); }).find("0.3 … 0.7 mm"), std::string::npos);
}

}  // namespace
}  // namespace calot
