// Legacy .vtk files, versions 1.0 to 5.1, ASCII and binary (big endian).
#include <algorithm>
#include <utility>

#include "calot/mesh/vtk_arrays.h"

namespace calot::detail {
namespace {

std::string upper(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

class VtkReader {
 public:
  VtkReader(std::string_view bytes, const std::string& name) : in_(bytes, name) {}
  RawMesh read();

 private:
  void read_header();
  void read_section(const std::string& keyword);
  void read_points();
  void read_cells();
  void read_cells_5(std::size_t offsets, std::size_t size);
  void read_cell_types();
  void read_attribute(const std::string& keyword);
  void read_scalars(const std::string& name);
  void read_field();
  void read_field_array();
  void keep_array(const std::string& name, std::uint64_t components, std::uint64_t tuples, const std::string& type);
  void read_strings(const std::string& name, std::size_t count);
  std::string read_string();
  void skip_metadata();
  std::uint64_t number_on_line(const char* what);
  template <class T>
  std::vector<T> values(const std::string& type, std::uint64_t count, const char* what);

  Cursor in_;
  RawMesh raw_;
  VtkCells cells_;
  RegionNames names_;
  bool version_5_ = false, ascii_ = true, has_points_ = false;
  int region_rank_ = 0;                // of the array that gave cells_.regions
  std::uint64_t attribute_count_ = 0;  // after CELL_DATA or POINT_DATA
  enum { field_data, cell_data, point_data } attribute_of_ = field_data;
};

/// `count` numbers behind the current line: words in ASCII, big-endian bytes in binary.
template <class T>
std::vector<T> VtkReader::values(const std::string& type, std::uint64_t count, const char* what) {
  in_.rest_of_line();
  if (ascii_) {
    std::vector<T> result;
    result.reserve(in_.checked_count(count, 2, what));
    for (std::uint64_t i = 0; i < count; ++i) result.push_back(in_.number<T>(what));
    return result;
  }
  if (type == "bit") {  // eight to a byte; no array that we use is made of bits
    in_.take(in_.checked_count(count / 8 + (count % 8 != 0 ? 1 : 0), 1, what), what);
    return {};
  }
  const auto scalar = vtk_type(type);
  if (!scalar) in_.fail("unknown data type " + in_quotes(type), "use double or int");
  const std::size_t size = bytes_of(*scalar);
  const std::string_view bytes = in_.take(in_.checked_count(count, size, what) * size, what);
  return decode<T>(*scalar, bytes, std::endian::native == std::endian::little, in_);
}

std::uint64_t VtkReader::number_on_line(const char* what) {
  return in_.number_in<std::uint64_t>(in_.token_on_line(), what);
}

void VtkReader::read_header() {
  const std::string_view magic = in_.rest_of_line();
  constexpr std::string_view start = "# vtk DataFile Version ";
  if (!magic.starts_with(start))
    in_.fail("not a legacy .vtk file: " + in_quotes(magic), "export the mesh as .vtk or .vtu");
  const auto version =
      in_.number_in<double>(magic.substr(start.size(), magic.find_last_not_of(" \t") + 1 - start.size()), "a version");
  if (!(version >= 1 && version <= 5.1))
    in_.fail("version " + in_quotes(magic.substr(start.size())) + " of .vtk", "save it as version 4.2 or 5.1");
  version_5_ = version >= 5;
  in_.rest_of_line();  // the title
  const std::string format = upper(in_.token("ASCII or BINARY"));
  if (format != "ASCII" && format != "BINARY") in_.fail("ASCII or BINARY expected, not " + in_quotes(format));
  ascii_ = format == "ASCII";
  in_.set_binary(!ascii_);
  in_.rest_of_line();
}

void VtkReader::read_points() {
  if (std::exchange(has_points_, true)) in_.fail("POINTS twice");
  const std::uint64_t count = number_on_line("a number of points");
  const std::string type(in_.token_on_line());
  check_size(count, 0, in_);
  const std::vector<double> coordinates = values<double>(type, 3 * count, "coordinates");
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!std::isfinite(coordinates[i + axis]))
        in_.fail("point " + std::to_string(i / 3) + " has a coordinate that is not a finite number",
                 "repair it in the program that wrote it");
    raw_.mesh.positions.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  }
  if (raw_.mesh.positions.size() != count) in_.fail("points of type " + in_quotes(type), "use double");
}

/// Version 5 counts one offset more than cells, then lists offsets and vertices apart.
void VtkReader::read_cells_5(std::size_t offsets, std::size_t size) {
  in_.rest_of_line();
  if (upper(in_.token("OFFSETS")) != "OFFSETS") in_.fail("OFFSETS expected");
  cells_.ends = values<std::int64_t>(std::string(in_.token_on_line()), offsets, "offsets");
  if (upper(in_.token("CONNECTIVITY")) != "CONNECTIVITY") in_.fail("CONNECTIVITY expected");
  cells_.connectivity = values<std::int64_t>(std::string(in_.token_on_line()), size, "connectivity");
  if (!cells_.ends.empty()) {
    if (cells_.ends.front() != 0) in_.fail("the first offset is not 0");
    cells_.ends.erase(cells_.ends.begin());
  }
}

/// Older versions list each cell's number of vertices before its vertices.
void VtkReader::read_cells() {
  const std::uint64_t count = number_on_line("a number of cells"), size = number_on_line("a size");
  check_size(0, count, in_);
  if (!cells_.ends.empty()) in_.fail("CELLS twice");
  if (version_5_) return read_cells_5(in_.checked_count(count, 2, "offsets"), in_.checked_count(size, 2, "vertices"));
  const std::vector<std::int64_t> list = values<std::int64_t>("int", size, "cells");
  std::size_t at = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (at == list.size() || list[at] < 0 || std::uint64_t(list[at]) > list.size() - at - 1)
      in_.fail("cell " + std::to_string(i) + " runs over the end of CELLS");
    const std::size_t end = at + 1 + std::size_t(list[at]);
    cells_.connectivity.insert(cells_.connectivity.end(), list.begin() + std::ptrdiff_t(at) + 1,
                               list.begin() + std::ptrdiff_t(end));
    cells_.ends.push_back(std::int64_t(cells_.connectivity.size()));
    at = end;
  }
  if (at != list.size())
    in_.fail("CELLS holds " + std::to_string(list.size()) + " numbers, its cells " + std::to_string(at));
}

void VtkReader::read_cell_types() {
  if (!cells_.types.empty()) in_.fail("CELL_TYPES twice");
  cells_.types = values<std::int64_t>("int", number_on_line("a number of cells"), "cell types");
}

std::string VtkReader::read_string() {
  if (ascii_) return percent_decode(in_.rest_of_line());
  // The two upper bits of the first byte say in how many bytes the length is written.
  const auto first = in_.value<std::uint8_t>("a string");
  std::uint64_t length = first & 63u;
  const int more = std::array{7, 3, 1, 0}[first >> 6];
  for (int i = 0; i < more; ++i) length = length << 8 | in_.value<std::uint8_t>("a string");
  return std::string(in_.take(in_.checked_count(length, 1, "characters"), "a string"));
}

void VtkReader::read_strings(const std::string& name, std::size_t count) {
  in_.rest_of_line();
  std::string packed;
  for (std::size_t i = 0; i < count; ++i) packed += read_string() + '\0';
  if (attribute_of_ == field_data && name == "region_names") names_.packed = std::move(packed);
}

/// Reads an array and keeps it if it tells regions or their names.
void VtkReader::keep_array(const std::string& name, std::uint64_t components, std::uint64_t tuples,
                           const std::string& type) {
  const std::uint64_t count = components * tuples;
  if (attribute_of_ == field_data && name == "region_ids") {
    names_.ids = values<std::int64_t>(type, count, "region_ids");
  } else if (attribute_of_ == field_data && name == "region_names") {
    std::string packed;
    for (const std::int64_t c : values<std::int64_t>(type, count, "region_names")) packed += static_cast<char>(c);
    names_.packed = std::move(packed);
  } else {
    const int rank = attribute_of_ == cell_data && components == 1 ? region_array_rank(name) : 0;
    std::vector<double> numbers = values<double>(type, count, "an array");
    if (rank == 0 || (region_rank_ != 0 && region_rank_ <= rank)) return;
    region_rank_ = rank;
    cells_.regions = std::move(numbers);
  }
}

/// Newer versions put information keys behind an array, up to an empty line.
void VtkReader::skip_metadata() {
  in_.rest_of_line();
  while (!in_.at_end() && !in_.rest_of_line().empty()) continue;
}

void VtkReader::read_field_array() {
  std::string name(in_.token("an array name"));
  while (upper(name) == "METADATA") {
    skip_metadata();
    name = in_.token("an array name");
  }
  if (name == "NULL_ARRAY") return;
  const auto components = in_.number<std::uint64_t>("components"), tuples = in_.number<std::uint64_t>("tuples");
  const std::string type(in_.token("a data type"));
  check_size(components, tuples, in_);  // so that their product fits in 64 bits
  if (type == "string")
    read_strings(name, in_.checked_count(components * tuples, 1, "strings"));
  else
    keep_array(percent_decode(name), components, tuples, type);
}

void VtkReader::read_field() {
  in_.token("a field name");
  const std::size_t arrays = in_.count("arrays", 2);
  for (std::size_t i = 0; i < arrays; ++i) read_field_array();
}

void VtkReader::read_scalars(const std::string& name) {
  const std::string type(in_.token_on_line());
  const std::string_view word = in_.token_on_line();
  const std::size_t components = word.empty() ? 1 : in_.number_in<std::size_t>(word, "components");
  if (components < 1 || components > 4) in_.fail(std::to_string(components) + " components, not 1 to 4");
  in_.rest_of_line();
  const std::size_t before_table = in_.position();
  if (upper(in_.token("LOOKUP_TABLE")) == "LOOKUP_TABLE")
    in_.token("a table name");
  else
    in_.seek(before_table == 0 ? 0 : before_table - 1);  // the line end that `values` passes
  keep_array(name, components, attribute_count_, type);
}

/// The dataset attributes of the format's description; all are read, few are kept.
void VtkReader::read_attribute(const std::string& keyword) {
  if (attribute_of_ == field_data) in_.fail(keyword + " before CELL_DATA or POINT_DATA");
  const std::string name = percent_decode(in_.token_on_line());
  if (keyword == "SCALARS") return read_scalars(name);
  if (keyword == "COLOR_SCALARS" || keyword == "LOOKUP_TABLE") {
    const std::uint64_t number = number_on_line("a number");
    const std::uint64_t tuples = keyword == "LOOKUP_TABLE" ? number : attribute_count_;
    const std::uint64_t components = keyword == "LOOKUP_TABLE" ? 4 : number;
    check_size(components, tuples, in_);
    return keep_array("", components, tuples, "unsigned_char");
  }
  std::uint64_t components = 1;
  if (keyword == "VECTORS" || keyword == "NORMALS") components = 3;
  if (keyword == "TENSORS") components = 9;
  if (keyword == "TENSORS6") components = 6;
  if (keyword == "TEXTURE_COORDINATES") components = number_on_line("a dimension");
  check_size(components, 0, in_);
  keep_array(name, components, attribute_count_, std::string(in_.token_on_line()));
}

void VtkReader::read_section(const std::string& keyword) {
  constexpr std::array<std::string_view, 11> attributes{
      "SCALARS",  "COLOR_SCALARS",       "LOOKUP_TABLE", "VECTORS",      "NORMALS",   "TENSORS",
      "TENSORS6", "TEXTURE_COORDINATES", "GLOBAL_IDS",   "PEDIGREE_IDS", "EDGE_FLAGS"};
  if (keyword == "DATASET") {
    const std::string kind = upper(in_.token("a dataset type"));
    if (kind != "UNSTRUCTURED_GRID")
      in_.fail("dataset " + in_quotes(kind), "export the volume mesh as an UNSTRUCTURED_GRID");
  } else if (keyword == "POINTS") {
    read_points();
  } else if (keyword == "CELLS") {
    read_cells();
  } else if (keyword == "CELL_TYPES") {
    read_cell_types();
  } else if (keyword == "CELL_DATA" || keyword == "POINT_DATA") {
    attribute_of_ = keyword == "CELL_DATA" ? cell_data : point_data;
    attribute_count_ = number_on_line("a number");
    check_size(attribute_count_, 0, in_);
  } else if (keyword == "FIELD") {
    read_field();
  } else if (keyword == "METADATA") {
    skip_metadata();
  } else if (std::find(attributes.begin(), attributes.end(), keyword) != attributes.end()) {
    read_attribute(keyword);
  } else {
    in_.fail("unknown keyword " + in_quotes(keyword));
  }
}

RawMesh VtkReader::read() {
  read_header();
  while (in_.skip_space()) {
    in_.set_section("");
    const std::string keyword = upper(in_.token("a keyword"));
    if (keyword.size() < 32 && std::all_of(keyword.begin(), keyword.end(), [](char c) { return c >= '0' && c <= '_'; }))
      in_.set_section(keyword);
    read_section(keyword);
  }
  in_.set_section("");
  if (!has_points_) in_.fail("no POINTS", "the file is cut short or empty; export it again");
  add_vtk_cells(cells_, 0, raw_.mesh.vertex_count(), in_, raw_);
  raw_.mesh.region_names = names_.unpack(in_);
  return std::move(raw_);
}

}  // namespace

MeshFile parse_vtk(std::string_view bytes, const std::string& name, double scale) {
  return finish(VtkReader(bytes, name).read(), name, scale);
}

}  // namespace calot::detail
