// Segmentations as files bring them: label maps, 3D Slicer's layers, folders of masks, surfaces.
#include "calot/image/segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "calot/mesh/mesh_file.h"
#include "tests/image/hu_field.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

using test::TempFolder;

Progress silent;

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += word + "|";
  return text;
}

bool has_note(const std::vector<std::string>& notes, const std::string& part) {
  return std::any_of(notes.begin(), notes.end(), [&](const auto& n) { return n.find(part) != std::string::npos; });
}

/// The voxel numbers of a segment.
std::vector<std::size_t> voxels_of(const Segmentation& found, const std::string& name) {
  std::vector<std::size_t> voxels;
  for (const Segment& segment : found.segments) {
    if (segment.name != name) continue;
    for (std::size_t v = 0; v < found.layers[segment.layer].size(); ++v)
      if (found.layers[segment.layer][v] == segment.value) voxels.push_back(v);
    EXPECT_EQ(voxels.size(), segment.voxels) << name;
  }
  return voxels;
}

class SegmentationFiles : public testing::Test {
 protected:
  Segmentation read(const std::string& name) { return read_segmentation(folder_ / name, options_, silent); }
  void refused(const std::string& name, const std::string& where, const std::string& part) {
    const std::string text = test::message_of([&] { read(name); });
    EXPECT_TRUE(text.starts_with((folder_ / where).string() + ":")) << text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("; "), std::string::npos) << "says what to do: " << text;
  }
  void write_mask(const std::string& name, const std::function<Label(int, int, int)>& label) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    write_label_map(folder_ / name, test::map_of(grid_, label));
  }

  TempFolder folder_;
  SegmentationOptions options_;
  VoxelGrid grid_ = test::oblique_grid({6, 5, 4}, {0.001, 0.002, 0.003});
};

// ---- label maps

TEST_F(SegmentationFiles, a_nifti_label_map_with_names) {
  LabelMap map = test::map_of(grid_, [](int i, int j, int) { return static_cast<Label>(j == 0 ? 0 : i); });
  map.names = {{1, "liver"}, {3, "duct"}, {4, "ignored"}, {9, "absent"}};
  write_label_map(folder_ / "labels.nii.gz", map);
  options_.wanted = [](const std::string& name) { return name != "ignored"; };
  const Segmentation found = read("labels.nii.gz");
  EXPECT_EQ(found.format, "NIfTI");
  EXPECT_EQ(found.inputs, std::vector<std::string>{(folder_ / "labels.nii.gz").string()});
  ASSERT_EQ(found.layers.size(), 1u);
  std::string text;
  for (const Segment& segment : found.segments)
    text += std::to_string(segment.value) + segment.name + ":" + std::to_string(segment.voxels) + " ";
  EXPECT_EQ(text, "1liver:16 2:16 3duct:16 5:16 ");
  EXPECT_EQ(listed(found.empty), "absent|");
  EXPECT_EQ(listed(found.unread), "ignored|");
  EXPECT_EQ(std::count(found.layers[0].begin(), found.layers[0].end(), 4), 0) << "nobody's voxels are background";
  map.names[3] = "liver";
  write_label_map(folder_ / "twice.nii.gz", map);
  refused("twice.nii.gz", "twice.nii.gz", "names two segments \"liver\" (values 1 and 3)");
}

TEST_F(SegmentationFiles, on_the_ct_grid_in_any_order_of_axes) {
  options_.reference = grid_;
  const auto label_at = [&](const Eigen::Vector3d& place) {  // a label from a place
    const Eigen::Vector3d at = grid_.to_world.inverse() * place;
    return static_cast<Label>(1 + std::lround(at[0]) + 6 * std::lround(at[1]) + 30 * std::lround(at[2]));
  };
  std::array<int, 3> order{0, 1, 2};
  int maps = 0;
  do {
    for (int signs = 0; signs < 8; ++signs, ++maps) {
      LabelMap map;
      Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
      Eigen::Vector3d first = Eigen::Vector3d::Zero();
      for (int d = 0; d < 3; ++d) {
        const int to = order[static_cast<std::size_t>(d)];
        map.grid.size[static_cast<std::size_t>(d)] = grid_.size[static_cast<std::size_t>(to)];
        turn(to, d) = signs >> d & 1 ? -1 : 1;
        if (signs >> d & 1) first[to] = static_cast<double>(grid_.size[static_cast<std::size_t>(to)] - 1);
      }
      map.grid.to_world = grid_.to_world * Eigen::Translation3d(first) * Eigen::Affine3d(turn);
      test::for_each_voxel(map.grid, [&](std::size_t, const auto& place) { map.voxels.push_back(label_at(place)); });
      write_label_map(folder_ / "map.nii.gz", map);
      const Segmentation found = read("map.nii.gz");
      EXPECT_TRUE(grid_difference(found.grid, grid_).empty());
      for (std::size_t v = 0; v < grid_.count(); ++v) ASSERT_EQ(found.layers[0][v], v + 1) << maps;
      EXPECT_EQ(has_note(found.notes, "in another order"), maps > 0);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(maps, 48);
}

TEST_F(SegmentationFiles, another_grid_is_refused_or_resampled) {
  const VoxelGrid fine = test::oblique_grid({16, 14, 12}, {0.0004, 0.0008, 0.0012});
  options_.reference = fine;
  write_mask("coarse.nii.gz", [](int i, int j, int k) { return static_cast<Label>(1 + i + 6 * j + 30 * k); });
  refused("coarse.nii.gz", "coarse.nii.gz",
          "is on another grid than the CT (CT and labels differ: 16 x 14 x 12 voxels against 6 x 5 x 4);");
  options_.resample = true;
  const Segmentation found = read("coarse.nii.gz");
  EXPECT_TRUE(has_note(found.notes, "resampled onto the CT's grid by the nearest voxel; CT and labels differed: 16 x"));
  std::size_t v = 0;
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 14; ++j)
      for (int i = 0; i < 16; ++i, ++v) {
        const auto a = std::lround(0.4 * i), b = std::lround(0.4 * j), c = std::lround(0.4 * k);  // never halves
        ASSERT_EQ(found.layers[0][v], a < 6 && b < 5 && c < 4 ? 1 + a + 6 * b + 30 * c : 0);
      }
  VoxelGrid turned = grid_;
  turned.to_world = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * grid_.to_world;
  options_ = {};
  options_.reference = turned;
  refused("coarse.nii.gz", "coarse.nii.gz", "CT and labels differ: their axes are turned against each other);");
  options_.reference = grid_;
  options_.reference->to_world.translation() -= Eigen::Vector3d(0.0073, 0, 0);
  refused("coarse.nii.gz", "coarse.nii.gz", "CT and labels differ: the second is moved by (7.3, 0, 0) mm);");
}

TEST_F(SegmentationFiles, no_segmentation) {
  refused("nowhere.nii.gz", "nowhere.nii.gz", "no such file");
  refused("nowhere.xyz", "nowhere.xyz", "no such file");
  test::write_bytes(folder_ / "a.txt", "hello");
  refused("a.txt", "a.txt", "is no segmentation that can be read");
  write_ct(folder_ / "ct.nii.gz", {grid_, std::vector<std::int16_t>(grid_.count(), -7)});
  refused("ct.nii.gz", "ct.nii.gz", "voxel 0 has the value -7.000000, which is no label");
}

// ---- 3D Slicer

/// A .seg.nrrd as 3D Slicer writes it: layers interleaved, a list axis first.
std::string seg_nrrd(const std::vector<std::vector<int>>& layers, const std::string& keys, bool old = false) {
  std::string text =
      "NRRD0004\n# Complete NRRD file format specification at:\n# http://teem.sourceforge.net/nrrd/format.html\n";
  const bool list = layers.size() > 1 || old;
  text +=
      "type: unsigned char\ndimension: " + std::string(list ? "4" : "3") + "\nspace: left-posterior-superior\nsizes: ";
  if (list) text += std::to_string(layers.size()) + " ";
  text += "4 3 2\nspace directions: " + std::string(list ? "none " : "") +
          "(1,0,0) (0,1,0) (0,0,2)\nkinds: " + (list ? "list " : "") +
          "domain domain domain\nencoding: raw\nspace origin: (-5,-6,7)\n" + keys + "\n";
  for (std::size_t v = 0; v < 24; ++v)
    for (const auto& layer : layers) text += static_cast<char>(layer[v]);
  return text;
}

std::vector<int> filled(int value, std::size_t begin, std::size_t end) {
  std::vector<int> layer(24);
  std::fill(layer.begin() + static_cast<std::ptrdiff_t>(begin), layer.begin() + static_cast<std::ptrdiff_t>(end),
            value);
  return layer;
}

std::string segment_keys(int n, const std::string& name, int value, int layer,
                         const std::string& extent = "0 3 0 2 0 1") {
  const std::string key = "Segment" + std::to_string(n) + "_";
  return key + "Color:=0.5 0.2 0.1\n" + key + "Extent:=" + extent + "\n" + key + "ID:=Segment_" + std::to_string(n) +
         "\n" + key + "LabelValue:=" + std::to_string(value) + "\n" + key + "Layer:=" + std::to_string(layer) + "\n" +
         key + "Name:=" + name + "\n" + key + "NameAutoGenerated:=0\n" + key +
         "Tags:=Segmentation.Status:inprogress|\n";
}

const std::string common_keys =
    "Segmentation_ContainedRepresentationNames:=Binary labelmap|Closed surface|\n"
    "Segmentation_MasterRepresentation:=Binary labelmap\nSegmentation_ReferenceImageExtentOffset:=0 0 0\n";

TEST_F(SegmentationFiles, slicer_layers_that_overlap) {
  auto first = filled(1, 0, 8);
  std::fill(first.begin() + 10, first.begin() + 14, 2);
  test::write_bytes(
      folder_ / "s.seg.nrrd",
      seg_nrrd({first, filled(1, 6, 12), filled(1, 20, 24)},
               segment_keys(0, "liver", 1, 0) + segment_keys(1, "gall bladder", 2, 0) + segment_keys(2, "duct", 1, 1) +
                   segment_keys(3, "spleen", 1, 2) + segment_keys(4, "nothing", 7, 1, "0 -1 0 -1 0 -1") + common_keys));
  options_.wanted = [](const std::string& name) { return name != "spleen"; };
  const Segmentation found = read("s.seg.nrrd");
  EXPECT_EQ(found.format, "3D Slicer .seg.nrrd");
  EXPECT_EQ(found.layers.size(), 2u) << "a layer with nothing wanted isn't kept";
  EXPECT_EQ(listed(found.unread), "spleen|");
  EXPECT_EQ(listed(found.empty), "nothing|");
  ASSERT_EQ(found.segments.size(), 3u);
  EXPECT_EQ(voxels_of(found, "liver"), (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(voxels_of(found, "gall bladder"), (std::vector<std::size_t>{10, 11, 12, 13}));
  EXPECT_EQ(voxels_of(found, "duct"), (std::vector<std::size_t>{6, 7, 8, 9, 10, 11}));
  EXPECT_LT((found.grid.to_world * Eigen::Vector3d(1, 1, 1) - Eigen::Vector3d(0.004, 0.005, 0.009)).norm(), 1e-12);
  EXPECT_TRUE(found.notes.empty()) << listed(found.notes);
}

TEST_F(SegmentationFiles, slicer_one_layer_extents_and_values_without_a_segment) {
  auto layer = filled(1, 0, 8);
  layer[23] = 5;
  test::write_bytes(folder_ / "s.seg.nrrd",
                    seg_nrrd({layer}, segment_keys(0, "liver", 1, 0, "0 3 0 0 0 1") + common_keys));
  const Segmentation found = read("s.seg.nrrd");
  ASSERT_EQ(found.segments.size(), 2u);
  EXPECT_EQ(found.segments[1].name, "");
  EXPECT_EQ(found.segments[1].value, 5);
  EXPECT_TRUE(has_note(found.notes, "\"liver\" has 4 voxels outside the extent")) << listed(found.notes);
}

TEST_F(SegmentationFiles, slicer_before_4_11_wrote_one_layer_a_segment) {
  test::write_bytes(
      folder_ / "old.seg.nrrd",
      seg_nrrd({filled(1, 0, 8), filled(1, 6, 12)},
               "Segment0_ID:=Segment_1\nSegment0_Name:=liver\nSegment1_ID:=Segment_2\nSegment1_Name:=duct\n"));
  const Segmentation found = read("old.seg.nrrd");
  EXPECT_EQ(voxels_of(found, "liver").size(), 8u);
  EXPECT_EQ(voxels_of(found, "duct"), (std::vector<std::size_t>{6, 7, 8, 9, 10, 11}));
}

TEST_F(SegmentationFiles, slicer_crops_to_the_segments_and_we_put_them_back) {
  VoxelGrid whole;
  whole.size = {9, 8, 7};
  whole.to_world.linear() = Eigen::Vector3d(-0.001, -0.001, 0.002).asDiagonal();
  whole.to_world.translation() =
      whole.to_world.linear() * Eigen::Vector3d(-2, -3, -4) + Eigen::Vector3d(0.005, 0.006, 0.007);
  options_.reference = whole;
  test::write_bytes(folder_ / "crop.seg.nrrd",
                    seg_nrrd({filled(1, 0, 1)}, segment_keys(0, "liver", 1, 0) + common_keys));
  const Segmentation found = read("crop.seg.nrrd");
  EXPECT_EQ(voxels_of(found, "liver"), std::vector<std::size_t>{whole.index(2, 3, 4)});
  EXPECT_TRUE(has_note(found.notes, "put in place"));
  options_.reference->size = {9, 8, 5};
  refused("crop.seg.nrrd", "crop.seg.nrrd", "another grid");
}

TEST_F(SegmentationFiles, bad_slicer_keys) {
  const auto bad = [&](const std::string& keys, const std::string& part, std::size_t layers = 1) {
    test::write_bytes(folder_ / "b.seg.nrrd", seg_nrrd(std::vector(layers, filled(1, 0, 8)), keys));
    refused("b.seg.nrrd", "b.seg.nrrd", part);
  };
  bad(segment_keys(0, "a", 0, 0), "its key Segment0_LabelValue is \"0\"");
  bad("Segment0_ID:=x\nSegment0_LabelValue:=70000\n", "Segment0_LabelValue is \"70000\"");
  bad(segment_keys(0, "a", 1, 1), "its key Segment0_Layer is \"1\", but the file has 1");
  bad("Segment0_ID:=x\nSegment0_Layer:=one\n", "Segment0_Layer is \"one\", not a number");
  bad(segment_keys(0, "a", 1, 0, "1 2 3"), "its key Segment0_Extent is \"1 2 3\", not six whole numbers");
  bad(segment_keys(0, "a", 1, 0) + segment_keys(1, "b", 1, 0), "Segment1_LabelValue is \"1\", the same as segment 0's");
  bad(segment_keys(0, "a", 1, 0) + segment_keys(1, "a", 1, 1), "names two segments \"a\"", 2);
  bad("", "has 2 numbers a voxel (4-D) but names no segments", 2);
}

// ---- folders of masks

TEST_F(SegmentationFiles, a_folder_of_masks_packed_into_few_layers) {
  write_mask("m/a.nii.gz", [](int i, int, int) -> Label { return i < 2; });
  write_mask("m/b.nii", [](int i, int, int) -> Label { return i >= 2 && i < 4 ? 255 : 0; });
  write_mask("m/c.nii.gz", [](int i, int, int) -> Label { return i == 1 || i == 2; });
  write_mask("m/d.nii.gz", [](int i, int, int) -> Label { return i >= 4; });
  write_mask("m/e.nii.gz", [](int, int, int) -> Label { return 0; });
  test::write_bytes(folder_ / "m/spleen.nii.gz", "not even a file that could be read");
  test::write_bytes(folder_ / "m/statistics.json", "{}");
  std::set<std::string> asked;
  options_.wanted = [&](const std::string& name) {
    asked.insert(name);
    return name != "spleen";
  };
  const Segmentation found = read("m");
  EXPECT_EQ(asked, (std::set<std::string>{"a", "b", "c", "d", "e", "spleen"}));
  EXPECT_EQ(found.format, "folder of masks");
  EXPECT_EQ(found.layers.size(), 2u);
  EXPECT_EQ(listed(found.unread) + listed(found.empty), "spleen|e|");
  ASSERT_EQ(found.segments.size(), 4u);
  for (const auto& [name, layer] : {std::pair{"a", 0u}, {"b", 0u}, {"c", 1u}, {"d", 0u}}) {
    EXPECT_EQ(voxels_of(found, name).size(), 40u) << name;
    const auto at =
        std::find_if(found.segments.begin(), found.segments.end(), [&](const auto& s) { return s.name == name; });
    EXPECT_EQ(at->layer, layer) << name;
  }
  EXPECT_EQ(found.inputs.size(), 5u) << "the one turned down isn't an input";
  EXPECT_TRUE(has_note(found.notes, "1 other file passed over, e.g. statistics.json"));
}

TEST_F(SegmentationFiles, masks_are_put_onto_the_ct_grid) {
  VoxelGrid flipped = grid_;
  flipped.to_world = grid_.to_world * Eigen::Translation3d(5, 0, 0) * Eigen::Scaling(-1.0, 1.0, 1.0);
  options_.reference = flipped;
  write_mask("m/a.nii.gz", [](int i, int j, int k) -> Label { return i == 1 && j == 2 && k == 3; });
  EXPECT_EQ(voxels_of(read("m"), "a"), std::vector<std::size_t>{flipped.index(4, 2, 3)});
}

TEST_F(SegmentationFiles, a_label_map_in_a_folder_of_other_names_is_to_be_given_itself) {
  options_.wanted = [](const std::string& name) { return name == "liver"; };
  std::filesystem::create_directory(folder_ / "phantom");
  write_ct(folder_ / "phantom/ct.nii.gz", {grid_, std::vector<std::int16_t>(grid_.count(), -7)});
  test::write_bytes(folder_ / "phantom/damaged.nii.gz", "not even a file that could be read");
  write_mask("phantom/kidney.nii.gz", [](int i, int, int) -> Label { return i < 2; });
  EXPECT_EQ(listed(read("phantom").unread), "ct|damaged|kidney|") << "none of them is a label map";
  const std::string advice = "; give " + (folder_ / "phantom/").string();
  write_mask("phantom/labels.nii.gz", [](int i, int, int) { return static_cast<Label>(i); });
  refused("phantom", "phantom", "labels.nii.gz holds a map of several labels" + advice + "labels.nii.gz itself");
  std::filesystem::remove(folder_ / "phantom/labels.nii.gz");
  test::write_bytes(folder_ / "phantom/a.seg.nrrd", seg_nrrd({filled(1, 0, 3), filled(1, 2, 4)},
                                                             segment_keys(0, "a", 1, 0) + segment_keys(1, "b", 1, 1)));
  refused("phantom", "phantom", "a.seg.nrrd holds a map of several labels" + advice + "a.seg.nrrd itself");
  write_mask("phantom/liver.nii.gz", [](int i, int, int) -> Label { return i < 2; });
  EXPECT_EQ(voxels_of(read("phantom"), "liver").size(), 40u) << "a mask that is wanted is read as before";
}

TEST_F(SegmentationFiles, bad_folders) {
  std::filesystem::create_directories(folder_ / "empty/inner");
  refused("empty", "empty", "holds neither masks (.nii, .nii.gz, .nrrd) nor surfaces");
  write_mask("both/a.nii.gz", [](int, int, int) -> Label { return 1; });
  test::write_bytes(folder_ / "both/b.stl", "");
  refused("both", "both", "holds masks (a.nii.gz) and surfaces (b.stl)");
  write_mask("two/a.nii.gz", [](int, int, int) -> Label { return 1; });
  write_mask("two/a.nii", [](int, int, int) -> Label { return 1; });
  refused("two", "two/a.nii.gz", "is a second file for \"a\", beside a.nii");
  write_mask("grids/a.nii.gz", [](int, int, int) -> Label { return 1; });
  grid_.size[0] = 7;
  write_mask("grids/b.nii.gz", [](int, int, int) -> Label { return 1; });
  refused("grids", "grids/b.nii.gz",
          "is on another grid than a.nii.gz (that and this differ: 6 x 5 x 4 voxels against 7 x 5 x 4);");
  write_mask("map/a.nii.gz", [](int i, int, int) { return static_cast<Label>(i); });
  refused("map", "map/a.nii.gz", "holds the labels 1 and 2, so it is no mask");
  std::filesystem::create_directory(folder_ / "slicer");
  test::write_bytes(folder_ / "slicer/a.seg.nrrd",
                    seg_nrrd({filled(1, 0, 3), filled(1, 2, 4)}, segment_keys(0, "a", 1, 0)));
  refused("slicer", "slicer/a.seg.nrrd", "holds several segments");
}

// ---- surfaces

/// A box between two places in RAS millimetres, as an .obj file.
std::string box_obj(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const std::string& head = "") {
  std::string text = head;
  for (int c = 0; c < 8; ++c) {
    for (int d = 0; d < 3; ++d) text += (d ? " " : "v ") + std::to_string(c >> d & 1 ? high[d] : low[d]);
    text += "\n";
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

TEST_F(SegmentationFiles, surfaces_become_voxels_of_the_ct) {
  VoxelGrid grid;
  grid.size = {20, 20, 20};
  grid.to_world = Eigen::Translation3d(-0.01, 0.01, 0.1) * Eigen::Scaling(0.001, -0.001, 0.001);
  std::filesystem::create_directory(folder_ / "s");
  test::write_bytes(folder_ / "s/liver.obj", box_obj({-5.5, -4.5, 102.5}, {2.5, 3.5, 110.5}));
  test::write_bytes(folder_ / "s/duct.obj", box_obj({-2.5, -3.5, 104.5}, {5.5, 4.5, 108.5}, "# SPACE=LPS\n"));
  test::write_bytes(folder_ / "s/wire.obj", box_obj({1.2, 1.2, 101}, {1.4, 1.4, 109}));
  refused("s", "s/duct.obj", "is a surface, and there is no CT");
  options_.reference = grid;
  const Segmentation found = read("s");
  EXPECT_EQ(found.format, "surfaces");
  EXPECT_EQ(found.layers.size(), 2u);
  EXPECT_EQ(listed(found.empty), "wire|");
  ASSERT_EQ(found.segments.size(), 2u);
  EXPECT_EQ(found.segments[0].name + found.segments[1].name, "ductliver");
  const auto places = [&](const std::string& name) {
    Eigen::AlignedBox3d box;
    for (const std::size_t v : voxels_of(found, name))
      box.extend(1e3 * (grid.to_world * Eigen::Vector3d(static_cast<double>(v % 20), static_cast<double>(v / 20 % 20),
                                                        static_cast<double>(v / 400))));
    return box;
  };
  EXPECT_EQ(voxels_of(found, "liver").size(), 8u * 8u * 8u);
  EXPECT_EQ(voxels_of(found, "duct").size(), 8u * 8u * 4u);
  EXPECT_LT((places("liver").min() - Eigen::Vector3d(-5, -4, 103)).norm(), 1e-9);
  EXPECT_LT((places("duct").min() - Eigen::Vector3d(-5, -4, 105)).norm(), 1e-9) << "x and y turned";
  EXPECT_TRUE(has_note(found.notes, "duct.obj: in LPS"));
  EXPECT_TRUE(has_note(found.notes, "liver.obj: encloses 0.512 mL, 0.512 mL in voxels")) << listed(found.notes);
  const Segmentation single = read("s/liver.obj");
  EXPECT_EQ(voxels_of(single, "liver"), voxels_of(found, "liver"));
  options_.surface_unit = 1e-2;
  refused("s/liver.obj", "s/liver.obj", "lies outside the CT");
}

TEST_F(SegmentationFiles, open_surfaces_and_those_beyond_the_border) {
  VoxelGrid grid;
  grid.size = {20, 20, 20};
  grid.to_world = Eigen::Affine3d(Eigen::Scaling(0.001));
  options_.reference = grid;
  const std::string whole = box_obj({5, 5, 5}, {30, 10, 10});
  test::write_bytes(folder_ / "cut.obj", whole);
  EXPECT_TRUE(has_note(read("cut.obj").notes, "cut.obj: reaches beyond the CT"));
  test::write_bytes(folder_ / "open.obj", whole.substr(0, whole.rfind('f')));
  refused("open.obj", "open.obj", "isn't closed: 4 edges with an odd number of triangles");
}

}  // namespace
}  // namespace calot
