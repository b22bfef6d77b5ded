// Inside this room only: what the volume readers have in common.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "calot/mesh/cursor.h"
#include "calot/mesh/mesh_file.h"

namespace calot::detail {

/// What a reader makes of an element type.
enum class ElementUse { tet, ignored, second_order_tet, other_volume, unknown };
struct ElementKind {
  ElementUse use = ElementUse::unknown;
  int nodes = 0;          ///< 0: any number (VTK polygons and the like)
  const char* name = "";  ///< plural, for notes
};
ElementKind gmsh_element(int type);
ElementKind vtk_cell(int type);

/// A mesh as a file gives it, before it is checked.
struct RawMesh {
  TetMesh mesh;
  std::map<std::string, std::size_t> ignored;  ///< count of each kind of element that was left out
  std::vector<std::string> notes;
};

/// Throws InputError, at the cursor, for an element type that can't be read; true for tets, false for ignored ones.
bool is_wanted(const ElementKind& kind, int type, const Cursor& at);

/// Refuses counts that 32-bit numbers can't hold.
void check_size(std::uint64_t vertices, std::uint64_t tets, const Cursor& at);

/// Scales, checks, turns an altogether inverted mesh around and writes the notes.
MeshFile finish(RawMesh raw, const std::string& name, double scale);

/// Region names as bytes, each ended by a zero, parallel to the ids: how .vtu and .vtk carry them (docs/formats.md).
std::string pack_names(const std::map<std::int32_t, std::string>& names);
std::map<std::int32_t, std::string> unpack_names(const std::vector<std::int64_t>& ids, std::string_view packed,
                                                 const Cursor& at);

/// How well the name of a cell array says "region": 0 not at all, smaller positive numbers are better.
int region_array_rank(std::string_view name);

/// A region number from a file's number, which may be a whole floating-point number. Fails at the cursor.
std::int32_t to_region(double value, const Cursor& at);

// The readers of volume meshes, from memory. `name` is the file's name for messages.
MeshFile parse_msh(std::string_view bytes, const std::string& name, double scale);
MeshFile parse_vtu(std::string_view bytes, const std::string& name, double scale);
MeshFile parse_vtk(std::string_view bytes, const std::string& name, double scale);

// The readers of surfaces, from memory.
Surface parse_stl(std::string_view bytes, const std::string& name, double scale);
Surface parse_obj(std::string_view bytes, const std::string& name, double scale);
Surface parse_ply(std::string_view bytes, const std::string& name, double scale);

/// Checks vertex numbers and coordinates, and scales. Throws InputError.
Surface finish_surface(Surface surface, const std::string& name, double scale);

}  // namespace calot::detail
