// Completing labels of a scene whose truth is a formula.
#include "calot/patient/completion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/image/morphology.h"
#include "calot/image/voxel_parts.h"
#include "tests/patient/completion_scene.h"

namespace calot {
namespace {

using test::make_scene;
using test::organs_only;
using test::Scene;

CompletedAnatomy complete(const Scene& scene, const CompletionOptions& options = {}) {
  Progress progress;
  return complete_anatomy(scene.ct, scene.labels, scene.lines, options, progress);
}

Vec3 place(const VoxelGrid& grid, std::size_t v) {
  return grid.to_world * Vec3(static_cast<double>(v % grid.size[0]),
                              static_cast<double>(v / grid.size[0] % grid.size[1]),
                              static_cast<double>(v / (grid.size[0] * grid.size[1])));
}

/// Voxels of the truth, of the result, and of both.
struct Overlap {
  double truth = 0, found = 0, both = 0;
  [[nodiscard]] double dice() const { return 2 * both / (truth + found); }
};

Overlap overlap(const LabelMap& map, Structure s, bool oblique) {
  Overlap o;
  for (std::size_t v = 0; v < map.voxels.size(); ++v) {
    const bool truth = test::scene_truth(test::to_scene(place(map.grid, v), oblique)) == s;
    const bool found = map.voxels[v] == label_of(s);
    o.truth += truth;
    o.found += found;
    o.both += truth && found;
  }
  return o;
}

double volume_mm3(const LabelMap& map, Structure s) {
  const auto voxels = std::count(map.voxels.begin(), map.voxels.end(), label_of(s));
  return 1e9 * map.grid.voxel_volume() * static_cast<double>(voxels);
}

bool touch(const LabelMap& map, Structure a, Structure b) {
  const auto& n = map.grid.size;
  for (std::size_t k = 0; k < n[2]; ++k)
    for (std::size_t j = 0; j < n[1]; ++j)
      for (std::size_t i = 0; i < n[0]; ++i) {
        const Label here = map.voxels[map.grid.index(i, j, k)];
        const auto pair = [&](Label other) {
          return (here == label_of(a) && other == label_of(b)) || (here == label_of(b) && other == label_of(a));
        };
        if (i + 1 < n[0] && pair(map.voxels[map.grid.index(i + 1, j, k)])) return true;
        if (j + 1 < n[1] && pair(map.voxels[map.grid.index(i, j + 1, k)])) return true;
        if (k + 1 < n[2] && pair(map.voxels[map.grid.index(i, j, k + 1)])) return true;
      }
  return false;
}

std::size_t parts_too_many(const LabelMap& map) {
  std::vector<std::uint8_t> regions(map.voxels.begin(), map.voxels.end());
  std::size_t specks = 0;
  for (const RegionCleaning& cleaning : keep_largest_parts(regions, map.grid.size, all_structures().size()))
    specks += cleaning.specks;
  return specks;
}

void expect_whole(const CompletedAnatomy& anatomy, bool oblique) {
  const LabelMap& map = anatomy.labels;
  EXPECT_EQ(parts_too_many(map), 0u);
  EXPECT_TRUE(touch(map, Structure::cystic_duct, Structure::gallbladder));
  EXPECT_TRUE(touch(map, Structure::cystic_duct, Structure::common_bile_duct));
  EXPECT_TRUE(touch(map, Structure::gallbladder_bed, Structure::gallbladder));
  EXPECT_TRUE(touch(map, Structure::gallbladder_bed, Structure::liver));
  for (const Structure tube : {Structure::hepatocystic_fat, Structure::gallbladder_bed}) {
    const double dice = overlap(map, tube, oblique).dice();
    EXPECT_GE(dice, 0.85) << name_of(tube);
  }
  for (const Structure s :
       {Structure::liver, Structure::gallbladder, Structure::common_bile_duct, Structure::cystic_duct}) {
    const Overlap o = overlap(map, s, oblique);
    EXPECT_NEAR(o.found / o.truth, 1, is_tube(s) ? 0.05 : 0.03) << name_of(s);
  }
}

TEST(Completion, FindsWhatIsLackingOnFineVoxels) {
  const Scene scene = make_scene({0.7, 0.7, 0.7}, false, organs_only);
  const CompletedAnatomy anatomy = complete(scene);
  EXPECT_TRUE(anatomy.warnings.empty());
  EXPECT_TRUE(anatomy.border_cuts.empty());
  EXPECT_NEAR(anatomy.labels.grid.spacing()[0], 0.7e-3, 1e-9);  // the CT's own
  EXPECT_EQ(grid_difference(anatomy.labels.grid, anatomy.ct.grid), "");
  expect_whole(anatomy, false);
}

TEST(Completion, FindsWhatIsLackingOnThickObliqueSlices) {
  const Scene scene = make_scene({0.8, 0.8, 2.4}, true, organs_only);
  const CompletedAnatomy anatomy = complete(scene);
  const Vec3 spacing = anatomy.labels.grid.spacing();
  EXPECT_NEAR(spacing.minCoeff(), 0.7e-3, 1e-9);
  EXPECT_NEAR(spacing.maxCoeff(), 0.7e-3, 1e-9);
  expect_whole(anatomy, true);
}

TEST(Completion, CarvesABedWhereGallbladderAndLiverTouch) {
  Scene scene = make_scene({0.7, 0.7, 0.7}, false, [](Structure s) { return s != Structure::none; });
  for (Label& label : scene.labels.voxels) {  // the bed goes to the liver, as segmenters have it
    if (label == label_of(Structure::gallbladder_bed)) label = label_of(Structure::liver);
    if (label > label_of(Structure::gallbladder)) label = 0;
  }
  const CompletedAnatomy anatomy = complete(scene);
  expect_whole(anatomy, false);
}

TEST(Completion, LinesRunTowardsTheGallbladderAndDownwards) {
  const CompletedAnatomy anatomy = complete(make_scene({1, 1, 1}, false, organs_only));
  ASSERT_EQ(anatomy.lines.size(), 2u);
  const Centreline &bile = anatomy.lines[0], &cystic = anatomy.lines[1];
  EXPECT_EQ(bile.name, "common bile duct");
  EXPECT_GT(bile.points.front()[2], bile.points.back()[2]);
  EXPECT_EQ(cystic.name, "cystic duct");  // drawn from the gallbladder on: turned
  EXPECT_NEAR(1e3 * cystic.points.back().norm(), test::scene_sac_radius, 1);
  EXPECT_NEAR(std::hypot(1e3 * cystic.points.front()[0] + 40, 1e3 * cystic.points.front()[1]), 3, 1);
}

TEST(Completion, StepsAddUp) {
  Scene scene = make_scene({0.7, 0.7, 0.7}, false, organs_only);
  scene.labels.voxels[scene.labels.grid.index(2, 2, 2)] = label_of(Structure::liver);  // a speck
  const CompletedAnatomy anatomy = complete(scene);
  std::map<Structure, std::ptrdiff_t> expected;
  for (const auto& [label, count] : voxel_counts(scene.labels))
    expected[static_cast<Structure>(label)] = static_cast<std::ptrdiff_t>(count);
  for (const CompletionStep& step : anatomy.steps) {
    if (step.structure == Structure::none) continue;
    expected[step.structure] += static_cast<std::ptrdiff_t>(step.added) - static_cast<std::ptrdiff_t>(step.removed);
    EXPECT_NEAR(step.added_ml, 0.343e-3 * static_cast<double>(step.added), 1e-6);
    EXPECT_NEAR(step.removed_ml, 0.343e-3 * static_cast<double>(step.removed), 1e-6);
  }
  std::map<Structure, std::ptrdiff_t> counted;
  for (const Label label : anatomy.labels.voxels)
    if (label != 0) ++counted[static_cast<Structure>(label)];
  EXPECT_EQ(counted, expected);
  EXPECT_EQ(counted.size(), 6u);
  EXPECT_TRUE(std::any_of(anatomy.steps.begin(), anatomy.steps.end(), [](const CompletionStep& step) {
    return step.step == "largest part kept" && step.structure == Structure::liver && step.removed == 1;
  }));
}

TEST(Completion, IsTheSameOnAnyNumberOfThreads) {
  const Scene scene = make_scene({1.2, 1.2, 2}, true, organs_only);
  const int before = thread_count();
  set_thread_count(1);
  const CompletedAnatomy one = complete(scene);
  set_thread_count(2);
  const CompletedAnatomy two = complete(scene);
  set_thread_count(before);
  EXPECT_EQ(one.labels.voxels, two.labels.voxels);
  EXPECT_EQ(one.ct.hounsfield, two.ct.hounsfield);
  ASSERT_EQ(one.lines.size(), two.lines.size());
  for (std::size_t l = 0; l < one.lines.size(); ++l) EXPECT_EQ(one.lines[l].points, two.lines[l].points);
}

TEST(Completion, KeepsFatAndBedThatAreThere) {
  const Scene scene = make_scene({0.7, 0.7, 0.7}, false, [](Structure s) { return s != Structure::none; });
  CompletionOptions options;
  const CompletedAnatomy anatomy = complete(scene, options);
  for (const Structure s : {Structure::hepatocystic_fat, Structure::gallbladder_bed})
    EXPECT_GE(overlap(anatomy.labels, s, false).dice(), 0.97) << name_of(s);
}

TEST(Completion, CleaningKeepsABedThatVeryThickSlicesCutIntoStrips) {
  const Scene scene = make_scene({0.8, 0.8, 5}, true, [](Structure s) { return s != Structure::none; });
  Mask bed(scene.labels.voxels.size());
  for (std::size_t v = 0; v < bed.size(); ++v) bed[v] = scene.labels.voxels[v] == label_of(Structure::gallbladder_bed);
  EXPECT_GT(keep_largest_part(bed, scene.labels.grid.size, Joined::by_faces), 0u) << "it is in strips";
  const CompletedAnatomy anatomy = complete(scene);
  for (const std::string& warning : anatomy.warnings) EXPECT_EQ(warning.find("bed"), std::string::npos) << warning;
  for (const CompletionStep& step : anatomy.steps)
    if (step.structure == Structure::gallbladder_bed) {
      EXPECT_NE(step.step, "largest part kept") << step.removed_ml << " mL";
      EXPECT_NE(step.step, "one piece each") << step.removed_ml << " mL";
    }
}

TEST(Completion, LeavesFatAndBedAloneWhereAskedTo) {
  CompletionOptions options;
  options.fat = false;
  const CompletedAnatomy anatomy = complete(make_scene({1, 1, 1}, false, organs_only), options);
  EXPECT_EQ(volume_mm3(anatomy.labels, Structure::hepatocystic_fat), 0);
  EXPECT_EQ(volume_mm3(anatomy.labels, Structure::gallbladder_bed), 0);
}

TEST(Completion, FindsLinesOfTubesThatAreLabels) {
  Scene scene = make_scene({0.7, 0.7, 0.7}, false, [](Structure s) { return organs_only(s) || is_tube(s); });
  scene.lines.clear();
  const CompletedAnatomy anatomy = complete(scene);
  expect_whole(anatomy, false);
  ASSERT_EQ(anatomy.lines.size(), 2u);
  EXPECT_EQ(anatomy.lines[1].name, "cystic duct");
  EXPECT_NEAR(1e3 * anatomy.lines[1].points.back().norm(), test::scene_sac_radius, 1);
  const Centreline& bile = anatomy.lines[0];
  EXPECT_GT(bile.points.front()[2], bile.points.back()[2]);
  EXPECT_NEAR(1e3 * length(bile), 43 + 6, 2);  // round ends
  for (std::size_t p = 0; p < bile.points.size(); ++p) {
    EXPECT_NEAR(1e3 * std::hypot(bile.points[p][0] + 0.040, bile.points[p][1]), 0, 0.5);
    EXPECT_NEAR(1e3 * bile.radii[p], 3, 0.3);
  }
}

TEST(Completion, JoinsEndsThatStopShort) {
  Scene scene = make_scene({0.7, 0.7, 0.7}, false, organs_only);
  Centreline& cystic = scene.lines[1];
  const Vec3 way = cystic.points.back() - cystic.points.front();
  cystic.points.front() += 0.12 * way;
  cystic.points.back() -= 0.12 * way;
  const CompletedAnatomy anatomy = complete(scene);
  EXPECT_TRUE(touch(anatomy.labels, Structure::cystic_duct, Structure::gallbladder));
  EXPECT_TRUE(touch(anatomy.labels, Structure::cystic_duct, Structure::common_bile_duct));
  EXPECT_EQ(parts_too_many(anatomy.labels), 0u);
}

TEST(Completion, AnArteryMayCrossADuct) {
  Scene scene = make_scene({0.7, 0.7, 0.7}, false, organs_only);
  scene.lines.push_back({"cystic artery",
                         {{-0.046, 0.002, -0.005}, {-0.03, 0.001, -0.005}, {-0.012, 0, -0.005}},
                         {0.8e-3, 0.8e-3, 0.8e-3}});
  scene.lines.push_back({"right hepatic artery",
                         {{-0.048, 0.004, -0.02}, {-0.046, 0.002, -0.005}, {-0.046, 0.002, 0.003}},
                         {1e-3, 1e-3, 1e-3}});
  const CompletedAnatomy anatomy = complete(scene);
  EXPECT_EQ(parts_too_many(anatomy.labels), 0u);
  EXPECT_TRUE(touch(anatomy.labels, Structure::cystic_artery, Structure::right_hepatic_artery));
  EXPECT_TRUE(touch(anatomy.labels, Structure::cystic_artery, Structure::gallbladder));
  const double length = 46 - 12.9 - 1;  // from artery to gallbladder
  EXPECT_NEAR(volume_mm3(anatomy.labels, Structure::cystic_artery), M_PI * 0.64 * length, 0.1 * M_PI * 0.64 * length);
}

}  // namespace
}  // namespace calot
