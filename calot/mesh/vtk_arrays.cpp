#include "calot/mesh/vtk_arrays.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace calot::detail {
namespace {

using NamedType = std::pair<std::string_view, ScalarType>;

constexpr auto vtu_types = std::to_array<NamedType>({
    {"Int8", ScalarType::int8},
    {"UInt8", ScalarType::uint8},
    {"String", ScalarType::uint8},
    {"Int16", ScalarType::int16},
    {"UInt16", ScalarType::uint16},
    {"Int32", ScalarType::int32},
    {"UInt32", ScalarType::uint32},
    {"Int64", ScalarType::int64},
    {"UInt64", ScalarType::uint64},
    {"Float32", ScalarType::float32},
    {"Float64", ScalarType::float64},
});

// "long" has 8 bytes, as in files from 64-bit Unix; vtkIdType is written as int.
constexpr auto vtk_types = std::to_array<NamedType>({
    {"char", ScalarType::int8},
    {"signed_char", ScalarType::int8},
    {"unsigned_char", ScalarType::uint8},
    {"short", ScalarType::int16},
    {"unsigned_short", ScalarType::uint16},
    {"int", ScalarType::int32},
    {"vtkidtype", ScalarType::int32},
    {"unsigned_int", ScalarType::uint32},
    {"long", ScalarType::int64},
    {"vtktypeint64", ScalarType::int64},
    {"unsigned_long", ScalarType::uint64},
    {"vtktypeuint64", ScalarType::uint64},
    {"float", ScalarType::float32},
    {"double", ScalarType::float64},
});

template <class Types>
std::optional<ScalarType> find_type(const Types& types, std::string_view name) {
  const auto found = std::find_if(types.begin(), types.end(), [name](const NamedType& t) { return t.first == name; });
  if (found == types.end()) return std::nullopt;
  return found->second;
}

template <class T, class Stored>
T converted(Stored value, const Cursor& at) {
  if constexpr (std::is_integral_v<T> && std::is_floating_point_v<Stored>)
    if (!(std::abs(value) <= Stored(1 << 24)) || value != std::floor(value)) at.fail("a whole number expected");
  return static_cast<T>(value);
}

template <class T, class Stored>
std::vector<T> decode_as(std::string_view bytes, bool swap, const Cursor& at) {
  std::vector<T> values(bytes.size() / sizeof(Stored));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = converted<T>(load<Stored>(bytes.data() + i * sizeof(Stored), swap), at);
  return values;
}

}  // namespace

std::optional<ScalarType> vtu_type(std::string_view name) {
  return find_type(vtu_types, name);
}

std::optional<ScalarType> vtk_type(std::string_view name) {
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return find_type(vtk_types, lower);
}

std::size_t bytes_of(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
    case ScalarType::uint8:
      return 1;
    case ScalarType::int16:
    case ScalarType::uint16:
      return 2;
    case ScalarType::int32:
    case ScalarType::uint32:
    case ScalarType::float32:
      return 4;
    default:
      return 8;
  }
}

template <class T>
std::vector<T> decode(ScalarType type, std::string_view bytes, bool swap, const Cursor& at) {
  switch (type) {
    case ScalarType::int8:
      return decode_as<T, std::int8_t>(bytes, swap, at);
    case ScalarType::uint8:
      return decode_as<T, std::uint8_t>(bytes, swap, at);
    case ScalarType::int16:
      return decode_as<T, std::int16_t>(bytes, swap, at);
    case ScalarType::uint16:
      return decode_as<T, std::uint16_t>(bytes, swap, at);
    case ScalarType::int32:
      return decode_as<T, std::int32_t>(bytes, swap, at);
    case ScalarType::uint32:
      return decode_as<T, std::uint32_t>(bytes, swap, at);
    case ScalarType::int64:
      return decode_as<T, std::int64_t>(bytes, swap, at);
    case ScalarType::uint64:
      return decode_as<T, std::uint64_t>(bytes, swap, at);
    case ScalarType::float32:
      return decode_as<T, float>(bytes, swap, at);
    case ScalarType::float64:
      return decode_as<T, double>(bytes, swap, at);
  }
  return {};
}

template std::vector<double> decode<double>(ScalarType, std::string_view, bool, const Cursor&);
template std::vector<std::int64_t> decode<std::int64_t>(ScalarType, std::string_view, bool, const Cursor&);

void add_vtk_cells(const VtkCells& cells, std::size_t first_vertex, std::size_t vertices, const Cursor& at,
                   RawMesh& raw) {
  const std::size_t count = cells.types.size();
  if (cells.ends.size() != count)
    at.fail(std::to_string(cells.ends.size()) + " cells but " + std::to_string(count) + " cell types");
  if (!cells.regions.empty() && cells.regions.size() != count)
    at.fail(std::to_string(cells.regions.size()) + " regions for " + std::to_string(count) + " cells");
  std::int64_t begin = 0;
  for (std::size_t i = 0; i < count; begin = cells.ends[i], ++i) {
    const auto refuse = [&](const std::string& what) { at.fail("cell " + std::to_string(i) + what); };
    if (cells.ends[i] < begin || std::uint64_t(cells.ends[i]) > cells.connectivity.size())
      refuse(" ends at " + std::to_string(cells.ends[i]) + ", outside the connectivity");
    if (cells.types[i] < 0 || cells.types[i] > 255) refuse(" has the unknown type " + std::to_string(cells.types[i]));
    const int type = static_cast<int>(cells.types[i]);
    const ElementKind kind = vtk_cell(type);
    const bool wanted = is_wanted(kind, type, at);
    if (kind.nodes != 0 && cells.ends[i] - begin != kind.nodes)
      refuse(" has " + std::to_string(cells.ends[i] - begin) + " vertices, " + kind.name + " have " +
             std::to_string(kind.nodes));
    if (!wanted) {
      ++raw.ignored[kind.name];
      continue;
    }
    Tet tet;
    for (int c = 0; c < 4; ++c) {
      const std::int64_t v = cells.connectivity[std::size_t(begin) + std::size_t(c)];
      if (v < 0 || std::uint64_t(v) >= vertices)
        refuse(" names vertex " + std::to_string(v) + " of " + std::to_string(vertices));
      tet[c] = VertexId(first_vertex + std::size_t(v));
    }
    raw.mesh.tets.push_back(tet);
    raw.mesh.regions.push_back(cells.regions.empty() ? 0 : to_region(cells.regions[i], at));
  }
}

std::map<std::int32_t, std::string> RegionNames::unpack(const Cursor& at) const {
  if (!packed) return {};
  if (ids.empty() && !packed->empty())
    at.fail("region_names without region_ids", "give the region number of each name in region_ids");
  return unpack_names(ids, *packed, at);
}

std::string percent_encode(std::string_view name) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : name) {
    if (c > ' ' && c <= '~' && c != '%' && c != '"') {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', digits[byte >> 4], digits[byte & 15]};
  }
  return encoded;
}

std::string percent_decode(std::string_view name) {
  std::string decoded;
  for (std::size_t i = 0; i < name.size(); ++i) {
    unsigned int byte = 0;
    const bool escape = name[i] == '%' && i + 2 < name.size() &&
                        std::from_chars(name.data() + i + 1, name.data() + i + 3, byte, 16).ptr == name.data() + i + 3;
    decoded += escape ? static_cast<char>(byte) : name[i];
    if (escape) i += 2;
  }
  return decoded;
}

}  // namespace calot::detail
