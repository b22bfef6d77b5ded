// Every bad surface file ends in one InputError that says where, what and what to do.
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

struct Bad {
  const char* name;
  std::string ending, bytes;
  std::vector<std::string> expected;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadSurface : public testing::TestWithParam<Bad> {};

TEST_P(BadSurface, IsRefusedWithPlaceAndReason) {
  const TempFolder folder;
  const auto path = folder / ("bad" + GetParam().ending);
  write_bytes(path, GetParam().bytes);
  std::string message;
  try {
    read_surface(path);
  } catch (const InputError& error) {
    message = error.what();
  }
  ASSERT_NE(message, "") << "it was read";
  EXPECT_TRUE(message.starts_with(path.string())) << message;
  EXPECT_NE(message.find("; "), std::string::npos) << "what to do is missing: " << message;
  for (const std::string& piece : GetParam().expected) EXPECT_NE(message.find(piece), std::string::npos) << message;
}

std::string facet(const std::string& third_vertex) {
  return "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex " + third_vertex +
         "\nendloop\nendfacet\nendsolid x\n";
}

std::string ply(const std::string& vertices, const std::string& faces, int faces_announced = 1) {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
         "face " +
         std::to_string(faces_announced) + "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + faces;
}
const std::string three = "0 0 0\n1 0 0\n0 1 0\n";

std::vector<Bad> bad_files() {
  std::string binary = detail::format_stl(boundary_surface(regular_tet()), true, "x");
  std::string nan_stl = binary, huge_stl = binary;
  std::string nan_bytes, huge;
  detail::append_bytes(nan_bytes, std::numeric_limits<float>::quiet_NaN());
  detail::append_bytes(huge, std::uint32_t{0xffffffff});
  nan_stl.replace(84 + 12, 4, nan_bytes);
  huge_stl.replace(80, 4, huge);
  return {
      {"stl_empty", ".stl", "", {"empty"}},
      {"stl_garbage", ".stl", "what is this", {".stl:1:", "solid"}},
      {"stl_no_triangles", ".stl", "solid x\nendsolid x\n", {"no triangles"}},
      {"stl_truncated", ".stl", facet("0 1 0").substr(0, 60), {".stl:"}},
      {"stl_nan", ".stl", facet("0 nan 0"), {".stl:6:", "finite"}},
      {"stl_word", ".stl", facet("0 one 0"), {".stl:6:", "\"one\""}},
      {"stl_keyword", ".stl", "solid x\nfacette normal 0 0 1\n", {".stl:2:", "facette"}},
      {"stl_two_corners", ".stl", facet("1 0 0"), {"triangle 0", "two corners"}},
      {"stl_binary_truncated", ".stl", binary.substr(0, 150), {"byte", "can't fit"}},
      {"stl_binary_head", ".stl", binary.substr(0, 82) + std::string(1, '\0'), {"byte"}},
      {"stl_binary_longer", ".stl", binary + std::string(7, '\0'), {"7 bytes follow"}},
      {"stl_binary_huge", ".stl", huge_stl, {"4294967295 triangles can't fit"}},
      {"stl_binary_nan", ".stl", nan_stl, {"byte 96", "finite"}},
      {"obj_empty", ".obj", "", {"empty"}},
      {"obj_no_faces", ".obj", "v 0 0 0\n", {"no triangles"}},
      {"obj_index", ".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", {".obj:4:", "vertex 4 of 3"}},
      {"obj_zero", ".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", {".obj:4:", "vertex 0"}},
      {"obj_negative", ".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", {".obj:4:", "vertex -4"}},
      {"obj_huge_index", ".obj", "v 0 0 0\nf 1 1 99999999999999999999\n", {".obj:2:", "out of range"}},
      {"obj_two_corners", ".obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", {".obj:3:", "2 corners"}},
      {"obj_short_vertex", ".obj", "v 0 0\n", {".obj:1:"}},
      {"obj_inf", ".obj", "v 0 0 inf\n", {".obj:1:", "finite"}},
      {"obj_same_corner", ".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n", {"two corners"}},
      {"ply_empty", ".ply", "", {"empty"}},
      {"ply_garbage", ".ply", "plywood\n", {".ply:1:"}},
      {"ply_no_end", ".ply", "ply\nformat ascii 1.0\n", {"header's end"}},
      {"ply_no_format", ".ply", "ply\nend_header\n", {"no format"}},
      {"ply_format", ".ply", "ply\nformat binary_pdp_endian 1.0\n", {".ply:2:", "binary_pdp_endian"}},
      {"ply_keyword", ".ply", "ply\nformat ascii 1.0\nelephant 3\n", {".ply:3:", "elephant"}},
      {"ply_type", ".ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty quad x\n", {".ply:4:", "quad"}},
      {"ply_orphan_property", ".ply", "ply\nformat ascii 1.0\nproperty float x\n", {".ply:3:"}},
      {"ply_no_z",
       ".ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
       {"property z"}},
      {"ply_huge_count",
       ".ply",
       "ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\nproperty float y\nproperty float "
       "z\nend_header\n",
       {"can't fit"}},
      {"ply_enormous_count", ".ply", "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n", {".ply:3:"}},
      {"ply_index", ".ply", ply(three, "3 0 1 3\n"), {"triangle 0", "doesn't exist"}},
      {"ply_negative", ".ply", ply(three, "3 0 1 -1\n"), {".ply:13:", "vertex number -1"}},
      {"ply_two_corners", ".ply", ply(three, "2 0 1\n"), {".ply:13:", "2 corners"}},
      {"ply_huge_list", ".ply", ply(three, "250 0 1 2\n"), {".ply:13:", "can't fit"}},
      {"ply_negative_list", ".ply", ply(three, "-3 0 1 2\n"), {".ply:13:", "list"}},
      {"ply_nan", ".ply", ply("0 0 0\n1 nan 0\n0 1 0\n", "3 0 1 2\n"), {".ply:11:", "finite"}},
      {"ply_truncated", ".ply", ply(three, "", 1), {"element \"face\""}},
      {"ply_missing_face", ".ply", ply(three, "3 0 1 2\n", 2), {"the file ends"}},
  };
}

INSTANTIATE_TEST_SUITE_P(Files, BadSurface, testing::ValuesIn(bad_files()),
                         [](const auto& param) { return std::string(param.param.name); });

TEST(BadSurface, TheFilesThatTheOthersSpoilAreGood) {
  EXPECT_EQ(detail::parse_stl(facet("0 1 0"), "x", 1).triangles.size(), 1u);
  EXPECT_EQ(detail::parse_ply(ply(three, "3 0 1 2\n"), "x", 1).triangles.size(), 1u);
}

TEST(SurfaceDialects, ObjWithTexturesNormalsAndNegativeNumbers) {
  const std::string text =
      "# a comment\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvn 0 0 "
      "1\r\n"
      "g region_4\r\nf 1/1/1 2/1/1 3//1 4\r\ng other\r\nf -4 -2/1 -1\r\n";
  const Surface surface = detail::parse_obj(text, "x", 1);
  EXPECT_EQ(surface.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 2, 3}}));
  EXPECT_EQ(surface.regions, (std::vector<std::int32_t>{4, 4, 0}));
}

TEST(SurfaceDialects, PlyBigEndianWithOtherElements) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\ncomment x\nobj_info y\nelement edge 1\nproperty int a\nproperty list uchar "
      "short b\n"
      "element vertex 4\nproperty double x\nproperty uchar red\nproperty float y\nproperty float z\n"
      "element face 1\nproperty uchar flags\nproperty list int uint vertex_index\nend_header\n";
  const auto put = [&](auto value) { detail::append_bytes(bytes, value, true); };
  put(std::int32_t{5});
  put(std::uint8_t{2});
  put(std::int16_t{1});
  put(std::int16_t{2});
  for (int v = 0; v < 4; ++v) {
    put(double(v % 2));
    put(std::uint8_t{200});
    put(float(v / 2));
    put(0.5f);
  }
  put(std::uint8_t{1});
  put(std::int32_t{4});
  for (const std::uint32_t v : {0u, 1u, 3u, 2u}) put(v);
  const Surface surface = detail::parse_ply(bytes, "x", 1);
  ASSERT_EQ(surface.positions.size(), 4u);
  EXPECT_EQ(surface.positions[3], Vec3(1, 1, 0.5));
  EXPECT_EQ(surface.triangles, (std::vector<Triangle>{{0, 1, 3}, {0, 3, 2}}));
}

TEST(SurfaceDialects, StlWithSeveralSolidsAndABinaryOneThatSaysSolid) {
  const std::string one = detail::format_stl(boundary_surface(regular_tet()), false, "x");
  EXPECT_EQ(detail::parse_stl(one + one.substr(0), "x", 1).triangles.size(), 8u);
  std::string binary = detail::format_stl(boundary_surface(regular_tet()), true, "x");
  binary.replace(0, 5, "solid");
  EXPECT_EQ(detail::parse_stl(binary, "x", 1).triangles.size(), 4u);
}

}  // namespace
