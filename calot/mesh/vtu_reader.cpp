// .vtu files (VTK XML unstructured grids), one or several pieces.
#include <algorithm>
#include <utility>

#include "calot/mesh/vtu_arrays.h"

namespace calot::detail {
namespace {

/// Appended data are no XML (raw bytes, or text too long to copy), so they are cut out before parsing.
struct CutFile {
  std::string xml;            ///< the file without the appended data
  std::string_view appended;  ///< what follows the underscore
};

CutFile cut_out_appended(std::string_view bytes, const std::string& name) {
  const std::size_t element = bytes.find("<AppendedData");
  if (element == std::string_view::npos) return {std::string(bytes), {}};
  const std::size_t open = bytes.find('>', element), close = bytes.rfind("</AppendedData>");
  const std::size_t mark = bytes.find('_', open);
  if (open == std::string_view::npos || close == std::string_view::npos || mark == std::string_view::npos ||
      mark > close)
    throw InputError(name, "the <AppendedData> element is cut short", "export the mesh again");
  std::string xml(bytes.substr(0, open + 1));
  xml += bytes.substr(close);
  return {std::move(xml), bytes.substr(mark + 1, close - mark - 1)};
}

class VtuReader {
 public:
  VtuReader(const CutFile& file, const std::string& name) : file_(file), name_(name), arrays_(file.xml, name) {}
  RawMesh read();

 private:
  void parse();
  void read_encoding(pugi::xml_node root);
  void read_piece(pugi::xml_node piece);
  void read_points(pugi::xml_node piece, std::uint64_t count);
  void read_names(pugi::xml_node grid);
  std::vector<double> read_regions(pugi::xml_node piece) const;
  pugi::xml_node named_array(pugi::xml_node parent, std::string_view name) const;
  std::uint64_t count(pugi::xml_node piece, const char* attribute) const;

  const CutFile& file_;
  std::string name_;
  VtuArrays arrays_;
  pugi::xml_document document_;
  RawMesh raw_;
};

void VtuReader::parse() {
  const pugi::xml_parse_result result =
      document_.load_buffer(file_.xml.data(), file_.xml.size(), pugi::parse_default, pugi::encoding_utf8);
  if (result) return;
  Cursor here(file_.xml, name_);
  if (result.offset > 0) here.seek(static_cast<std::size_t>(result.offset));
  here.fail(std::string("not XML: ") + result.description());
}

void VtuReader::read_encoding(pugi::xml_node root) {
  VtuEncoding encoding;
  const Cursor here = arrays_.at(root);
  const std::string_view order = root.attribute("byte_order").as_string("LittleEndian");
  if (order != "LittleEndian" && order != "BigEndian") here.fail("byte order " + in_quotes(order));
  encoding.swap = (order == "BigEndian") != (std::endian::native == std::endian::big);
  const std::string_view header = root.attribute("header_type").as_string("UInt32");
  if (header != "UInt32" && header != "UInt64")
    here.fail("header type " + in_quotes(header) + ", not UInt32 or UInt64");
  encoding.header_bytes = header == "UInt64" ? 8 : 4;
  const std::string_view compressor = root.attribute("compressor").value();
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    here.fail("compressor " + in_quotes(compressor), "save it uncompressed or with zlib");
  encoding.zlib = !compressor.empty();
  const std::string_view kind = root.child("AppendedData").attribute("encoding").as_string("raw");
  if (kind != "raw" && kind != "base64")
    here.fail("appended data encoded as " + in_quotes(kind) + ", not raw or base64");
  encoding.appended_base64 = kind == "base64";
  encoding.appended = file_.appended;
  arrays_.set_encoding(encoding);
}

std::uint64_t VtuReader::count(pugi::xml_node piece, const char* attribute) const {
  const Cursor here = arrays_.at(piece);
  const auto number = here.number_in<std::uint64_t>(piece.attribute(attribute).value(), attribute);
  check_size(number, 0, here);
  return number;
}

pugi::xml_node VtuReader::named_array(pugi::xml_node parent, std::string_view name) const {
  for (const pugi::xml_node array : parent.children("DataArray"))
    if (name == array.attribute("Name").value()) return array;
  arrays_.at(parent).fail("no <DataArray Name=" + in_quotes(name) + ">");
}

void VtuReader::read_points(pugi::xml_node piece, std::uint64_t count) {
  const pugi::xml_node array = piece.child("Points").child("DataArray");
  if (!array) arrays_.at(piece).fail("no <Points>");
  const Cursor here = arrays_.at(array);
  if (array.attribute("NumberOfComponents").as_int(3) != 3) here.fail("points without three components");
  const std::vector<double> values = arrays_.read<double>(array);
  if (values.size() != 3 * count)
    here.fail(std::to_string(values.size()) + " coordinates for " + std::to_string(count) + " points");
  check_size(raw_.mesh.positions.size() + count, 0, here);
  for (std::size_t i = 0; i < values.size(); i += 3) {
    const Vec3 p(values[i], values[i + 1], values[i + 2]);
    if (!p.allFinite())
      here.fail("point " + std::to_string(i / 3) + " has a coordinate that is not a finite number",
                "repair it in the program that wrote it");
    raw_.mesh.positions.push_back(p);
  }
}

std::vector<double> VtuReader::read_regions(pugi::xml_node piece) const {
  pugi::xml_node best;
  int best_rank = 0;
  for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
    const int rank = region_array_rank(array.attribute("Name").value());
    if (rank == 0 || array.attribute("NumberOfComponents").as_int(1) > 1) continue;
    if (best_rank == 0 || rank < best_rank) {
      best = array;
      best_rank = rank;
    }
  }
  return best ? arrays_.read<double>(best) : std::vector<double>{};
}

void VtuReader::read_piece(pugi::xml_node piece) {
  const std::size_t first_vertex = raw_.mesh.vertex_count();
  const std::uint64_t points = count(piece, "NumberOfPoints"), cell_count = count(piece, "NumberOfCells");
  const Cursor here = arrays_.at(piece);
  if (points > 0) read_points(piece, points);
  if (cell_count == 0) return;
  const pugi::xml_node cells_node = piece.child("Cells");
  if (!cells_node) here.fail("no <Cells>");
  VtkCells cells;
  cells.connectivity = arrays_.read<std::int64_t>(named_array(cells_node, "connectivity"));
  cells.ends = arrays_.read<std::int64_t>(named_array(cells_node, "offsets"));
  cells.types = arrays_.read<std::int64_t>(named_array(cells_node, "types"));
  cells.regions = read_regions(piece);
  if (cells.types.size() != cell_count)
    here.fail(std::to_string(cells.types.size()) + " cell types for " + std::to_string(cell_count) + " cells");
  add_vtk_cells(cells, first_vertex, static_cast<std::size_t>(points), arrays_.at(cells_node), raw_);
}

void VtuReader::read_names(pugi::xml_node grid) {
  RegionNames names;
  const pugi::xml_node fields = grid.child("FieldData");
  for (const pugi::xml_node array : fields.children()) {
    const std::string_view name = array.attribute("Name").value();
    if (name == "region_ids") names.ids = arrays_.read<std::int64_t>(array);
    if (name != "region_names") continue;
    names.packed.emplace();
    for (const std::int64_t c : arrays_.read<std::int64_t>(array)) *names.packed += static_cast<char>(c);
  }
  raw_.mesh.region_names = names.unpack(arrays_.at(fields));
}

RawMesh VtuReader::read() {
  parse();
  const pugi::xml_node root = document_.child("VTKFile");
  if (!root) throw InputError(name_, "no <VTKFile> element: not a .vtu file", "export the mesh again");
  const std::string_view type = root.attribute("type").value();
  const pugi::xml_node grid = root.child("UnstructuredGrid");
  if (type != "UnstructuredGrid" || !grid)
    arrays_.at(root).fail("holds " + in_quotes(type) + ", not an UnstructuredGrid", "export the volume mesh as .vtu");
  read_encoding(root);
  read_names(grid);
  for (const pugi::xml_node piece : grid.children("Piece")) read_piece(piece);
  return std::move(raw_);
}

}  // namespace

MeshFile parse_vtu(std::string_view bytes, const std::string& name, double scale) {
  const CutFile file = cut_out_appended(bytes, name);
  return finish(VtuReader(file, name).read(), name, scale);
}

}  // namespace calot::detail
