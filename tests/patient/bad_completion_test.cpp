// What cannot be completed: named, with what to do.
#include <gtest/gtest.h>

#include <algorithm>

#include "calot/base/error.h"
#include "calot/patient/border.h"
#include "tests/patient/completion_scene.h"

namespace calot {
namespace {

using test::Scene;

/// Coarse: only the checks matter.
Scene scene() {
  return test::make_scene({2, 2, 2}, false, test::organs_only);
}

std::string message_of(const Scene& bad, const CompletionOptions& options = {}) {
  Progress progress;
  try {
    complete_anatomy(bad.ct, bad.labels, bad.lines, options, progress);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

void expect_message(const Scene& bad, const std::vector<std::string>& parts, const CompletionOptions& options = {}) {
  const std::string message = message_of(bad, options);
  for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

void relabel(Scene& s, Structure from, Structure to) {
  std::replace(s.labels.voxels.begin(), s.labels.voxels.end(), label_of(from), label_of(to));
}

TEST(BadCompletion, TheSceneItselfIsGood) {
  EXPECT_EQ(message_of(scene()), "nothing");
}

TEST(BadCompletion, GridsThatDiffer) {
  Scene bad = scene();
  bad.labels.grid.to_world.translation() += Vec3(0, 0, 0.004);
  expect_message(bad, {"labels", "another grid than the CT",
                       "CT and labels differ: the second is moved by (0, 0, 4) mm);", "resample"});
}

TEST(BadCompletion, MissingOrgans) {
  Scene bad = scene();
  relabel(bad, Structure::gallbladder, Structure::none);
  expect_message(bad, {"have no gallbladder", "map its name"});
  bad = scene();
  relabel(bad, Structure::liver, Structure::none);
  expect_message(bad, {"have no liver"});
}

TEST(BadCompletion, MissingDucts) {
  Scene bad = scene();
  bad.lines.pop_back();
  expect_message(bad, {"have no cystic duct", "draw a centreline \"cystic duct\""});
  bad = scene();
  bad.lines.erase(bad.lines.begin());
  expect_message(bad, {"have no bile duct", "draw a centreline \"common bile duct\""});
}

TEST(BadCompletion, NumbersThatAreNoStructure) {
  Scene bad = scene();
  bad.labels.voxels[5] = 77;
  expect_message(bad, {"label 77 is no structure"});
}

/// Everything beyond a height goes, as if the scan had ended there.
Scene cut_at(double z_mm, bool above) {
  Scene s = scene();
  const auto& n = s.labels.grid.size;
  const double at = (1e-3 * z_mm - s.labels.grid.to_world.translation()[2]) / 2e-3;
  const auto k = static_cast<std::size_t>(at);
  const std::size_t first = above ? 0 : k * n[0] * n[1], last = above ? k * n[0] * n[1] : s.labels.voxels.size();
  const auto piece = [&](auto& values) {
    values = std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                            values.begin() + static_cast<std::ptrdiff_t>(last));
  };
  piece(s.labels.voxels);
  piece(s.ct.hounsfield);
  s.labels.grid.size[2] = above ? k : n[2] - k;
  if (!above) s.labels.grid.to_world.translation()[2] += 2e-3 * static_cast<double>(k);
  s.ct.grid = s.labels.grid;
  return s;
}

TEST(BadCompletion, AGallbladderCutByTheBorder) {
  Scene bad = cut_at(0, false);
  for (Centreline& line : bad.lines)
    for (Vec3& p : line.points) p[2] = 0.002;
  expect_message(bad, {"the gallbladder is cut by the volume's lower (inferior) end", "give a CT"});
}

TEST(BadCompletion, ADuctLabelCutByTheBorderButNotADrawnOne) {
  Scene bad = test::make_scene({2, 2, 2}, false, [](Structure s) { return test::organs_only(s) || is_tube(s); });
  const auto& n = bad.labels.grid.size;
  for (std::size_t v = 0; v < n[0] * n[1]; ++v)  // its lower end goes on to the first slice
    if (bad.labels.voxels[v + 4 * n[0] * n[1]] == label_of(Structure::common_bile_duct))
      for (std::size_t k = 0; k < 4; ++k)
        bad.labels.voxels[v + k * n[0] * n[1]] = label_of(Structure::common_bile_duct);
  Scene drawn = bad;
  bad.lines.erase(bad.lines.begin());
  expect_message(bad,
                 {"the common bile duct is cut by the volume's lower (inferior) end", "draw it with a centreline"});
  EXPECT_EQ(message_of(drawn), "nothing");
}

TEST(BadCompletion, ALiverCutByTheBorderIsAWarning) {
  const Scene cut = cut_at(24, true);
  Progress progress;
  const CompletedAnatomy anatomy = complete_anatomy(cut.ct, cut.labels, cut.lines, {}, progress);
  ASSERT_EQ(anatomy.border_cuts.size(), 1u);
  const BorderCut& face = anatomy.border_cuts[0];
  EXPECT_EQ(face.structure, Structure::liver);
  EXPECT_EQ(face.axis, 2);
  EXPECT_TRUE(face.upper);
  EXPECT_LT((face.normal - Vec3(0, 0, 1)).norm(), 1e-9);
  const VoxelGrid& grid = cut.labels.grid;
  EXPECT_NEAR(face.point[2], grid.to_world.translation()[2] + 2e-3 * (static_cast<double>(grid.size[2]) - 0.5), 1e-9);
  std::size_t voxels = 0;
  for (std::size_t v = grid.count() - grid.size[0] * grid.size[1]; v < grid.count(); ++v)
    voxels += cut.labels.voxels[v] == 1;
  EXPECT_NEAR(face.area, 4e-6 * static_cast<double>(voxels), 1e-12);
  ASSERT_FALSE(anatomy.warnings.empty());
  EXPECT_NE(anatomy.warnings[0].find("the liver is cut by the volume's upper (superior) end"), std::string::npos);
}

TEST(BadCompletion, WhatMayBeCutIsWrittenDownAndTheRestRefused) {
  for (const Structure s : all_structures()) {
    LabelMap map;
    map.grid.size = {4, 5, 6};
    map.grid.to_world = Eigen::Affine3d(Eigen::Scaling(Vec3(1e-3, 2e-3, 3e-3)));
    map.voxels.assign(map.grid.count(), 0);
    map.voxels[map.grid.index(0, 2, 2)] = map.voxels[map.grid.index(0, 3, 2)] = label_of(s);
    const bool may = s == Structure::liver || s == Structure::hepatocystic_fat || s == Structure::gallbladder_bed;
    if (!may) {
      EXPECT_THROW(border_cuts(map, {}), InputError) << name_of(s);
      EXPECT_TRUE(border_cuts(map, {s}).empty());
      continue;
    }
    const std::vector<BorderCut> cuts = border_cuts(map, {});
    ASSERT_EQ(cuts.size(), 1u) << name_of(s);
    EXPECT_EQ(cuts[0].structure, s);
    EXPECT_EQ(cuts[0].axis, 0);
    EXPECT_FALSE(cuts[0].upper);
    EXPECT_LT((cuts[0].point - Vec3(-0.5e-3, 5e-3, 6e-3)).norm(), 1e-12);
    EXPECT_NEAR(cuts[0].area, 12e-6, 1e-12);
  }
}

/// A block of fat in the corner of the volume.
void add_fat(Scene& s, std::size_t from, std::size_t to) {
  for (std::size_t k = from; k < to; ++k)
    for (std::size_t j = from; j < to; ++j)
      for (std::size_t i = from; i < to; ++i)
        s.labels.voxels[s.labels.grid.index(i, j, k)] = label_of(Structure::hepatocystic_fat);
}

std::string warnings_of(const Scene& s) {
  CompletionOptions options;
  options.fat = false;
  Progress progress;
  std::string all;
  for (const std::string& warning : complete_anatomy(s.ct, s.labels, s.lines, options, progress).warnings)
    all += warning + '\n';
  return all;
}

TEST(BadCompletion, FatCutByTheBorderIsAWarning) {
  Scene s = scene();
  EXPECT_EQ(warnings_of(s), "");
  add_fat(s, 1, 5);
  EXPECT_EQ(warnings_of(s), "");
  add_fat(s, 0, 4);
  const std::string all = warnings_of(s);
  for (const std::string side : {"left", "back (posterior)", "lower (inferior)"})
    EXPECT_NE(all.find("the hepatocystic fat is cut by the volume's " + side + " end (0.6 cm²)"), std::string::npos)
        << all;
}

TEST(BadCompletion, CleaningThatTakesMuchIsAWarning) {
  Scene s = scene();
  add_fat(s, 1, 6);
  Scene much = s;
  s.labels.voxels[s.labels.grid.index(9, 9, 9)] = label_of(Structure::hepatocystic_fat);  // 1 of 126
  EXPECT_EQ(warnings_of(s), "");
  add_fat(much, 8, 10);  // 8 of 133
  EXPECT_NE(warnings_of(much).find("cleaning took 6 % of the hepatocystic fat (0.064 mL)"), std::string::npos)
      << warnings_of(much);
}

TEST(BadCompletion, LinesOfNoKnownNameOrTwice) {
  Scene bad = scene();
  bad.lines[1].name = "cystic";
  expect_message(bad, {"centreline \"cystic\"", "no duct or artery", "cystic duct, common bile duct"});
  bad.lines[1].name = "liver";
  expect_message(bad, {"centreline \"liver\"", "no duct or artery"});
  bad.lines[1].name = "common bile duct";
  expect_message(bad, {"comes twice"});
}

TEST(BadCompletion, LinesOfBadForm) {
  Scene bad = scene();
  bad.lines[1].radii[1] = 0.1;
  expect_message(bad, {"centreline \"cystic duct\"", "the radius at point 1 isn't in 0.2 … 15 mm"});
  bad = scene();
  bad.lines[1].radii.pop_back();
  expect_message(bad, {"needs two or more points, each with a radius"});
  bad = scene();
  bad.lines[1].points[2][0] = std::nan("");
  expect_message(bad, {"point 2 isn't finite"});
}

TEST(BadCompletion, ALineThatLeavesTheVolume) {
  Scene bad = scene();
  bad.lines[0].points[0][2] -= 0.03;
  expect_message(bad, {"centreline \"common bile duct\"", "leaves the volume through its lower (inferior) end", "RAS"});
  bad = scene();
  bad.lines[0].points[0][0] -= 0.03;
  expect_message(bad, {"through its left end"});
}

TEST(BadCompletion, ALineThatLeavesTheBody) {
  Scene bad = scene();
  const auto& n = bad.ct.grid.size;
  for (std::size_t v = 0; v < n[0] * n[1] * 8; ++v) bad.ct.hounsfield[v] = -1000;  // the lowest 16 mm
  expect_message(bad, {"centreline \"common bile duct\"", "runs through air at (-40.0, 0.0,", "RAS"});
}

TEST(BadCompletion, AnEndThatIsTooFarAway) {
  Scene bad = scene();
  bad.lines[1].points.erase(bad.lines[1].points.begin());
  bad.lines[1].radii.pop_back();
  expect_message(bad, {"centreline \"cystic duct\"", "mm from the gallbladder", "draw it up to the gallbladder"});
  bad = scene();
  bad.lines[1].points.pop_back();
  bad.lines[1].radii.pop_back();
  expect_message(bad, {"centreline \"cystic duct\"", "mm from the bile duct"});
}

TEST(BadCompletion, ALineThatLiesInItsNeighbour) {
  Scene bad = scene();
  bad.lines.push_back({"cystic artery", {{0, 0, 0}, {-0.004, 0, -0.001}, {-0.008, 0, -0.002}}, {1e-3, 1e-3, 1e-3}});
  expect_message(bad, {"centreline \"cystic artery\"", "lies in the gallbladder altogether"});
}

TEST(BadCompletion, OptionsOutOfRange) {
  CompletionOptions options;
  options.spacing = 2e-3;
  expect_message(scene(), {"spacing [m] is 0.002", "0.0003 … 0.001"}, options);
  options = {};
  options.fat_low = 0;
  expect_message(scene(), {"fat_low [HU]"}, options);
}

TEST(BadCompletion, AStopIsHeeded) {
  const Scene s = scene();
  Progress progress;
  progress.request_stop();
  EXPECT_THROW(complete_anatomy(s.ct, s.labels, s.lines, {}, progress), Interrupted);
}

}  // namespace
}  // namespace calot
