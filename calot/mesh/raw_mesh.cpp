#include "calot/mesh/raw_mesh.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <limits>

#include "calot/mesh/quality.h"

namespace calot::detail {
namespace {

void check_scale(const std::string& name, double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw InputError(name, "length scale " + std::to_string(scale), "give metres per file unit, a number above 0");
}

/// Some tools wind all their tets the other way; a mesh where only some are inverted is a broken mesh.
void turn_if_all_inverted(TetMesh& mesh, MeshProblems& problems, std::vector<std::string>& notes) {
  if (problems.inverted.empty() || problems.inverted.size() != mesh.tet_count()) return;
  const std::size_t turned = orient(mesh);
  notes.push_back("all " + std::to_string(turned) + " tets were wound the other way and were turned around");
  problems.inverted.clear();
}

/// Vertices that are unusual, but may be meant so.
void note_vertices(const MeshProblems& problems, std::vector<std::string>& notes) {
  if (!problems.unused.empty())
    notes.push_back(std::to_string(problems.unused.size()) + " vertices that no tet uses kept");
  std::vector<VertexId> doubled;
  std::set_difference(problems.coincident.begin(), problems.coincident.end(), problems.unused.begin(),
                      problems.unused.end(), std::back_inserter(doubled));
  if (!doubled.empty())
    notes.push_back(
        std::to_string(doubled.size()) +
        " vertices are at exactly the place of an earlier one: the tets there are not joined, as after a cut");
}

}  // namespace

bool is_wanted(const ElementKind& kind, int type, const Cursor& at) {
  switch (kind.use) {
    case ElementUse::tet:
      return true;
    case ElementUse::ignored:
      return false;
    case ElementUse::second_order_tet:
      at.fail(std::string(kind.name) + " (element type " + std::to_string(type) + ")",
              "only linear, 4-node tetrahedra are read; export the mesh at first order");
    case ElementUse::other_volume:
      at.fail(std::string(kind.name) + " (element type " + std::to_string(type) + ")",
              "only tetrahedra are read; mesh the volume with tetrahedra alone");
    case ElementUse::unknown:
      break;
  }
  at.fail("unknown element type " + std::to_string(type), "only tetrahedra are read; export those alone");
}

void check_size(std::uint64_t vertices, std::uint64_t tets, const Cursor& at) {
  // Four corners of each tet are numbered in 32 bits too.
  constexpr std::uint64_t limit = std::numeric_limits<std::uint32_t>::max() / 4;
  if (vertices > limit || tets > limit)
    at.fail("more than " + std::to_string(limit) + " vertices or tets", "use a coarser mesh");
}

MeshFile finish(RawMesh raw, const std::string& name, double scale) {
  check_scale(name, scale);
  TetMesh& mesh = raw.mesh;
  std::vector<std::string> notes;
  for (const auto& [kind, count] : raw.ignored) notes.push_back(std::to_string(count) + " " + kind + " ignored");
  notes.insert(notes.end(), raw.notes.begin(), raw.notes.end());
  if (mesh.tets.empty())
    throw InputError(name, "no tetrahedra in the file" + (notes.empty() ? "" : " (" + notes.front() + ")"),
                     "export a volume mesh of linear tetrahedra");
  for (Vec3& p : mesh.positions) p *= scale;
  MeshProblems problems = validate(mesh);
  turn_if_all_inverted(mesh, problems, notes);
  note_vertices(problems, notes);
  problems.unused.clear();
  if (problems.fatal())
    throw InputError(name, problems.describe(), "repair the mesh; numbers count from 0 in the file's order");
  return {std::move(mesh), std::move(notes)};
}

std::string pack_names(const std::map<std::int32_t, std::string>& names) {
  std::string packed;
  for (const auto& [region, name] : names) packed += name + '\0';
  return packed;
}

std::map<std::int32_t, std::string> unpack_names(const std::vector<std::int64_t>& ids, std::string_view packed,
                                                 const Cursor& at) {
  std::map<std::int32_t, std::string> names;
  for (const std::int64_t id : ids) {
    const std::size_t end = packed.find('\0');
    if (end == std::string_view::npos)
      at.fail("fewer region names than the " + std::to_string(ids.size()) + " region_ids",
              "end each name with a zero byte");
    names.emplace(to_region(static_cast<double>(id), at), std::string(packed.substr(0, end)));
    packed.remove_prefix(end + 1);
  }
  return names;
}

int region_array_rank(std::string_view name) {
  constexpr std::array<std::string_view, 6> known{"region", "gmsh:physical", "medit:ref",
                                                  "label",  "material",      "cellentityids"};
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto found = std::find(known.begin(), known.end(), lower);
  return found == known.end() ? 0 : static_cast<int>(found - known.begin()) + 1;
}

std::int32_t to_region(double value, const Cursor& at) {
  constexpr std::numeric_limits<std::int32_t> limits;
  if (!(value >= limits.min() && value <= limits.max()) || value != std::floor(value))
    at.fail("region " + std::to_string(value), "regions are whole 32-bit numbers");
  return static_cast<std::int32_t>(value);
}

Surface finish_surface(Surface surface, const std::string& name, double scale) {
  check_scale(name, scale);
  const std::size_t n = surface.positions.size();
  if (surface.triangles.empty()) throw InputError(name, "no triangles in the file", "export a triangle surface");
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    if (std::max({v[0], v[1], v[2]}) >= n)
      throw InputError(name, "triangle " + std::to_string(t) + " names a vertex that doesn't exist",
                       "repair the surface");
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
      throw InputError(name, "triangle " + std::to_string(t) + " has two corners at the same vertex",
                       "remove triangles without area; numbers count from 0 in the file's order");
  }
  for (std::size_t v = 0; v < n; ++v) {
    surface.positions[v] *= scale;
    if (!surface.positions[v].allFinite())
      throw InputError(name, "vertex " + std::to_string(v) + " has no finite position", "repair the surface");
  }
  return surface;
}

}  // namespace calot::detail
