// Inside this room only: what .vtu and legacy .vtk have in common.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calot/mesh/raw_mesh.h"

namespace calot::detail {

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// The types of .vtu ("Float64") and of .vtk ("double"); nothing for unknown names.
std::optional<ScalarType> vtu_type(std::string_view name);
std::optional<ScalarType> vtk_type(std::string_view name);
std::size_t bytes_of(ScalarType type);

/// The numbers that `bytes` holds, as double or std::int64_t. A fraction where a whole number is wanted fails at the
/// cursor.
template <class T>
std::vector<T> decode(ScalarType type, std::string_view bytes, bool swap, const Cursor& at);

/// The cells of one piece, as both formats have them.
struct VtkCells {
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> ends;   ///< of each cell, the end of its vertices in `connectivity`
  std::vector<std::int64_t> types;  ///< of each cell
  std::vector<double> regions;      ///< of each cell; empty: region 0
};

/// Appends the tets among a piece's cells, whose vertices count from `first_vertex`.
void add_vtk_cells(const VtkCells& cells, std::size_t first_vertex, std::size_t vertices, const Cursor& at,
                   RawMesh& raw);

/// The field arrays that carry region names; both formats.
struct RegionNames {
  std::vector<std::int64_t> ids;
  std::optional<std::string> packed;
  [[nodiscard]] std::map<std::int32_t, std::string> unpack(const Cursor& at) const;
};

/// Spaces and other unprintable characters as %XX, which is how legacy .vtk writes names; and back.
std::string percent_encode(std::string_view name);
std::string percent_decode(std::string_view name);

}  // namespace calot::detail
