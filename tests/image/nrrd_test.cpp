// NRRD headers written by hand: what they may say, and what is wrong with them.
#include "calot/image/nrrd.h"

#include <gtest/gtest.h>

#include "calot/image/ct_file.h"
#include "tests/support/files.h"

namespace calot {
namespace {

using test::TempFolder;

Progress silent;

/// The fields of a good header, one a line, before a test changes them.
std::map<std::string, std::string> good_fields() {
  return {{"dimension", "3"},
          {"sizes", "2 3 4"},
          {"type", "short"},
          {"endian", "little"},
          {"encoding", "raw"},
          {"space", "left-posterior-superior"},
          {"space directions", "(1,0,0) (0,2,0) (0,0,3)"},
          {"space origin", "(10,20,30)"},
          {"kinds", "domain domain domain"}};
}

std::string header_of(const std::map<std::string, std::string>& fields, const std::string& end = "\n") {
  std::string text = "NRRD0004" + end + "# a comment" + end;
  for (const auto& [field, value] : fields)
    if (!value.empty()) text += field + ": " + value + end;
  return text;
}

/// 24 numbers from −500 up.
std::string voxels(bool big = false) {
  std::string bytes;
  for (int v = 0; v < 24; ++v) {
    const auto value = static_cast<std::uint16_t>(-500 + 100 * v);
    const auto low = static_cast<char>(value & 255), high = static_cast<char>(value >> 8);
    bytes += big ? high : low;
    bytes += big ? low : high;
  }
  return bytes;
}

class Nrrd : public testing::Test {
 protected:
  CtImage read(const std::map<std::string, std::string>& changes, const std::string& data = voxels(),
               const std::string& end = "\n") {
    auto fields = good_fields();
    for (const auto& [field, value] : changes) fields[field] = value;
    test::write_bytes(folder_ / "a.nrrd", header_of(fields, end) + end + data);
    return read_ct(folder_ / "a.nrrd", silent).ct;
  }
  void expect_same(const CtImage& ct) {
    const CtImage good = read({});
    EXPECT_EQ(ct.hounsfield, good.hounsfield);
    EXPECT_LT((ct.grid.to_world.matrix() - good.grid.to_world.matrix()).norm(), 1e-12);
  }
  void refused(const std::map<std::string, std::string>& changes, const std::string& part,
               const std::string& data = voxels()) {
    const std::string text = test::message_of([&] { read(changes, data); });
    EXPECT_NE(text.find("a.nrrd"), std::string::npos) << text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("; "), std::string::npos) << "says what to do: " << text;
  }
  TempFolder folder_;
};

TEST_F(Nrrd, places_and_values) {
  const CtImage ct = read({});
  EXPECT_EQ(ct.grid.size, (std::array<std::size_t, 3>{2, 3, 4}));
  EXPECT_LT((ct.grid.to_world * Eigen::Vector3d(1, 1, 1) - Eigen::Vector3d(-0.011, -0.022, 0.033)).norm(), 1e-12);
  EXPECT_EQ(ct.hounsfield.front(), -500);
  EXPECT_EQ(ct.hounsfield.back(), 1800);
}

TEST_F(Nrrd, other_ways_to_say_the_same) {
  expect_same(
      read({{"space", "RAS"}, {"space directions", "(-1,0,0) (0,-2,0) (0,0,3)"}, {"space origin", "(-10,-20,30)"}}));
  expect_same(read({{"space", "left-anterior-superior"},
                    {"space directions", "( 1, 0 ,0 ) (0,-2e0,0)  (0,0,+3.0)"},
                    {"space origin", "(10,-20,30)"}}));
  expect_same(read({{"endian", "big"}}, voxels(true)));
  expect_same(read({{"type", "INT16"}}));
  expect_same(read({}, voxels(), "\r\n"));
  expect_same(read({{"line skip", "2"}}, "one\ntwo\n" + voxels()));
  expect_same(read({{"byte skip", "5"}}, "12345" + voxels()));
  expect_same(read({{"byte skip", "-1"}}, "something before" + voxels()));
  expect_same(read({{"kinds", ""}}));
  expect_same(read({{"space units", "\"mm\" \"mm\" \"mm\""}}));
  expect_same(read({{"space units", "\"cm\" \"cm\" \"cm\""},
                    {"space directions", "(0.1,0,0) (0,0.2,0) (0,0,0.3)"},
                    {"space origin", "(1,2,3)"}}));
  expect_same(read({{"dimension", "4"},
                    {"sizes", "1 2 3 4"},
                    {"kinds", "list domain domain domain"},
                    {"space directions", "none (1,0,0) (0,2,0) (0,0,3)"}}));
}

TEST_F(Nrrd, a_detached_header) {
  auto fields = good_fields();
  fields["data file"] = "numbers.raw";
  test::write_bytes(folder_ / "b.nhdr", header_of(fields));
  test::write_bytes(folder_ / "numbers.raw", voxels());
  const CtFile file = read_ct(folder_ / "b.nhdr", silent);
  EXPECT_EQ(file.inputs, (std::vector<std::string>{(folder_ / "b.nhdr").string(), (folder_ / "numbers.raw").string()}));
  expect_same(file.ct);
  std::filesystem::remove(folder_ / "numbers.raw");
  EXPECT_NE(test::message_of([&] { read_ct(folder_ / "b.nhdr", silent); }).find("numbers.raw: no such file"),
            std::string::npos);
  test::write_bytes(folder_ / "c.nhdr", header_of(good_fields()));
  EXPECT_NE(test::message_of([&] { read_ct(folder_ / "c.nhdr", silent); }).find("c.nhdr: has no field \"data file\""),
            std::string::npos);
}

TEST_F(Nrrd, bad_headers) {
  refused({{"dimension", "2"}}, "its field \"dimension\" says 2");
  refused({{"dimension", "x"}}, "a.nrrd:3: its field \"dimension\" isn't 1 whole numbers: \"x\"");
  refused(
      {{"dimension", "4"}, {"sizes", "2 2 3 4"}, {"space directions", "none (1,0,0) (0,2,0) (0,0,3)"}, {"kinds", ""}},
      "2 numbers a voxel", voxels() + voxels());
  refused({{"dimension", "4"}, {"sizes", "2 2 3 4"}, {"space directions", "(1,0,0) (0,2,0) (0,0,3) (0,0,4)"}},
          "four axes in space");
  refused({{"sizes", "2 3"}}, "its field \"sizes\"");
  refused({{"sizes", "2 3 0"}}, "its field \"sizes\" has 0 along axis 2");
  refused({{"sizes", "2000000 30000 4000"}}, "more than 2^31 voxels");
  refused({{"sizes", "99999999999999999999 1 1"}}, "its field \"sizes\"");
  refused({{"type", "block"}}, "its field \"type\" is \"block\"");
  refused({{"type", ""}}, "has no field \"type\"");
  refused({{"endian", ""}}, "has no field \"endian\"");
  refused({{"endian", "middle"}}, "its field \"endian\" is \"middle\"");
  refused({{"encoding", "bzip2"}}, "its field \"encoding\" is \"bzip2\"");
  refused({{"encoding", "gzip"}}, "isn't compressed");
  refused({{"encoding", "gzip"}}, "damaged", "\x1f\x8b\x08" + std::string(200, 'x'));
  refused({{"space", ""}}, "has no field \"space\"; left and right are unknown");
  refused({{"space", "scanner-xyz"}}, "its field \"space\" is \"scanner-xyz\"");
  refused({{"space directions", ""}}, "has no field \"space directions\"");
  refused({{"space directions", "(1,0,0) (0,2,0)"}}, "its field \"space directions\" has no vector");
  refused({{"space directions", "(1,0,0) (0,2,0) none"}}, "less than three axes");
  refused({{"space directions", "(1,0,0) (0,2,0) (0,nan,3)"}}, "axes of no or absurd length");
  refused({{"space directions", "(1,0,0) (0,2,0) (0,1,3)"}}, "sheared");
  refused({{"space directions", "(1,0,0) (0,2,0) (0,0,3) (0,0,4)"}}, "more vectors than axes");
  refused({{"space origin", ""}}, "has no field \"space origin\"");
  refused({{"space origin", "(1,2)"}}, "its field \"space origin\"");
  refused({{"space units", "\"in\" \"in\" \"in\""}}, "its field \"space units\"");
  refused({{"kinds", "domain domain 3-color"}}, "its field \"kinds\" says that axis 2 is \"3-color\"");
  refused({{"kinds", "domain domain"}}, "doesn't name every axis");
  refused({{"byte skip", "-2"}}, "its field \"byte skip\" is -2");
  refused({{"data file", "/etc/passwd"}}, "not beside the header");
  refused({{"data file", "../numbers.raw"}}, "not beside the header");
  refused({{"data file", "slice%03d.raw 1 9 1"}}, "several files");
  refused({{"data file", "LIST"}}, "several files");
  refused({{"content", "a\nno field at all"}}, "a line that is no field: \"no field at all\"");
  refused({{"content", "a\ntype: short"}}, "gives the field \"type\" twice");
  refused({{"content", "a\nk:=1\nk:=2"}}, "gives the key \"k\" twice");
  refused({}, "truncated", voxels().substr(0, 47));
  refused({{"byte skip", "100"}}, "truncated");
  refused({{"byte skip", "-1"}}, "truncated", voxels().substr(2));
}

TEST_F(Nrrd, files_that_are_none) {
  for (const std::string& bytes :
       {std::string(), std::string("PNG"), std::string("NRRD0009\n\n"), std::string(300000, 'x')}) {
    test::write_bytes(folder_ / "a.nrrd", bytes);
    const std::string text = test::message_of([&] { read_ct(folder_ / "a.nrrd", silent); });
    EXPECT_TRUE(text.find("is not NRRD") != std::string::npos || text.find("is empty") != std::string::npos) << text;
  }
}

TEST_F(Nrrd, every_single_wrong_byte_of_a_header_is_read_or_refused) {
  auto fields = good_fields();
  fields["a:=b\\n\\\\"] = " ";
  const std::string good = header_of(fields) + "\n" + voxels();
  int refusals = 0;
  for (std::size_t b = 0; b < good.size() - 48; ++b)
    for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
      std::string bytes = good;
      bytes[b] = static_cast<char>(bytes[b] ^ flip);
      test::write_bytes(folder_ / "a.nrrd", bytes);
      refusals += test::message_of([&] { read_ct(folder_ / "a.nrrd", silent); }).empty() ? 0 : 1;
    }
  EXPECT_GT(refusals, 300);
}

}  // namespace
}  // namespace calot
