#include "calot/mesh/tet_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <numeric>
#include <set>

#include "calot/base/error.h"

namespace calot {
namespace {

/// Regions that the mesh's tets carry, with names, for messages: "2 (gallbladder), 3".
std::string list_regions(const TetMesh& mesh, const std::set<std::int32_t>& present) {
  if (present.empty()) return "none";
  std::string list;
  for (const std::int32_t region : present) {
    if (!list.empty()) list += ", ";
    list += std::to_string(region);
    const auto name = mesh.region_names.find(region);
    if (name != mesh.region_names.end()) list += " (" + name->second + ")";
  }
  return list;
}

}  // namespace

double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6.0;
}

double signed_volume(const TetMesh& mesh, TetId tet) {
  const Tet& t = mesh.tet(tet);
  return signed_volume(mesh.position(t[0]), mesh.position(t[1]), mesh.position(t[2]), mesh.position(t[3]));
}

std::vector<std::int32_t> regions_matching(const TetMesh& mesh, const std::string& name, const std::string& where) {
  const std::set<std::int32_t> present(mesh.regions.begin(), mesh.regions.end());
  if (name == "*") return {present.begin(), present.end()};
  std::int32_t number = 0;
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool is_number = code == std::errc() && end == name.data() + name.size() && !name.empty();
  std::vector<std::int32_t> found;
  for (const std::int32_t region : present) {
    const auto known = mesh.region_names.find(region);
    const bool named = known != mesh.region_names.end() && known->second == name;
    if (named || (is_number && region == number)) found.push_back(region);
  }
  if (found.empty())
    throw InputError(where, "no region \"" + name + "\" in the mesh", "use one of: " + list_regions(mesh, present));
  return found;
}

VertexTets vertex_tets(const TetMesh& mesh) {
  VertexTets around;
  around.start.assign(mesh.vertex_count() + 1, 0);
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet) ++around.start[v.index() + 1];
  std::partial_sum(around.start.begin(), around.start.end(), around.start.begin());
  around.tets.resize(4 * mesh.tet_count());
  std::vector<std::uint32_t> next(around.start.begin(), around.start.end() - 1);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (const VertexId v : mesh.tets[t]) around.tets[next[v.index()]++] = TetId(t);
  return around;
}

}  // namespace calot
