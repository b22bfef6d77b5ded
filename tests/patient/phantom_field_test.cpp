// The whole operating field: within the published ranges, whole, joined as in the body, and the same every time.
#include "calot/patient/phantom_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/parallel.h"
#include "calot/image/voxel_parts.h"
#include "calot/patient/phantom.h"
#include "tests/support/files.h"

namespace calot {
namespace {

constexpr std::array variants{PhantomVariant::usual,
                              PhantomVariant::short_cystic_duct,
                              PhantomVariant::low_insertion,
                              PhantomVariant::aberrant_right_duct,
                              PhantomVariant::second_cystic_artery,
                              PhantomVariant::inflamed};

Phantom phantom_of(std::uint64_t seed, PhantomVariant variant = PhantomVariant::usual, double voxel = 1e-3) {
  PhantomOptions options;
  options.seed = seed;
  options.variant = variant;
  options.voxel = voxel;
  Progress silent;
  return make_phantom(options, silent);
}

/// Which labels share a voxel face, the smaller first.
std::set<std::pair<Label, Label>> touching(const LabelMap& map) {
  std::set<std::pair<Label, Label>> pairs;
  const auto& n = map.grid.size;
  const std::array<std::size_t, 3> stride{1, n[0], n[0] * n[1]};
  for (std::size_t k = 0, v = 0; k < n[2]; ++k)
    for (std::size_t j = 0; j < n[1]; ++j)
      for (std::size_t i = 0; i < n[0]; ++i, ++v) {
        const std::array<std::size_t, 3> at{i, j, k};
        for (std::size_t d = 0; d < 3; ++d) {
          if (at[d] + 1 == n[d]) continue;
          const Label a = map.voxels[v], b = map.voxels[v + stride[d]];
          if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
        }
      }
  return pairs;
}

void expect_touching(const std::set<std::pair<Label, Label>>& pairs, Structure a, Structure b) {
  EXPECT_TRUE(pairs.contains({std::min(label_of(a), label_of(b)), std::max(label_of(a), label_of(b))}))
      << name_of(a) << " and " << name_of(b);
}

double millilitres(const Phantom& phantom, Structure s) {
  const auto counts = voxel_counts(phantom.labels);
  const auto found = counts.find(label_of(s));
  return found == counts.end() ? 0 : static_cast<double>(found->second) * phantom.labels.grid.voxel_volume() * 1e6;
}

const Centreline& line_of(const Phantom& phantom, Structure s) {
  return *std::find_if(phantom.lines.begin(), phantom.lines.end(),
                       [&](const Centreline& line) { return line.name == name_of(s); });
}

void expect_within_ranges(const PhantomFacts& f) {
  EXPECT_GE(f.liver_volume, 1062e-6);  // 1281 ± 219 mL
  EXPECT_LE(f.liver_volume, 1515e-6);
  EXPECT_GE(f.liver_width, 0.200);
  EXPECT_LE(f.liver_width, 0.225);
  EXPECT_GE(f.liver_height, 0.150);
  EXPECT_LE(f.liver_height, 0.175);
  EXPECT_GE(f.liver_depth, 0.100);
  EXPECT_LE(f.liver_depth, 0.125);
  EXPECT_GE(f.gallbladder_length, 0.070);
  EXPECT_LE(f.gallbladder_length, 0.100);
  EXPECT_GE(f.gallbladder_width, 0.030);
  EXPECT_LE(f.gallbladder_width, 0.050);
  EXPECT_GE(f.gallbladder_volume, 30e-6);
  EXPECT_LE(f.gallbladder_volume, 50e-6);
  EXPECT_GE(f.cystic_artery_length, 0.0169);
  EXPECT_LE(f.cystic_artery_length, 0.0270);
  EXPECT_GE(f.cystic_artery_diameter, 0.0012);
  EXPECT_LE(f.cystic_artery_diameter, 0.0016);
}

class FieldOfSeed : public testing::TestWithParam<int> {};

// Voxels of 1 mm, the coarsest there are: what holds at them holds at finer ones.
TEST_P(FieldOfSeed, is_whole_and_joined) {
  const Phantom phantom = phantom_of(static_cast<std::uint64_t>(GetParam()));
  expect_within_ranges(phantom.facts);
  EXPECT_NEAR(millilitres(phantom, Structure::liver), phantom.facts.liver_volume * 1e6, 13);
  EXPECT_NEAR(millilitres(phantom, Structure::gallbladder), phantom.facts.gallbladder_volume * 1e6, 1);
  EXPECT_GT(millilitres(phantom, Structure::hepatocystic_fat), 2);
  EXPECT_LT(millilitres(phantom, Structure::hepatocystic_fat), 10);

  std::vector<std::uint8_t> regions(phantom.labels.voxels.begin(), phantom.labels.voxels.end());
  const auto parts = keep_largest_parts(regions, phantom.labels.grid.size, 9);
  for (std::size_t label = 1; label <= 9; ++label) {
    EXPECT_GT(parts[label - 1].voxels, 0u) << label;
    EXPECT_EQ(parts[label - 1].specks, 0u) << label;
  }
  using enum Structure;
  const auto pairs = touching(phantom.labels);
  for (const auto& [a, b] :
       std::initializer_list<std::pair<Structure, Structure>>{{cystic_duct, gallbladder},
                                                              {cystic_duct, common_bile_duct},
                                                              {cystic_duct, common_hepatic_duct},
                                                              {common_bile_duct, common_hepatic_duct},
                                                              {common_hepatic_duct, liver},
                                                              {cystic_artery, right_hepatic_artery},
                                                              {cystic_artery, gallbladder},
                                                              {right_hepatic_artery, liver},
                                                              {gallbladder_bed, liver},
                                                              {gallbladder_bed, gallbladder},
                                                              {hepatocystic_fat, liver},
                                                              {hepatocystic_fat, cystic_duct},
                                                              {hepatocystic_fat, cystic_artery},
                                                              {hepatocystic_fat, common_hepatic_duct},
                                                              {hepatocystic_fat, gallbladder}})
    expect_touching(pairs, a, b);
  for (const Structure artery : {cystic_artery, right_hepatic_artery})
    for (const Structure duct : {cystic_duct, common_bile_duct, common_hepatic_duct})
      EXPECT_FALSE(
          pairs.contains({std::min(label_of(artery), label_of(duct)), std::max(label_of(artery), label_of(duct))}))
          << name_of(artery) << " and " << name_of(duct);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FieldOfSeed, testing::Range(0, 5));

TEST(Field, facts_of_a_cohort_lie_within_the_published_ranges) {
  double volume = 0;
  constexpr int count = 20;
  for (int seed = 100; seed < 100 + count; ++seed) {
    const PhantomFacts facts =
        draw_operating_field(static_cast<std::uint64_t>(seed), variants[static_cast<std::size_t>(seed) % 6]).facts;
    SCOPED_TRACE(seed);
    expect_within_ranges(facts);
    volume += facts.liver_volume / count;
  }
  EXPECT_NEAR(volume, 1281e-6, 80e-6);
}

/// Of the voxel faces of the gallbladder's body that look outwards, the share that lies in the bed.
TEST(Field, a_third_to_a_half_of_the_gallbladders_circumference_lies_in_its_bed) {
  for (const std::uint64_t seed : {4u}) {
    const Phantom phantom = phantom_of(seed);
    const OperatingField field = draw_operating_field(seed, PhantomVariant::usual);
    const LabelMap& map = phantom.labels;
    const std::size_t n = field.outside.size();
    const Vec3 axis = (field.outside[n - 1].centre - field.outside[0].centre).normalized();
    int around = 0, bedded = 0;
    for (std::size_t b = n / 2; b < 17 * n / 20; b += 4) {  // circles about the body, a voxel outside the wall
      const Ball& ball = field.outside[b];
      const Vec3 u = axis.unitOrthogonal(), w = axis.cross(u);
      for (int step = 0; step < 72; ++step) {
        const double angle = M_PI * step / 36;
        const Vec3 p = ball.centre + (ball.radius + 1.2e-3) * (std::cos(angle) * u + std::sin(angle) * w);
        const Eigen::Vector3i at = (map.grid.to_world.inverse() * p).array().round().matrix().cast<int>();
        const Label label = map.voxels[map.grid.index(static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]),
                                                      static_cast<std::size_t>(at[2]))];
        ++around;
        if (label == label_of(Structure::gallbladder_bed)) ++bedded;
      }
    }
    const double share = static_cast<double>(bedded) / around;
    EXPECT_GT(share, 0.30) << seed;
    EXPECT_LT(share, 0.52) << seed;
  }
}

TEST(Field, lies_as_in_the_body) {
  for (const std::uint64_t seed : {2u, 9u}) {
    const OperatingField field = draw_operating_field(seed, PhantomVariant::usual);
    const Ball& fundus = field.outside.back();
    const Eigen::AlignedBox3d liver = field.liver.field.measure_inside().extent;
    const Vec3 neck = field.outside.front().centre;
    EXPECT_LT(fundus.centre[2], neck[2] - 0.02) << "the fundus hangs down";
    EXPECT_GT(fundus.centre[1], neck[1] + 0.02) << "in front";
    EXPECT_LT(liver.max()[1] - (fundus.centre[1] + fundus.radius), 0.025) << "near the liver's front";
    EXPECT_GT(liver.max()[2], 0.06) << "the dome is high above the hilum";
    EXPECT_GT(liver.max()[0], -liver.min()[0] - 0.028 * 2) << "more of the liver is on the right of the midline";
    EXPECT_LT(field.liver.field.at(field.bile_duct.points.front()), 0) << "the hepatic duct comes out of the liver";
    EXPECT_GT(field.liver.field.at(field.hub), 0.01) << "the junction lies free below it";
    // The hepatic artery passes behind the hepatic duct, the cystic artery lies between the duct and the liver.
    const Centreline& artery = field.tube(Structure::right_hepatic_artery).line;
    double nearest = 1, behind = 0;
    for (const Vec3& p : artery.points)
      for (const Vec3& q : field.bile_duct.points)
        if ((p - q).norm() < nearest) nearest = (p - q).norm(), behind = q[1] - p[1];
    EXPECT_GT(behind, 0.9 * nearest);
    EXPECT_LT(artery.points.front()[0], field.hub[0]) << "from the left";
    EXPECT_GT(artery.points.back()[0], field.hub[0]) << "to the right";
    EXPECT_LT(field.liver.field.at(artery.points.back()), 0) << "into the liver";
  }
}

TEST(Field, ct_has_the_published_densities) {
  const Phantom phantom = phantom_of(3, PhantomVariant::usual, 1e-3);
  struct Sum {
    double count = 0, sum = 0, squares = 0;
    [[nodiscard]] double mean() const { return sum / count; }
    [[nodiscard]] double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
  };
  std::map<Structure, Sum> sums;
  for (std::size_t v = 0; v < phantom.labels.voxels.size(); ++v) {
    Sum& s = sums[static_cast<Structure>(phantom.labels.voxels[v])];
    const double value = phantom.ct.hounsfield[v];
    s.count += 1, s.sum += value, s.squares += value * value;
  }
  EXPECT_NEAR(sums[Structure::liver].mean(), 47, 2);
  EXPECT_NEAR(sums[Structure::liver].deviation(), 13, 3);
  EXPECT_NEAR(sums[Structure::gallbladder].mean(), 3, 3);
  EXPECT_NEAR(sums[Structure::gallbladder].deviation(), 11, 3);
  EXPECT_NEAR(sums[Structure::right_hepatic_artery].mean(), 41, 30) << "thin: half of it is partial volume with fat";
  EXPECT_LT(sums[Structure::hepatocystic_fat].mean(), -55);
  EXPECT_GT(sums[Structure::hepatocystic_fat].mean(), -95);
  const auto [low, high] = std::minmax_element(phantom.ct.hounsfield.begin(), phantom.ct.hounsfield.end());
  EXPECT_LT(*low, -950) << "air";
  EXPECT_GT(*high, 350) << "bone";
}

TEST(Field, is_the_same_on_any_number_of_threads) {
  const int threads = thread_count();
  set_thread_count(1);
  const Phantom one = phantom_of(5);
  set_thread_count(2);
  const Phantom two = phantom_of(5);
  set_thread_count(threads);
  EXPECT_TRUE(one.labels.voxels == two.labels.voxels);
  EXPECT_TRUE(one.ct.hounsfield == two.ct.hounsfield);
  EXPECT_FALSE(phantom_of(6).ct.hounsfield == one.ct.hounsfield);
}

TEST(Field, has_the_tree_of_the_same_seed) {
  const Phantom field = phantom_of(7), tree = make_biliary_tree(7, 0.7e-3);
  EXPECT_EQ(field.facts.gallbladder_volume, tree.facts.gallbladder_volume);
  EXPECT_EQ(field.facts.cystic_duct_length, tree.facts.cystic_duct_length);
  EXPECT_EQ(line_of(field, Structure::cystic_duct).points, tree.lines.at(0).points);
  EXPECT_TRUE(line_of(field, Structure::common_hepatic_duct).points.back().isZero(1e-12)) << "the junction";
  EXPECT_TRUE(line_of(field, Structure::common_bile_duct).points.front().isZero(1e-12));
}

TEST(Field, thin_arteries_stay_whole_at_coarse_slices) {
  PhantomOptions options;
  options.seed = 11;
  options.matrix = {{256, 256, 60}};
  Progress silent;
  const Phantom phantom = make_phantom(options, silent);
  EXPECT_GT(phantom.labels.grid.spacing()[2], 3e-3);
  std::vector<std::uint8_t> regions(phantom.labels.voxels.begin(), phantom.labels.voxels.end());
  for (const RegionCleaning& part : keep_largest_parts(regions, phantom.labels.grid.size, 9)) {
    EXPECT_EQ(part.specks, 0u);
    EXPECT_GT(part.voxels, 0u);
  }
  const auto pairs = touching(phantom.labels);
  expect_touching(pairs, Structure::cystic_artery, Structure::right_hepatic_artery);
  expect_touching(pairs, Structure::cystic_artery, Structure::gallbladder);
  const VoxelGrid& grid = phantom.labels.grid;
  const double width = grid.spacing()[0] * static_cast<double>(grid.size[0]);
  EXPECT_GT(width, 0.33) << "the whole trunk";
  EXPECT_LT(width, 0.45);
  for (std::size_t j = 0; j < grid.size[1]; ++j)
    for (const std::size_t i : {std::size_t{0}, grid.size[0] - 1})
      EXPECT_LT(phantom.ct.hounsfield[grid.index(i, j, grid.size[2] / 2)], -900) << "air on both sides";
}

TEST(Field, refuses_options_out_of_range) {
  Progress silent;
  PhantomOptions options;
  options.voxel = 1.5e-3;
  EXPECT_NE(test::message_of([&] { make_phantom(options, silent); }).find("0.3 … 1.0 mm"), std::string::npos);
  options.voxel = 0.7e-3;
  options.matrix = {{512, 512, 4}};
  EXPECT_NE(test::message_of([&] { make_phantom(options, silent); }).find("512x512x300"), std::string::npos);
  options.matrix = {{1024, 1024, 1000}};
  EXPECT_NE(test::message_of([&] { make_phantom(options, silent); }).find("200 million"), std::string::npos);
}

TEST(Field, stops_when_asked) {
  Progress progress;
  progress.request_stop();
  EXPECT_THROW(make_phantom({}, progress), Interrupted);
}

}  // namespace
}  // namespace calot
