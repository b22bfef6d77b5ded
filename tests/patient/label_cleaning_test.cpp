// Cleaning: what is wrong goes, what is right stays.
#include "calot/patient/label_cleaning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calot/patient/random.h"

namespace calot {
namespace {

constexpr std::uint8_t liver = 1, gallbladder = 2, cystic_duct = 3;

struct Space {
  WorkLabels labels;
  std::uint8_t& at(int i, int j, int k) {
    return labels.voxels[labels.grid.index(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                                           static_cast<std::size_t>(k))];
  }
};

/// A ball of liver of radius 22 voxels of 0.7 mm.
Space ball_of_liver() {
  Space space;
  space.labels.grid.size = {56, 56, 56};
  space.labels.grid.to_world = Eigen::Affine3d(Eigen::Scaling(0.7e-3));
  space.labels.voxels.resize(space.labels.grid.count());
  for (int k = 0; k < 56; ++k)
    for (int j = 0; j < 56; ++j)
      for (int i = 0; i < 56; ++i)
        if ((i - 27) * (i - 27) + (j - 27) * (j - 27) + (k - 27) * (k - 27) < 22 * 22) space.at(i, j, k) = liver;
  return space;
}

std::vector<CompletionStep> clean(Space& space, const std::set<Structure>& leave = {}) {
  std::vector<CompletionStep> steps;
  Progress progress;
  clean_labels(space.labels, {}, leave, steps, progress);
  return steps;
}

TEST(LabelCleaning, ASmoothLabelStaysAsItIs) {
  Space space = ball_of_liver();
  const auto before = space.labels.voxels;
  EXPECT_TRUE(clean(space).empty());
  EXPECT_EQ(space.labels.voxels, before);
}

TEST(LabelCleaning, SpecksGoAndSmallHolesAreFilled) {
  Space space = ball_of_liver();
  const auto smooth = space.labels.voxels;
  space.at(1, 1, 1) = space.at(1, 1, 2) = space.at(54, 3, 3) = liver;
  space.at(27, 27, 27) = 0;
  space.at(27, 20, 27) = gallbladder;  // a speck of another in a hole: the gallbladder itself is elsewhere
  for (int i = 2; i < 6; ++i) space.at(i, 50, 50) = gallbladder;
  const std::vector<CompletionStep> steps = clean(space);
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].step, "largest part kept");
  EXPECT_EQ(steps[0].structure, Structure::liver);
  EXPECT_EQ(steps[0].removed, 3u);
  EXPECT_EQ(steps[1].structure, Structure::gallbladder);
  EXPECT_EQ(steps[1].removed, 1u);
  EXPECT_EQ(steps[2].step, "hole filling");
  EXPECT_EQ(steps[2].added, 2u);
  EXPECT_NEAR(steps[2].added_ml, 2 * 0.343e-3, 1e-9);
  for (int i = 2; i < 6; ++i) space.at(i, 50, 50) = 0;
  EXPECT_EQ(space.labels.voxels, smooth);
}

TEST(LabelCleaning, LargeHolesAndThoseOfOtherStructuresStay) {
  Space space = ball_of_liver();
  for (int k = 20; k < 35; ++k)
    for (int j = 20; j < 35; ++j)
      for (int i = 20; i < 45; ++i) space.at(i, j, k) = 0;  // 1.9 mL
  space.at(30, 30, 30) = gallbladder;                       // in it
  const auto before = space.labels.voxels;
  EXPECT_TRUE(clean(space).empty());
  EXPECT_EQ(space.labels.voxels, before);
}

TEST(LabelCleaning, ARaggedLabelIsSmoothedAndTakesNothingFromOthers) {
  Space space = ball_of_liver();
  const auto smooth = space.labels.voxels;
  for (std::size_t v = 0; v < smooth.size(); ++v) {  // salt and pepper near the surface
    const auto& n = space.labels.grid.size;
    const double r = (Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                           static_cast<double>(v / (n[0] * n[1]))) -
                      Vec3(27, 27, 27))
                         .norm();
    if (std::abs(r - 22) < 1.5 && Random(v).uniform() < 0.15)
      space.labels.voxels[v] = space.labels.voxels[v] != 0 ? 0 : liver;
  }
  for (int i = 30; i < 56; ++i)  // a duct beside and inside
    for (int j = 26; j < 29; ++j)
      for (int k = 26; k < 29; ++k) space.at(i, j, k) = cystic_duct;
  const auto difference = [&] {
    std::size_t count = 0;
    for (std::size_t v = 0; v < smooth.size(); ++v)
      count += space.labels.voxels[v] != cystic_duct && space.labels.voxels[v] != smooth[v];
    return count;
  };
  const std::size_t duct = space.labels.count(Structure::cystic_duct), wrong = difference();
  const std::vector<CompletionStep> steps = clean(space);
  EXPECT_TRUE(std::any_of(steps.begin(), steps.end(), [](const CompletionStep& s) {
    return s.step == "opening and closing" && s.structure == Structure::liver;
  }));
  EXPECT_LT(difference(), 2 * wrong / 3);
  EXPECT_EQ(space.labels.count(Structure::cystic_duct), duct);
}

TEST(LabelCleaning, AThinTubeHangsTogetherByCorners) {
  Space space = ball_of_liver();
  for (int i = 0; i < 20; ++i) space.at(2 + i, 2 + i, 2 + i / 2) = cystic_duct;
  clean(space);
  EXPECT_EQ(space.labels.count(Structure::cystic_duct), 20u);
}

TEST(LabelCleaning, ALayerStaysWholeThatThickSlicesCutIntoStrips) {
  constexpr std::uint8_t bed = 9;
  Space space;
  space.labels.grid.size = {60, 20, 10};
  space.labels.grid.to_world = Eigen::Affine3d(Eigen::Scaling(Vec3(0.8e-3, 0.8e-3, 5e-3)));
  space.labels.voxels.resize(space.labels.grid.count());
  for (int k = 0; k < 8; ++k)  // 3.2 mm wide, and 4.8 mm farther in every slice
    for (int j = 2; j < 18; ++j)
      for (int i = 0; i < 4; ++i) space.at(1 + 6 * k + i, j, 1 + k) = bed;
  const auto whole = space.labels.voxels;
  EXPECT_TRUE(clean(space).empty());
  EXPECT_EQ(space.labels.voxels, whole);
  space.at(50, 10, 1) = space.at(50, 11, 1) = bed;  // far off
  const std::vector<CompletionStep> steps = clean(space);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].removed, 2u);
  EXPECT_EQ(space.labels.voxels, whole);
}

TEST(LabelCleaning, ALayerOfCubesHangsTogetherByCornersOnly) {
  Space space = ball_of_liver();
  constexpr std::uint8_t bed = 9;
  for (int j = 2; j < 12; ++j)
    for (int i = 0; i < 10; ++i) space.at(2 + i, j, 2 + i) = bed;
  space.at(13, 5, 13) = bed;  // a voxel between
  clean(space);
  EXPECT_EQ(space.labels.count(Structure::gallbladder_bed), 100u);
  EXPECT_EQ(space.at(13, 5, 13), 0);
}

TEST(LabelCleaning, WhatWillBeRedrawnIsLeft) {
  Space space = ball_of_liver();
  space.at(1, 1, 1) = liver;
  EXPECT_TRUE(clean(space, {Structure::liver}).empty());
}

}  // namespace
}  // namespace calot
