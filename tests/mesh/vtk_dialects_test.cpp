// What VTK and others may write, though the tools at hand don't: byte orders, headers, pieces, strings, metadata.
#include <gtest/gtest.h>
#include <zlib.h>

#include "calot/base/error.h"
#include "calot/mesh/base64.h"
#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/vtk_arrays.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

struct Dialect {
  bool big_endian, long_header, zlib, base64, split_header;
};

/// Builds a .vtu file with appended data in one of VTK's ways.
class VtuBuilder {
 public:
  explicit VtuBuilder(const Dialect& d) : d_(d) {}

  template <class T>
  std::string array(const char* type, const char* name, const std::vector<T>& values) {
    std::string bytes;
    for (const T value : values) detail::append_bytes(bytes, value, d_.big_endian);
    const std::string offset = std::to_string(appended_.size());
    std::string header, body = bytes;
    if (d_.zlib) {
      // Two blocks, the second shorter.
      const std::size_t block = (bytes.size() * 2 + 2) / 3;
      const std::string first = squeezed(bytes.substr(0, block)), second = squeezed(bytes.substr(block));
      for (const std::size_t n : {std::size_t{2}, block, bytes.size() - block, first.size(), second.size()})
        number(header, n);
      body = first + second;
    } else {
      number(header, bytes.size());
    }
    if (!d_.base64)
      appended_ += header + body;
    else if (d_.zlib || d_.split_header)
      appended_ += detail::base64_encode(header) + detail::base64_encode(body);
    else
      appended_ += detail::base64_encode(header + body);
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           (std::string(name) == "Points" ? "3" : "1") + "\" format=\"appended\" offset=\"" + offset + "\"/>\n";
  }

  std::string file(const std::string& grid) const {
    return std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"") +
           (d_.big_endian ? "BigEndian\"" : "LittleEndian\"") + (d_.long_header ? " header_type=\"UInt64\"" : "") +
           (d_.zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<UnstructuredGrid>\n" + grid +
           "</UnstructuredGrid>\n<AppendedData encoding=\"" + (d_.base64 ? "base64" : "raw") + "\">\n_" + appended_ +
           "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  void number(std::string& header, std::size_t n) const {
    if (d_.long_header)
      detail::append_bytes(header, std::uint64_t{n}, d_.big_endian);
    else
      detail::append_bytes(header, static_cast<std::uint32_t>(n), d_.big_endian);
  }
  static std::string squeezed(const std::string& bytes) {
    uLongf length = compressBound(bytes.size());
    std::string packed(length, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &length, reinterpret_cast<const Bytef*>(bytes.data()),
             bytes.size());
    packed.resize(length);
    return packed;
  }

  Dialect d_;
  std::string appended_;
};

std::string piece_of(VtuBuilder& builder, const TetMesh& mesh) {
  std::vector<float> points;
  for (const Vec3& p : mesh.positions)
    for (const double x : p) points.push_back(static_cast<float>(x));
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> offsets;
  for (const Tet& tet : mesh.tets) {
    for (const VertexId v : tet) connectivity.push_back(static_cast<std::int32_t>(v.value));
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  std::string grid = "<Piece NumberOfPoints=\"" + std::to_string(mesh.vertex_count()) + "\" NumberOfCells=\"" +
                     std::to_string(mesh.tet_count()) + "\">\n<CellData Scalars=\"Label\">\n";
  grid += builder.array("Float64", "material", std::vector<double>(mesh.tet_count(), 77));  // "Label" outranks it
  grid += builder.array("UInt8", "Label", std::vector<std::uint8_t>(mesh.regions.begin(), mesh.regions.end()));
  grid += "</CellData>\n<Points>\n" + builder.array("Float32", "Points", points) + "</Points>\n<Cells>\n";
  grid += builder.array("Int32", "connectivity", connectivity) + builder.array("Int64", "offsets", offsets);
  grid += builder.array("UInt8", "types", std::vector<std::uint8_t>(mesh.tet_count(), 10));
  return grid + "</Cells>\n</Piece>\n";
}

TEST(VtuDialects, EveryCombination) {
  TetMesh mesh = box_mesh(3, 2, 2, {3, 2, 2});  // whole numbers: exact in Float32
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) mesh.regions[t] = static_cast<std::int32_t>(t % 5);
  for (int bits = 0; bits < 32; ++bits) {
    SCOPED_TRACE(bits);
    VtuBuilder builder({(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, (bits & 16) != 0});
    const std::string grid = piece_of(builder, mesh);
    const TetMesh back = detail::parse_vtu(builder.file(grid), "x.vtu", 1).mesh;
    EXPECT_EQ(back.positions, mesh.positions);
    EXPECT_EQ(back.tets, mesh.tets);
    EXPECT_EQ(back.regions, mesh.regions);
  }
}

TEST(VtuDialects, PiecesJoin) {
  TetMesh other = two_tets();
  for (Vec3& p : other.positions) p.x() += 50;
  VtuBuilder builder({false, false, false, true, false});
  const std::string grid = piece_of(builder, two_tets()) + piece_of(builder, other);
  const TetMesh both = detail::parse_vtu(builder.file(grid), "x.vtu", 1).mesh;
  EXPECT_EQ(both.vertex_count(), 10u);
  ASSERT_EQ(both.tet_count(), 4u);
  EXPECT_EQ(both.tets[2][0], VertexId(5));
  EXPECT_EQ(both.regions, (std::vector<std::int32_t>{1, 2, 1, 2}));
}

TEST(VtuDialects, NamesAsAStringArray) {
  VtuBuilder builder({false, true, false, false, false});
  const std::string names =
      "<FieldData>\n<DataArray type=\"Int32\" Name=\"region_ids\" NumberOfTuples=\"2\" format=\"ascii\">1 "
      "2</DataArray>\n"
      "<DataArray type=\"String\" Name=\"region_names\" NumberOfTuples=\"2\" format=\"ascii\">"
      "97 98 0 99 32 100 0</DataArray>\n</FieldData>\n";
  const std::string grid = names + piece_of(builder, two_tets());
  EXPECT_EQ(detail::parse_vtu(builder.file(grid), "x.vtu", 1).mesh.region_names,
            (std::map<std::int32_t, std::string>{{1, "ab"}, {2, "c d"}}));
}

TEST(VtuDialects, RawDataMayLookLikeXml) {
  VtuBuilder builder({false, false, false, false, false});
  const std::string text = "</AppendedData><oops attribute=\"_";
  std::string grid = piece_of(builder, two_tets());
  grid += "";
  builder.array("UInt8", "noise", std::vector<std::uint8_t>(text.begin(), text.end()));
  EXPECT_EQ(detail::parse_vtu(builder.file(grid), "x.vtu", 1).mesh.tet_count(), 2u);
}

const std::string points = "POINTS 5 float\n0 0 0 1 0 0 0 1 0 0.25 0.25 1 0.25 0.25 -1\n";
const std::string cells = "CELLS 2 10\n4 0 1 2 3\n4 0 2 1 4\nCELL_TYPES 2\n10 10\n";

TetMesh parse(const std::string& body, const std::string& version = "4.2") {
  return detail::parse_vtk("# vtk DataFile Version " + version + "\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n" + body,
                           "x.vtk", 1)
      .mesh;
}

TEST(VtkDialects, AttributesOfEveryKind) {
  const TetMesh mesh =
      parse(points + cells +
            "POINT_DATA 5\nSCALARS t float\nLOOKUP_TABLE table\n1 2 3 4 5\nLOOKUP_TABLE table 2\n0 0 0 1 1 1 1 1\n"
            "VECTORS v float\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\nTEXTURE_COORDINATES tc 2 float\n0 0 0 0 0 0 0 0 0 0\n"
            "COLOR_SCALARS c 1\n0 0 0 0 0\nCELL_DATA 2\nNORMALS n float\n0 0 1 0 0 1\nTENSORS s float\n"
            "1 0 0 0 1 0 0 0 1\n1 0 0 0 1 0 0 0 1\nGLOBAL_IDS g vtkIdType\n0 1\nSCALARS REGION int 1\nLOOKUP_TABLE "
            "default\n6 8\n"
            "FIELD more 2\nlabel 1 2 short\n1 1\nwide%20name 2 2 double\n1 2 3 4\n");
  EXPECT_EQ(mesh.regions, (std::vector<std::int32_t>{6, 8}));
}

TEST(VtkDialects, ScalarsWithoutALookupTableLine) {
  EXPECT_EQ(parse(points + cells + "CELL_DATA 2\nSCALARS region int\n6 8\n").regions,
            (std::vector<std::int32_t>{6, 8}));
}

TEST(VtkDialects, MetadataAndStrings) {
  const TetMesh mesh = parse(
      "FIELD FieldData 3\nregion_ids 1 2 int\n6 8\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\n"
      "DATA 2 1 2\n\nregion_names 1 2 string\ncystic%20duct\nliver\nNULL_ARRAY\n" +
      points + "METADATA\nINFORMATION 0\n\n" + cells + "CELL_DATA 2\nFIELD FieldData 1\nregion 1 2 int\n6 8\n");
  EXPECT_EQ(mesh.region_names, (std::map<std::int32_t, std::string>{{6, "cystic duct"}, {8, "liver"}}));
  EXPECT_EQ(mesh.regions, (std::vector<std::int32_t>{6, 8}));
}

TEST(VtkDialects, BinaryStringsBitsAndLongNames) {
  std::string file =
      "# vtk DataFile Version 4.2\ntitle\nBINARY\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 3\nregion_ids 1 2 int\n";
  const auto put = [&](auto value) { detail::append_bytes(file, value, true); };
  put(std::int32_t{1});
  put(std::int32_t{2});
  file += "\nregion_names 1 2 string\n";
  const std::string name(100, 'n');
  put(std::uint8_t{3 << 6 | 5});  // a length up to 63 fits in the first byte
  file += "liver";
  put(static_cast<std::uint16_t>(2 << 14 | 100));  // up to 16383 in two
  file += name + "\nflags 1 12 bit\n";
  put(std::uint16_t{0x5550});
  file += "\nPOINTS 5 float\n";
  const TetMesh mesh = two_tets();
  for (const Vec3& p : mesh.positions)
    for (const double x : p) put(static_cast<float>(x));
  file += "\nCELLS 2 10\n";
  for (const Tet& tet : mesh.tets) {
    put(std::int32_t{4});
    for (const VertexId v : tet) put(static_cast<std::int32_t>(v.value));
  }
  file += "\nCELL_TYPES 2\n";
  put(std::int32_t{10});
  put(std::int32_t{10});
  file += "\nCELL_DATA 2\nSCALARS medit:ref unsigned_char 1\nLOOKUP_TABLE default\n";
  put(std::uint8_t{2});
  put(std::uint8_t{1});
  const TetMesh back = detail::parse_vtk(file, "x.vtk", 1).mesh;
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.tets, mesh.tets);
  EXPECT_EQ(back.regions, (std::vector<std::int32_t>{2, 1}));
  EXPECT_EQ(back.region_names, (std::map<std::int32_t, std::string>{{1, "liver"}, {2, name}}));
}

TEST(VtkDialects, Version5) {
  const TetMesh mesh = parse(points +
                                 "CELLS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 2 1 4\n"
                                 "CELL_TYPES 2\n10\n10\n",
                             "5.1");
  EXPECT_EQ(mesh.tets, two_tets().tets);
}

TEST(VtkDialects, NamesArePercentEncoded) {
  for (const std::string name : {"plain", "two words", "100%", "\"q\"", "Gänge", "%20", ""})
    EXPECT_EQ(detail::percent_decode(detail::percent_encode(name)), name);
  EXPECT_EQ(detail::percent_encode("a b"), "a%20b");
  EXPECT_EQ(detail::percent_decode("a%zzb%"), "a%zzb%");
}

TEST(Base64, KnownValues) {
  EXPECT_EQ(detail::base64_encode(""), "");
  EXPECT_EQ(detail::base64_encode("f"), "Zg==");
  EXPECT_EQ(detail::base64_encode("fo"), "Zm8=");
  EXPECT_EQ(detail::base64_encode("foobar"), "Zm9vYmFy");
  EXPECT_EQ(detail::ByteStream("Zg==Zm9v\n Ym Fy", true).read(100), "ffoobar");
  EXPECT_EQ(detail::ByteStream("Zg=!", true).read(100), "");
  EXPECT_EQ(detail::ByteStream("Z", true).read(1), "");
}

// ---- .msh of the other byte order, and with 4-byte sizes

void put_big(std::string& out, auto... values) {
  (detail::append_bytes(out, values, true), ...);
}

TEST(MshDialects, BigEndianVersion2) {
  const TetMesh mesh = two_tets();
  std::string file = "$MeshFormat\n2.2 1 8\n";
  put_big(file, std::int32_t{1});
  file += "\n$EndMeshFormat\n$Comments\n$EndComments\n$Nodes\n5\n";
  for (std::size_t v = 0; v < 5; ++v)
    put_big(file, std::int32_t(100 - 7 * v), mesh.positions[v].x(), mesh.positions[v].y(), mesh.positions[v].z());
  file += "\n$EndNodes\n$Elements\n3\n";
  const auto node = [&](std::size_t t, int c) { return std::int32_t(100 - 7 * mesh.tets[t][c].value); };
  put_big(file, 2, 1, 2, 1, 5, 5, node(0, 0), node(0, 1), node(0, 2));  // one triangle
  put_big(file, 4, 2, 3);
  for (std::size_t t = 0; t < 2; ++t)
    put_big(file, int(t) + 2, int(t) + 30, 1, 0, node(t, 0), node(t, 1), node(t, 2), node(t, 3));
  file += "\n$EndElements\n";
  const MeshFile back = detail::parse_msh(file, "x.msh", 1);
  EXPECT_EQ(back.mesh.positions, mesh.positions);
  EXPECT_EQ(back.mesh.tets, mesh.tets);
  EXPECT_EQ(back.mesh.regions, (std::vector<std::int32_t>{30, 31}));
  EXPECT_EQ(back.notes, std::vector<std::string>{"1 triangles ignored"});
}

TEST(MshDialects, FourByteSizesAndParametricNodes) {
  const TetMesh mesh = regular_tet();
  std::string file = "$MeshFormat\n4.1 1 4\n";
  put_big(file, std::int32_t{1});
  file += "\n$EndMeshFormat\n$Nodes\n";
  put_big(file, 2u, 4u, 1u, 4u);
  for (const int dimension : {2, 3}) {
    put_big(file, dimension, 1, dimension == 2 ? 1 : 0, 2u);
    const std::size_t first = dimension == 2 ? 0 : 2;
    put_big(file, std::uint32_t(first + 1), std::uint32_t(first + 2));
    for (std::size_t v = first; v < first + 2; ++v) {
      put_big(file, mesh.positions[v].x(), mesh.positions[v].y(), mesh.positions[v].z());
      if (dimension == 2) put_big(file, 0.5, 0.25);
    }
  }
  file += "\n$EndNodes\n$Elements\n";
  put_big(file, 1u, 1u, 1u, 1u, 3, 12, 4, 1u, 1u);
  for (const VertexId v : mesh.tets[0]) put_big(file, v.value + 1);
  file += "\n$EndElements\n";
  const TetMesh back = detail::parse_msh(file, "x.msh", 1).mesh;
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.tets, mesh.tets);
  EXPECT_EQ(back.regions, std::vector<std::int32_t>{12});
}

TEST(MshDialects, TetsInNoGroupAreNoted) {
  const MeshFile file = detail::parse_msh(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\r\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 .25 .25 +1\n5 .25 .25 "
      "-1\n$EndNodes\n"
      "$Elements\n2\n1 4 2 0 3 1 2 3 4\n2 4 4 9 3 1 1 1 3 2 5\n$EndElements\n",
      "x.msh", 1);
  EXPECT_EQ(file.mesh.regions, (std::vector<std::int32_t>{0, 9}));
  EXPECT_EQ(file.notes, std::vector<std::string>{"1 tets belong to no physical group; their region is 0"});
}

}  // namespace
