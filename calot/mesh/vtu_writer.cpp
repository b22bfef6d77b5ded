// .vtu files: one piece, Float64 points, Int64 cells, 64-bit headers, little endian.
#include <zlib.h>

#include "calot/base/error.h"
#include "calot/mesh/base64.h"
#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

std::string in_xml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

/// VTK's layout of a compressed array: block count, block size, size of a shorter last block, compressed sizes; blocks.
std::string compressed(const std::string& bytes) {
  constexpr std::size_t block = 1 << 15;
  std::string head, blocks;
  append_bytes(head, std::uint64_t{(bytes.size() + block - 1) / block});
  append_bytes(head, std::uint64_t{block});
  append_bytes(head, std::uint64_t{bytes.size() % block});
  for (std::size_t start = 0; start < bytes.size(); start += block) {
    const std::size_t size = std::min(block, bytes.size() - start);
    uLongf length = compressBound(static_cast<uLong>(size));
    std::string packed(length, '\0');
    const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
                                 reinterpret_cast<const Bytef*>(bytes.data() + start), static_cast<uLong>(size), 6);
    if (status != Z_OK) throw FailedError("", "zlib could not compress: no memory", "free some memory");
    append_bytes(head, std::uint64_t{length});
    blocks.append(packed, 0, length);
  }
  return base64_encode(head) + base64_encode(blocks);
}

/// Collects the XML and what is appended behind it.
class VtuWriter {
 public:
  explicit VtuWriter(VtuFormat format) : format_(format) {}

  template <class T>
  void array(const char* type, const std::string& name, int components, const std::vector<T>& values) {
    xml_ += std::string("<DataArray type=\"") + type + "\" Name=\"" + in_xml(name) + "\" NumberOfComponents=\"" +
            std::to_string(components) + "\"";
    tuples(components, values);
  }
  /// Field arrays say how many tuples they have: nothing around them does.
  template <class T>
  void field(const char* type, const std::string& name, const std::vector<T>& values) {
    xml_ += std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfTuples=\"" +
            std::to_string(values.size()) + "\"";
    tuples(8, values);
  }
  void text(const std::string& xml) { xml_ += xml; }
  std::string take() {
    if (format_ == VtuFormat::appended)
      xml_ += "<AppendedData encoding=\"raw\">\n_" + appended_ + "\n</AppendedData>\n";
    return std::move(xml_) + "</VTKFile>\n";
  }

 private:
  template <class T>
  void tuples(int per_line, const std::vector<T>& values);

  VtuFormat format_;
  std::string xml_, appended_;
};

template <class T>
void VtuWriter::tuples(int per_line, const std::vector<T>& values) {
  if (format_ == VtuFormat::ascii) {
    xml_ += " format=\"ascii\">\n";
    for (std::size_t i = 0; i < values.size(); ++i) {
      if constexpr (sizeof(T) == 1)
        append_text(xml_, static_cast<int>(values[i]));
      else
        append_text(xml_, values[i]);
      xml_ += (i + 1) % static_cast<std::size_t>(per_line) == 0 || i + 1 == values.size() ? '\n' : ' ';
    }
    xml_ += "</DataArray>\n";
    return;
  }
  std::string bytes;
  for (const T value : values) append_bytes(bytes, value);
  std::string sized;
  append_bytes(sized, std::uint64_t{bytes.size()});
  sized += bytes;
  if (format_ == VtuFormat::appended) {
    xml_ += " format=\"appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
    appended_ += sized;
  } else {
    xml_ += " format=\"binary\">\n" + (format_ == VtuFormat::zlib ? compressed(bytes) : base64_encode(sized)) +
            "\n</DataArray>\n";
  }
}

void put_names(VtuWriter& out, const TetMesh& mesh) {
  if (mesh.region_names.empty()) return;
  std::vector<std::int32_t> ids;
  for (const auto& [region, name] : mesh.region_names) ids.push_back(region);
  const std::string packed = pack_names(mesh.region_names);
  out.text("<FieldData>\n");
  out.field("Int32", "region_ids", ids);
  out.field("UInt8", "region_names", std::vector<std::uint8_t>(packed.begin(), packed.end()));
  out.text("</FieldData>\n");
}

void put_cells(VtuWriter& out, const TetMesh& mesh) {
  constexpr std::uint8_t vtk_tetra = 10;
  std::vector<std::int64_t> connectivity, offsets;
  for (const Tet& tet : mesh.tets) {
    for (const VertexId v : tet) connectivity.push_back(v.value);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  out.text("<Cells>\n");
  out.array("Int64", "connectivity", 4, connectivity);
  out.array("Int64", "offsets", 1, offsets);
  out.array("UInt8", "types", 1, std::vector<std::uint8_t>(mesh.tet_count(), vtk_tetra));
  out.text("</Cells>\n");
}

}  // namespace

std::string format_vtu(const TetMesh& mesh, const std::vector<VertexArray>& arrays, VtuFormat format) {
  VtuWriter out(format);
  out.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\"");
  if (format == VtuFormat::zlib) out.text(" compressor=\"vtkZLibDataCompressor\"");
  out.text(">\n<UnstructuredGrid>\n");
  put_names(out, mesh);
  out.text("<Piece NumberOfPoints=\"" + std::to_string(mesh.vertex_count()) + "\" NumberOfCells=\"" +
           std::to_string(mesh.tet_count()) + "\">\n<Points>\n");
  std::vector<double> coordinates;
  for (const Vec3& p : mesh.positions) coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
  out.array("Float64", "Points", 3, coordinates);
  out.text("</Points>\n");
  put_cells(out, mesh);
  out.text("<PointData>\n");
  for (const VertexArray& array : arrays) out.array("Float64", array.name, array.components, array.values);
  out.text("</PointData>\n<CellData>\n");
  out.array("Int32", "region", 1, mesh.regions);
  out.text("</CellData>\n</Piece>\n</UnstructuredGrid>\n");
  return out.take();
}

}  // namespace calot::detail
