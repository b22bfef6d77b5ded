// Everything wrong with a label map is named, and nothing crashes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "calot/image/label_map.h"
#include "calot/image/nifti.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

using test::TempFolder;

class BadNifti : public testing::Test {
 protected:
  void SetUp() override {
    LabelMap map = test::map_of(test::oblique_grid({5, 6, 7}, {0.001, 0.001, 0.001}),
                                [](int i, int, int) { return static_cast<Label>(i); });
    map.names = {{1, "one"}, {2, "two"}};
    write_label_map(folder_ / "good.nii", map);
    write_label_map(folder_ / "good.nii.gz", map);
    good_ = test::read_bytes(folder_ / "good.nii");
  }

  template <class T>
  std::string with(std::size_t offset, T value) const {
    std::string bytes = good_;
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    return bytes;
  }

  std::string message(const std::string& bytes, const std::string& name = "bad.nii") {
    test::write_bytes(folder_ / name, bytes);
    const std::string text = test::message_of([&] { read_label_map(folder_ / name); });
    EXPECT_NE(text.find(name), std::string::npos) << "names the file: " << text;
    return text;
  }

  void expect(const std::string& bytes, const std::string& part, const std::string& name = "bad.nii") {
    const std::string text = message(bytes, name);
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }

  TempFolder folder_;
  std::string good_;
};

TEST_F(BadNifti, files_that_are_no_nifti) {
  EXPECT_NE(test::message_of([&] { read_label_map(folder_ / "nowhere.nii"); }).find("no such file"), std::string::npos);
  EXPECT_NE(test::message_of([&] { read_label_map(folder_.path()); }).find("folder"), std::string::npos);
  expect("", "too short");
  expect(std::string(400, 'x'), "is not NIfTI");
  expect(with<std::int32_t>(0, 540), "NIfTI-2");
  expect(with(344, std::array<char, 4>{'n', 'i', '1', 0}), "pair");
  expect(good_, "isn't compressed", "bad.nii.gz");
  expect(test::read_bytes(folder_ / "good.nii.gz"), "compressed but", "packed.nii");
}

TEST_F(BadNifti, truncated_and_damaged_files) {
  for (const std::size_t length : {352u, 500u, static_cast<unsigned>(good_.size() - 1)})
    expect(good_.substr(0, length), "truncated");
  const std::string packed = test::read_bytes(folder_ / "good.nii.gz");
  for (std::size_t length = 20; length < packed.size(); length += 37)
    EXPECT_FALSE(message(packed.substr(0, length), "cut.nii.gz").empty()) << length;
  std::string damaged = packed;
  for (std::size_t b = 30; b < damaged.size(); b += 3) damaged[b] = static_cast<char>(damaged[b] ^ 0x5a);
  EXPECT_FALSE(message(damaged, "damaged.nii.gz").empty());
}

TEST_F(BadNifti, shapes_and_types) {
  std::string four = with<std::int16_t>(40, 4);
  const std::int16_t volumes = 3;
  std::memcpy(four.data() + 48, &volumes, 2);
  expect(four, "4 dimensions (3 volumes)");
  expect(with<std::int16_t>(40, 0), "0 dimensions");
  expect(with<std::int16_t>(42, -5), "-5 voxels");
  std::string huge = good_;
  for (std::size_t d = 0; d < 3; ++d) std::memcpy(huge.data() + 42 + 2 * d, "\xff\x7f", 2);
  expect(huge, "2^31");
  expect(with<std::int16_t>(42, 32000), "truncated");
  expect(with<std::int16_t>(70, 128), "type 128");
  expect(with<float>(108, std::nanf("")), "begin at byte");
  expect(with<float>(108, 1e9f), "begin at byte");
}

TEST_F(BadNifti, orientations) {
  std::string none = with<std::int16_t>(252, 0);
  std::memset(none.data() + 254, 0, 2);
  expect(none, "left and right are unknown");
  const float x_of_j = 0.8f;
  expect(with(284, x_of_j), "sheared");
  std::string singular = good_;
  std::memcpy(singular.data() + 296, good_.data() + 280, 16);
  std::memcpy(singular.data() + 312, good_.data() + 280, 16);
  expect(singular, "singular");
  std::string flat = good_;
  for (const std::size_t row : {280u, 296u, 312u}) std::memset(flat.data() + row, 0, 4);
  expect(flat, "axes of no");
  expect(with(280, std::nanf("")), "axes of no");
}

TEST_F(BadNifti, values_that_are_no_labels) {
  std::string floats = with<std::int16_t>(70, 16);
  const std::int16_t bits = 32;
  std::memcpy(floats.data() + 72, &bits, 2);
  const std::size_t begin = good_.size() - 5 * 6 * 7 * 2;
  floats.resize(begin);
  for (int v = 0; v < 5 * 6 * 7; ++v) {
    const float value = v == 100 ? 1.5f : 1.0f;
    floats.append(reinterpret_cast<const char*>(&value), 4);
  }
  expect(floats, "voxel 100 has the value 1.5");
  std::string negative = with<std::int16_t>(70, 4);
  negative[begin + 1] = '\xff';
  expect(negative, "voxel 0 has the value -256");
  expect(with<float>(112, 0.5f), "which is no label");
}

TEST_F(BadNifti, names) {
  std::string bytes = good_;
  bytes.replace(bytes.find("</Label>"), 8, "<Label!>");
  expect(bytes, "aren't well-formed XML");
  bytes = good_;
  bytes.replace(bytes.find("Key=\"1\""), 7, "Key=\"x\"");
  expect(bytes, "key \"x\"");
  expect(with<std::int32_t>(352, 7), "7 bytes");
  expect(with<std::int32_t>(352, 1 << 30), "doesn't fit");
  expect(with<std::int32_t>(352, -16), "-16 bytes");
}

TEST_F(BadNifti, every_single_wrong_byte_is_read_or_refused) {
  const std::size_t voxels = good_.size() - 5 * 6 * 7 * 2;
  int refused = 0;
  for (std::size_t b = 0; b < voxels; ++b)
    for (const int flip : {0x01, 0x80, 0xff}) {
      std::string bytes = good_;
      bytes[b] = static_cast<char>(bytes[b] ^ flip);
      test::write_bytes(folder_ / "flip.nii", bytes);
      refused += test::message_of([&] { read_label_map(folder_ / "flip.nii"); }).empty() ? 0 : 1;
    }
  EXPECT_GT(refused, 100);
}

TEST(LabelMatching, ambiguous_and_empty) {
  LabelMap map = test::map_of(test::oblique_grid({2, 2, 2}, {0.001, 0.001, 0.001}),
                              [](int i, int, int) { return static_cast<Label>(i + 1); });
  map.names = {{1, "duct"}, {2, "duct"}, {3, "liver"}};
  EXPECT_NE(test::message_of([&] { label_matching(map, "duct", "x"); }).find("several"), std::string::npos);
  EXPECT_NE(test::message_of([&] { label_matching(map, "liver", "x"); }).find("no voxels"), std::string::npos);
  EXPECT_NE(test::message_of([&] { label_matching(map, "3", "x"); }).find("no voxels"), std::string::npos);
  EXPECT_NE(test::message_of([&] { label_matching(map, "-1", "x"); }).find("no voxels"), std::string::npos);
}

}  // namespace
}  // namespace calot
