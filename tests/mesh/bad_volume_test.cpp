// Every bad volume file ends in one InputError that says where, what and what to do.
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

/// A small .msh 2.2 file, with parts that a test exchanges.
std::string msh(const std::string& nodes, const std::string& elements) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "$EndNodes\n$Elements\n" + elements +
         "$EndElements\n";
}
const std::string four_nodes = "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
const std::string one_tet = "1\n1 4 2 9 1 1 2 3 4\n";

std::string vtk(const std::string& points, const std::string& cells, const std::string& types = "CELL_TYPES 1\n10\n") {
  return "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n" + points + cells + types;
}
const std::string vtk_points = "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n";
const std::string vtk_cells = "CELLS 1 5\n4 0 1 2 3\n";

std::string vtu(const std::string& points, const std::string& connectivity, const std::string& types = "10",
                const std::string& offsets = "4") {
  return "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n<Points>\n"
         "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n" +
         points +
         "</DataArray>\n</Points>\n<Cells>\n"
         "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n" +
         connectivity +
         "</DataArray>\n"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n" +
         offsets +
         "</DataArray>\n"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n" +
         types +
         "</DataArray>\n"
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}
const std::string vtu_points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

struct Bad {
  const char* name;
  std::string ending, bytes;
  std::vector<std::string> expected;  ///< pieces of the message
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadVolume : public testing::TestWithParam<Bad> {};

TEST_P(BadVolume, IsRefusedWithPlaceAndReason) {
  const TempFolder folder;
  const auto path = folder / ("bad" + GetParam().ending);
  write_bytes(path, GetParam().bytes);
  std::string message;
  try {
    read_mesh(path);
  } catch (const InputError& error) {
    message = error.what();
    EXPECT_EQ(error.exit_code(), 2);
  }
  ASSERT_NE(message, "") << "it was read";
  EXPECT_TRUE(message.starts_with(path.string())) << message;
  EXPECT_NE(message.find("; "), std::string::npos) << "what to do is missing: " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  for (const std::string& piece : GetParam().expected) EXPECT_NE(message.find(piece), std::string::npos) << message;
}

std::vector<Bad> bad_msh() {
  const std::string huge_4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 18446744073709551615 1 4\n3 1 0 4\n";
  return {
      {"msh_empty", ".msh", "", {"empty"}},
      {"msh_garbage",
       ".msh",
       "\x7f"
       "ELF\x02\x01 some program",
       {".msh:1:"}},
      {"msh_only_head", ".msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", {"$Nodes"}},
      {"msh_truncated_node", ".msh", msh(four_nodes, one_tet).substr(0, 55), {".msh:", "$Nodes"}},
      {"msh_truncated_element", ".msh", msh(four_nodes, "1\n1 4 2 9 1 1 2").substr(0, 110), {".msh:13:", "$Elements"}},
      {"msh_unended", ".msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\nno end", {"$Comments", "doesn't end"}},
      {"msh_huge_node_count", ".msh", msh("99999999\n1 0 0 0\n", one_tet), {".msh:5:", "99999999 nodes can't fit"}},
      {"msh_enormous_node_count", ".msh", msh("18446744073709551615\n1 0 0 0\n", one_tet), {".msh:5:"}},
      {"msh_overflowing_count", ".msh", msh("184467440737095516150\n", one_tet), {".msh:5:", "out of range"}},
      {"msh_negative_count", ".msh", msh("-4\n", one_tet), {".msh:5:"}},
      {"msh_huge_element_count",
       ".msh",
       msh(four_nodes, "888888888\n1 4 0 1 2 3 4\n"),
       {"888888888 elements can't fit"}},
      {"msh_huge_tag_count", ".msh", msh(four_nodes, "1\n1 4 2147483647 9 1 1 2 3 4\n"), {".msh:13:"}},
      {"msh_negative_tag_count", ".msh", msh(four_nodes, "1\n1 4 -1 1 2 3 4\n"), {".msh:13:", "negative"}},
      {"msh_index", ".msh", msh(four_nodes, "1\n1 4 2 9 1 1 2 3 5\n"), {".msh:13:", "node 5"}},
      {"msh_index_zero", ".msh", msh(four_nodes, "1\n1 4 2 9 1 0 1 2 3\n"), {"node 0"}},
      {"msh_negative_index", ".msh", msh(four_nodes, "1\n1 4 2 9 1 -1 1 2 3\n"), {"node number -1"}},
      {"msh_node_twice", ".msh", msh("4\n1 0 0 0\n2 1 0 0\n2 0 1 0\n4 0 0 1\n", one_tet), {"node 2 is given twice"}},
      {"msh_nan", ".msh", msh("4\n1 0 0 0\n2 1 nan 0\n3 0 1 0\n4 0 0 1\n", one_tet), {".msh:7:", "finite"}},
      {"msh_infinite", ".msh", msh("4\n1 0 0 0\n2 1 0 -inf\n3 0 1 0\n4 0 0 1\n", one_tet), {".msh:7:", "finite"}},
      {"msh_overflow",
       ".msh",
       msh("4\n1 0 0 0\n2 1 0 1e999\n3 0 1 0\n4 0 0 1\n", one_tet),
       {".msh:7:", "out of range"}},
      {"msh_word", ".msh", msh("4\n1 0 0 0\n2 1 0 zero\n3 0 1 0\n4 0 0 1\n", one_tet), {".msh:7:", "\"zero\""}},
      {"msh_coincident",
       ".msh",
       msh("4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 0 0\n", one_tet),
       {"1 vertex at exactly the place of an earlier one (3)"}},
      {"msh_twice_over",
       ".msh",
       msh("8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 0\n6 0 0 0\n7 0 1 0\n8 0 0 1\n",
           "2\n1 4 2 9 1 1 2 3 4\n2 4 2 9 1 5 7 6 8\n"),
       {"1 repeated tet (1)", "4 vertices at exactly the place of an earlier one (4, 5, 6, 7)"}},
      {"msh_overlapping",
       ".msh",
       msh("9\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n6 0 0 0\n7 1 0 0\n8 0 1 0\n9 0.1 0.1 2\n",
           "3\n1 4 2 9 1 1 2 3 4\n2 4 2 9 1 1 3 2 5\n3 4 2 9 1 6 7 8 9\n"),
       {"3 tets at faces that three or more tets share (0, 1, 2)"}},
      {"msh_flat", ".msh", msh("4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n", one_tet), {"1 zero-volume tet (0)"}},
      {"msh_repeated_vertex", ".msh", msh(four_nodes, "1\n1 4 2 9 1 1 2 3 3\n"), {"naming a vertex twice"}},
      {"msh_inverted",
       ".msh",
       msh("5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n", "2\n1 4 2 9 1 1 2 3 4\n2 4 2 9 1 1 2 3 5\n"),
       {"1 inverted tet (1)"}},
      {"msh_same_tet_twice",
       ".msh",
       msh(four_nodes, "2\n1 4 2 9 1 1 2 3 4\n2 4 2 9 1 1 2 3 4\n"),
       {"1 repeated tet (1)"}},
      {"msh_unknown_type", ".msh", msh(four_nodes, "1\n1 77 2 9 1 1 2 3 4\n"), {".msh:13:", "unknown element type 77"}},
      {"msh_hexahedron", ".msh", msh(four_nodes, "1\n1 5 2 9 1 1 2 3 4 1 2 3 4\n"), {".msh:13:", "hexahedra"}},
      {"msh_second_order", ".msh", msh(four_nodes, "1\n1 11 2 9 1 1 2 3 4 1 2 3 4 1 2\n"), {"second-order tetrahedra"}},
      {"msh_no_tets", ".msh", msh(four_nodes, "1\n1 2 2 9 1 1 2 3\n"), {"no tetrahedra", "1 triangles ignored"}},
      {"msh_elements_first",
       ".msh",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Elements\n" + one_tet + "$EndElements\n",
       {"before $Nodes"}},
      {"msh_nodes_twice", ".msh", msh(four_nodes + "$EndNodes\n$Nodes\n" + four_nodes, one_tet), {"second $Nodes"}},
      {"msh_version_1", ".msh", "$NOD\n4\n1 0 0 0\n", {"before $MeshFormat"}},
      {"msh_version_4_0", ".msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", {"version \"4\"", "2.2 or 4.1"}},
      {"msh_version_9", ".msh", "$MeshFormat\n9.7 0 8\n$EndMeshFormat\n", {".msh:2:", "9.7"}},
      {"msh_data_size", ".msh", "$MeshFormat\n2.2 0 4\n$EndMeshFormat\n", {"data size 4"}},
      {"msh_wrong_end", ".msh", msh(four_nodes + "5 0 0 9\n", one_tet), {"$EndNodes expected"}},
      {"msh_bad_name",
       ".msh",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 4 nameless\n$EndPhysicalNames\n",
       {"quotes"}},
      {"msh_huge_4", ".msh", huge_4, {".msh:5:", "can't fit"}},
      {"msh_partitioned", ".msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PartitionedEntities\n", {"partition"}},
  };
}

std::vector<Bad> bad_vtk() {
  return {
      {"vtk_empty", ".vtk", "", {"empty"}},
      {"vtk_garbage", ".vtk", "hello, world\n\n\n", {".vtk:1:", "not a legacy .vtk file"}},
      {"vtk_version", ".vtk", "# vtk DataFile Version 7.3\nx\nASCII\n", {"version"}},
      {"vtk_truncated", ".vtk", vtk(vtk_points, vtk_cells).substr(0, 95), {".vtk:", "POINTS"}},
      {"vtk_no_cells", ".vtk", vtk(vtk_points, "", ""), {"no tetrahedra"}},
      {"vtk_no_points", ".vtk", vtk("", vtk_cells), {"no POINTS"}},
      {"vtk_no_types", ".vtk", vtk(vtk_points, vtk_cells, ""), {"1 cells but 0 cell types"}},
      {"vtk_huge_points", ".vtk", vtk("POINTS 1000000000 double\n0 0 0\n", vtk_cells), {".vtk:5:", "can't fit"}},
      {"vtk_enormous_points", ".vtk", vtk("POINTS 18446744073709551615 double\n0 0 0\n", vtk_cells), {".vtk:5:"}},
      {"vtk_huge_cells", ".vtk", vtk(vtk_points, "CELLS 1 4000000000\n4 0 1 2 3\n"), {"can't fit"}},
      {"vtk_index", ".vtk", vtk(vtk_points, "CELLS 1 5\n4 0 1 2 4\n"), {"vertex 4 of 4"}},
      {"vtk_negative_index", ".vtk", vtk(vtk_points, "CELLS 1 5\n4 0 1 2 -1\n"), {"vertex -1"}},
      {"vtk_cell_overrun", ".vtk", vtk(vtk_points, "CELLS 1 5\n5 0 1 2 3\n"), {"cell 0 runs over"}},
      {"vtk_negative_size", ".vtk", vtk(vtk_points, "CELLS 1 5\n-4 0 1 2 3\n"), {"cell 0 runs over"}},
      {"vtk_cells_left", ".vtk", vtk(vtk_points, "CELLS 1 6\n4 0 1 2 3 0\n"), {"CELLS holds 6"}},
      {"vtk_tet_of_three",
       ".vtk",
       vtk(vtk_points, "CELLS 1 4\n3 0 1 2\n"),
       {"cell 0 has 3 vertices, tetrahedra have 4"}},
      {"vtk_unknown_type", ".vtk", vtk(vtk_points, vtk_cells, "CELL_TYPES 1\n99\n"), {"unknown element type 99"}},
      {"vtk_type_300", ".vtk", vtk(vtk_points, vtk_cells, "CELL_TYPES 1\n300\n"), {"unknown type 300"}},
      {"vtk_hexahedra", ".vtk", vtk(vtk_points, vtk_cells, "CELL_TYPES 1\n12\n"), {"hexahedra"}},
      {"vtk_second_order", ".vtk", vtk(vtk_points, vtk_cells, "CELL_TYPES 1\n24\n"), {"second-order"}},
      {"vtk_nan", ".vtk", vtk("POINTS 4 double\n0 0 0 1 nan 0 0 1 0 0 0 1\n", vtk_cells), {"point 1", "finite"}},
      {"vtk_polydata", ".vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n", {".vtk:4:", "POLYDATA"}},
      {"vtk_keyword", ".vtk", vtk(vtk_points, "CEELLS 1 5\n"), {"\"CEELLS\""}},
      {"vtk_regions_short",
       ".vtk",
       vtk(vtk_points, vtk_cells) + "CELL_DATA 2\nSCALARS region int 1\nLOOKUP_TABLE default\n1 2\n",
       {"2 regions for 1 cells"}},
      {"vtk_region_fraction",
       ".vtk",
       vtk(vtk_points, vtk_cells) + "CELL_DATA 1\nSCALARS region float 1\nLOOKUP_TABLE default\n1.5\n",
       {"whole 32-bit numbers"}},
      {"vtk_region_nan",
       ".vtk",
       vtk(vtk_points, vtk_cells) + "CELL_DATA 1\nSCALARS region float 1\nLOOKUP_TABLE default\nnan\n",
       {"whole 32-bit numbers"}},
      {"vtk_names_without_ids",
       ".vtk",
       vtk(vtk_points, vtk_cells) + "FIELD FieldData 1\nregion_names 1 2 unsigned_char\n65 0\n",
       {"region_ids"}},
      {"vtk_product_overflow",
       ".vtk",
       vtk(vtk_points, vtk_cells) + "FIELD FieldData 1\nx 4294967296 4294967296 double\n1\n",
       {"more than"}},
      {"vtk_attribute_first", ".vtk", vtk(vtk_points, vtk_cells) + "SCALARS region int\n1\n", {"before CELL_DATA"}},
      {"vtk_binary_type",
       ".vtk",
       "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 quadruple\n........",
       {"byte", "quadruple"}},
      {"vtk_binary_short",
       ".vtk",
       "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n........",
       {"byte", "can't fit"}},
      {"vtk_coincident",
       ".vtk",
       vtk("POINTS 4 double\n0 0 0 1 0 0 0 1 0 1 0 0\n", vtk_cells),
       {"place of an earlier one"}},
      {"vtk_offsets",
       ".vtk",
       "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n" + vtk_points +
           "CELLS 2 4\nOFFSETS vtktypeint64\n0 9\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n",
       {"outside the connectivity"}},
  };
}

std::vector<Bad> bad_vtu() {
  const std::string good = vtu(vtu_points, "0 1 2 3");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const auto binary_points = [&](const std::string& attributes, const std::string& content) {
    std::string text = good;
    const std::string from = "format=\"ascii\">\n" + vtu_points;
    text.replace(text.find(from), from.size(), "format=\"binary\">" + content);
    text.replace(text.find("byte_order"), 0, attributes + " ");
    return text;
  };
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  return {
      {"vtu_empty", ".vtu", "", {"empty"}},
      {"vtu_garbage", ".vtu", "\x01\x02\x03<<<", {".vtu:1:", "not XML"}},
      {"vtu_truncated", ".vtu", good.substr(0, 300), {".vtu:", "not XML"}},
      {"vtu_other_xml", ".vtu", "<html></html>", {"no <VTKFile>"}},
      {"vtu_polydata", ".vtu", "<VTKFile type=\"PolyData\"><PolyData/></VTKFile>", {"PolyData"}},
      {"vtu_no_piece", ".vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid/></VTKFile>", {"no tetrahedra"}},
      {"vtu_point_count",
       ".vtu",
       changed("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\""),
       {".vtu:5:", "12 coordinates for 5 points"}},
      {"vtu_huge_count", ".vtu", changed("NumberOfPoints=\"4\"", "NumberOfPoints=\"99999999999999\""), {".vtu:3:"}},
      {"vtu_no_count", ".vtu", changed("NumberOfPoints=\"4\"", ""), {".vtu:3:", "NumberOfPoints"}},
      {"vtu_cell_count", ".vtu", changed("NumberOfCells=\"1\"", "NumberOfCells=\"7\""), {"1 cell types for 7 cells"}},
      {"vtu_index", ".vtu", vtu(vtu_points, "0 1 2 4"), {"vertex 4 of 4"}},
      {"vtu_negative_index", ".vtu", vtu(vtu_points, "0 1 2 -9"), {"vertex -9"}},
      {"vtu_nan", ".vtu", vtu("0 0 0\n1 nan 0\n0 1 0\n0 0 1\n", "0 1 2 3"), {".vtu:5:", "point 1", "finite"}},
      {"vtu_word", ".vtu", vtu("0 0 0\n1 zero 0\n0 1 0\n0 0 1\n", "0 1 2 3"), {".vtu:7:", "zero"}},
      {"vtu_offset", ".vtu", vtu(vtu_points, "0 1 2 3", "10", "5"), {"outside the connectivity"}},
      {"vtu_negative_offset", ".vtu", vtu(vtu_points, "0 1 2 3", "10", "-4"), {"outside the connectivity"}},
      {"vtu_unknown_type", ".vtu", vtu(vtu_points, "0 1 2 3", "200"), {"unknown element type 200"}},
      {"vtu_prism", ".vtu", vtu(vtu_points, "0 1 2 3", "13"), {"prisms"}},
      {"vtu_second_order", ".vtu", vtu(vtu_points, "0 1 2 3", "24"), {"second-order"}},
      {"vtu_triangle_only", ".vtu", vtu(vtu_points, "0 1 2", "5", "3"), {"no tetrahedra", "1 triangles"}},
      {"vtu_flat", ".vtu", vtu("0 0 0\n1 0 0\n0 1 0\n1 1 0\n", "0 1 2 3"), {"zero-volume"}},
      {"vtu_coincident", ".vtu", vtu("0 0 0\n1 0 0\n0 1 0\n0 0 0\n", "0 1 2 3"), {"place of an earlier one"}},
      {"vtu_format", ".vtu", changed("format=\"ascii\"", "format=\"carved\""), {"\"carved\""}},
      {"vtu_type", ".vtu", changed("format=\"ascii\"", "format=\"binary\""), {"<DataArray>"}},
      {"vtu_no_base64", ".vtu", binary_points("", "AAAA!!!!"), {"base64"}},
      {"vtu_base64_short", ".vtu", binary_points("", "YAAAAAAAAAAAAAAA"), {"too early"}},
      {"vtu_base64_huge", ".vtu", binary_points("header_type=\"UInt64\"", "//////////////////8="), {"too early"}},
      {"vtu_zlib_huge_count", ".vtu", binary_points(zlib, "/////wAAAQAAAAAAAAAAAAAA"), {"too early"}},
      {"vtu_zlib_bomb", ".vtu", binary_points(zlib, "AQAAAP///38AAAAABAAAAAAAAAA="), {"claims to hold"}},
      {"vtu_zlib_damaged", ".vtu", binary_points(zlib, "AQAAAGAAAAAAAAAABAAAAAAAAAA="), {"damaged"}},
      {"vtu_compressor",
       ".vtu",
       binary_points("compressor=\"vtkLZ4DataCompressor\"", "AAAA"),
       {"vtkLZ4DataCompressor"}},
      {"vtu_header_type", ".vtu", changed("byte_order", "header_type=\"UInt16\" byte_order"), {"UInt16"}},
      {"vtu_byte_order", ".vtu", changed("LittleEndian", "MiddleEndian"), {"MiddleEndian"}},
      {"vtu_missing_array", ".vtu", changed("Name=\"offsets\"", "Name=\"upsets\""), {"offsets"}},
      {"vtu_appended_cut", ".vtu", changed("</VTKFile>", "<AppendedData encoding=\"raw\">_abc"), {"<AppendedData>"}},
      {"vtu_appended_offset",
       ".vtu",
       changed("format=\"ascii\"", "format=\"appended\" offset=\"12345\""),
       {"offset 12345"}},
      {"vtu_deep",
       ".vtu",
       [] {
         std::string deep;
         for (int i = 0; i < 200000; ++i) deep += "<a>";
         return deep;
       }(),
       {"not XML"}},
  };
}

const auto name_of = [](const auto& param) { return std::string(param.param.name); };
INSTANTIATE_TEST_SUITE_P(Msh, BadVolume, testing::ValuesIn(bad_msh()), name_of);
INSTANTIATE_TEST_SUITE_P(Vtk, BadVolume, testing::ValuesIn(bad_vtk()), name_of);
INSTANTIATE_TEST_SUITE_P(Vtu, BadVolume, testing::ValuesIn(bad_vtu()), name_of);

TEST(BadVolume, TheFilesThatTheOthersSpoilAreGood) {
  EXPECT_EQ(detail::parse_msh(msh(four_nodes, one_tet), "x", 1).mesh.regions, std::vector<std::int32_t>{9});
  EXPECT_EQ(detail::parse_vtk(vtk(vtk_points, vtk_cells), "x", 1).mesh.tet_count(), 1u);
  EXPECT_EQ(detail::parse_vtu(vtu(vtu_points, "0 1 2 3"), "x", 1).mesh.tet_count(), 1u);
}

TEST(BadVolume, BinaryFilesNameTheByteAndTheSection) {
  for (const bool version_4 : {false, true}) {
    const std::string bytes =
        version_4 ? detail::format_msh41(biliary_mesh(), {}, true) : detail::format_msh22(biliary_mesh(), {}, true);
    const std::size_t nodes = bytes.find("$Nodes");
    const std::string message = message_of([&] { detail::parse_msh(bytes.substr(0, nodes + 500), "cut.msh", 1); });
    EXPECT_TRUE(message.starts_with("cut.msh: byte ")) << message;
    EXPECT_NE(message.find("in $Nodes"), std::string::npos) << message;
  }
}

/// Cut anywhere, a file is either refused or, where only ornaments are missing, read whole.
TEST(BadVolume, TruncatedAnywhere) {
  const TetMesh mesh = two_tets();
  using Parse = MeshFile (*)(std::string_view, const std::string&, double);
  const std::vector<std::pair<std::string, Parse>> files{
      {detail::format_msh22(mesh, {}, false), detail::parse_msh},
      {detail::format_msh22(mesh, {}, true), detail::parse_msh},
      {detail::format_msh41(mesh, {}, false), detail::parse_msh},
      {detail::format_msh41(mesh, {}, true), detail::parse_msh},
      {detail::format_vtu(mesh, {}, detail::VtuFormat::ascii), detail::parse_vtu},
      {detail::format_vtu(mesh, {}, detail::VtuFormat::base64), detail::parse_vtu},
      {detail::format_vtu(mesh, {}, detail::VtuFormat::appended), detail::parse_vtu},
      {detail::format_vtu(mesh, {}, detail::VtuFormat::zlib), detail::parse_vtu},
      {detail::format_vtk(mesh, {}, false), detail::parse_vtk},
      {detail::format_vtk(mesh, {}, true), detail::parse_vtk}};
  for (const auto& [bytes, parse] : files)
    for (std::size_t length = 0; length + 1 < bytes.size(); ++length) {
      try {
        const TetMesh read = parse(std::string_view(bytes).substr(0, length), "cut", 1).mesh;
        EXPECT_EQ(read.positions, mesh.positions) << length << " of " << bytes.size();
        EXPECT_EQ(read.tets, mesh.tets);
      } catch (const InputError&) {
        continue;
      }
    }
}

TEST(BadVolume, MissingFilesAndUnknownEndings) {
  const TempFolder folder;
  EXPECT_NE(message_of([&] { read_mesh(folder / "no.msh"); }).find("no such file"), std::string::npos);
  EXPECT_NE(message_of([&] { read_mesh(folder / "mesh.xyz"); }).find(".msh, .vtu or .vtk"), std::string::npos);
  std::filesystem::create_directory(folder / "folder.msh");
  EXPECT_THROW(read_mesh(folder / "folder.msh"), InputError);
}

}  // namespace
