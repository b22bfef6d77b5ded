// Segments become structures: by name, by number where a table says so, never by guess.
#include "calot/patient/name_labels.h"

#include <gtest/gtest.h>

#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

/// A 30 × 20 × 10 mm-voxel segmentation with one layer: liver-like 1 … in x < 20, gallbladder-like 2 beyond.
Segmentation two_segments(const std::string& first, const std::string& second) {
  Segmentation s;
  s.grid.size = {30, 20, 10};
  s.grid.to_world = Eigen::Scaling(6e-3) * Eigen::Affine3d::Identity();
  s.layers.emplace_back(s.grid.count());
  std::size_t liver = 0;
  for (std::size_t v = 0; v < s.grid.count(); ++v) {
    s.layers[0][v] = v % 30 < 29 ? 5 : 4;
    liver += v % 30 < 29 ? 1 : 0;
  }
  s.segments = {{second, 4, 0, s.grid.count() - liver, "s"}, {first, 5, 0, liver, "s"}};
  return s;
}

std::string error_of(const Segmentation& s, const NameTable& table, OverlapRule rule = OverlapRule::refuse) {
  return test::message_of([&] { label_structures(s, table, rule, "seg.nii.gz"); });
}

TEST(NameLabels, TakesNamesHoweverTheyAreWritten) {
  const StructureLabels result = label_structures(
      two_segments("LIVER", "Gall_Bladder"),
      [] {
        NameTable t = NameTable::built_in();
        t.names["gall bladder"] = Structure::gallbladder;
        return t;
      }(),
      OverlapRule::refuse, "s");
  const auto counts = voxel_counts(result.labels);
  EXPECT_EQ(counts.at(label_of(Structure::liver)), 5800u);
  EXPECT_EQ(counts.at(label_of(Structure::gallbladder)), 200u);
  EXPECT_EQ(result.labels.names.at(2), "gallbladder");
  ASSERT_EQ(result.segments.size(), 2u);
  EXPECT_NEAR(result.segments[0].ml, 200 * 0.216, 1e-9);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
}

TEST(NameLabels, NumbersAreNeverGuessed) {
  const std::string error = error_of(two_segments("", ""), NameTable::built_in());
  EXPECT_NE(error.find("seg.nii.gz: has numbers without names: 4: 200 voxels, 43.2 mL; 5: 5800 voxels"),
            std::string::npos)
      << error;
  EXPECT_NE(error.find("[numbers]"), std::string::npos);
}

TEST(NameLabels, NumbersThatTheTableNamesAreTaken) {
  NameTable table = NameTable::built_in();
  table.numbers = {{4, Structure::gallbladder}, {5, Structure::liver}};
  const StructureLabels result = label_structures(two_segments("", ""), table, OverlapRule::refuse, "s");
  EXPECT_EQ(voxel_counts(result.labels).at(label_of(Structure::liver)), 5800u);
}

TEST(NameLabels, NumbersDontApplyToNamedSegments) {
  NameTable table = NameTable::built_in();
  table.numbers = {{4, Structure::gallbladder}, {5, Structure::liver}};
  EXPECT_NE(error_of(two_segments("liver", "spleen"), table).find("has no gallbladder among: spleen; liver"),
            std::string::npos);
}

TEST(NameLabels, SaysWhichNamesThereAreWhenOneIsMissing) {
  Segmentation s = two_segments("hepar", "gallbladder");
  s.unread = {"spleen"};
  const std::string error = error_of(s, NameTable::built_in());
  EXPECT_NE(error.find("has no liver among: spleen; gallbladder; hepar"), std::string::npos) << error;
  EXPECT_NE(error.find("[names]"), std::string::npos);
}

TEST(NameLabels, AnEmptyOrganIsCalledEmpty) {
  Segmentation s = two_segments("liver", "other");
  s.empty = {"gallbladder"};
  EXPECT_NE(error_of(s, NameTable::built_in()).find("its gallbladder is empty"), std::string::npos);
}

TEST(NameLabels, AnEmptyOrganIsFoundByTheUsersTable) {
  Segmentation s = two_segments("liver", "other");
  s.empty = {"vesicula"};
  NameTable table = NameTable::built_in();
  table.names["vesicula"] = Structure::gallbladder;
  EXPECT_NE(error_of(s, table).find("its gallbladder is empty"), std::string::npos);
  EXPECT_NE(error_of(s, NameTable::built_in()).find("has no gallbladder among"), std::string::npos);
  s = two_segments("", "");
  s.empty = {"15"};
  table.numbers = {{5, Structure::liver}, {15, Structure::gallbladder}};
  EXPECT_NE(error_of(s, table).find("its gallbladder is empty"), std::string::npos);
}

class Overlapping : public testing::Test {
 protected:
  Overlapping() {
    s_ = two_segments("liver", "gallbladder");
    s_.layers.emplace_back(s_.grid.count());
    for (std::size_t v = 0; v < s_.grid.count(); ++v) s_.layers[1][v] = v % 30 == 28 || v % 30 == 29 ? 1 : 0;
    s_.segments[0] = {"gallbladder", 1, 1, 400, "s"};
  }
  Segmentation s_;
};

TEST_F(Overlapping, IsRefusedNamingBothAndThePlace) {
  const std::string error = error_of(s_, NameTable::built_in());
  EXPECT_NE(error.find("liver and gallbladder overlap in 200 voxels (43.2 mL), first at (168.0, 0.0, 0.0) mm"),
            std::string::npos)
      << error;
  EXPECT_NE(error.find("--overlap smaller"), std::string::npos);
}

TEST_F(Overlapping, GoesToTheSmallerOneWhenAsked) {
  const StructureLabels result = label_structures(s_, NameTable::built_in(), OverlapRule::smaller, "s");
  EXPECT_EQ(voxel_counts(result.labels).at(label_of(Structure::gallbladder)), 400u);
  EXPECT_EQ(voxel_counts(result.labels).at(label_of(Structure::liver)), 5600u);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("the smaller one keeps them"), std::string::npos);
}

TEST_F(Overlapping, TheOrderOfLayersDoesNotMatter) {
  std::swap(s_.layers[0], s_.layers[1]);
  s_.segments[0].layer = 0;
  s_.segments[1].layer = 1;
  const StructureLabels result = label_structures(s_, NameTable::built_in(), OverlapRule::smaller, "s");
  EXPECT_EQ(voxel_counts(result.labels).at(label_of(Structure::gallbladder)), 400u);
}

TEST(NameLabels, TwoHalvesOfALiverBecomeOne) {
  Segmentation s = two_segments("liver", "gallbladder");
  s.layers.emplace_back(s.grid.count());
  s.layers[0][0] = 0;
  s.layers[1][0] = 9;
  s.segments[1].voxels -= 1;
  s.segments.push_back({"left liver", 9, 1, 1, "s"});
  NameTable table = NameTable::built_in();
  table.names["left liver"] = Structure::liver;
  const StructureLabels result = label_structures(s, table, OverlapRule::refuse, "s");
  EXPECT_EQ(voxel_counts(result.labels).at(label_of(Structure::liver)), 5800u);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_EQ(result.warnings[0], "\"liver\" and \"left liver\" are joined to one liver");
}

TEST(NameLabels, AbsurdVolumesAreNoticed) {
  Segmentation s = two_segments("liver", "gallbladder");
  s.grid.to_world = Eigen::Scaling(2e-3) * Eigen::Affine3d::Identity();
  const StructureLabels result = label_structures(s, NameTable::built_in(), OverlapRule::refuse, "s");
  ASSERT_EQ(result.warnings.size(), 2u);
  EXPECT_NE(result.warnings[0].find("the liver has 46.4 mL, adults have 500 to 4000"), std::string::npos);
  EXPECT_NE(result.warnings[1].find("the gallbladder has 1.6 mL, adults have 5 to 300"), std::string::npos);
}

TEST(NameLabels, AGallbladderLargerThanTheLiverIsRefused) {
  EXPECT_EQ(
      error_of(two_segments("gallbladder", "liver"), NameTable::built_in()),
      "seg.nii.gz: the gallbladder (1253 mL) is larger than the liver (43.2 mL); exchange them in labels.toml, or "
      "check the numbers");
  // Overlaps count as they are resolved: here the whole liver goes to a gallbladder of as many voxels.
  Segmentation s = two_segments("liver", "gallbladder");
  const std::size_t all = s.grid.count();
  s.layers = {std::vector<Label>(all, 1), std::vector<Label>(all, 5)};
  s.segments = {{"gallbladder", 1, 0, all, "s"}, {"liver", 5, 1, all, "s"}};
  EXPECT_NE(error_of(s, NameTable::built_in(), OverlapRule::smaller).find("is larger than the liver (0 mL)"),
            std::string::npos);
}

}  // namespace
}  // namespace calot
