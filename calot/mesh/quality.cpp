#include "calot/mesh/quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "calot/mesh/tet_faces.h"

namespace calot {
namespace {

// Beyond this, cubes of lengths overflow and no volume can be computed.
constexpr double largest_coordinate = 1e100;

using Corners = std::array<Vec3, 4>;

Corners corners_of(const TetMesh& mesh, const Tet& tet) {
  return {mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])};
}

void add_dihedrals(const std::array<Vec3, 4>& outward, Quality& q) {
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const double angle = std::atan2(outward[i].cross(outward[j]).norm(), -outward[i].dot(outward[j]));
      q.min_dihedral = std::min(q.min_dihedral, angle * 180 / std::numbers::pi);
      q.max_dihedral = std::max(q.max_dihedral, angle * 180 / std::numbers::pi);
    }
}

/// 3·inradius/circumradius; 0 for a flat or inverted tet.
double radius_ratio(const Corners& p, double volume, double face_area_sum) {
  if (!(volume > 0)) return 0;
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], w = p[3] - p[0];
  const Vec3 numerator = w.squaredNorm() * u.cross(v) + v.squaredNorm() * w.cross(u) + u.squaredNorm() * v.cross(w);
  const double circumradius = numerator.norm() / (12 * volume), inradius = 3 * volume / face_area_sum;
  return 3 * inradius / circumradius;
}

void add_tet(const TetMesh& mesh, TetId t, Quality& q) {
  const Corners p = corners_of(mesh, mesh.tet(t));
  std::array<Vec3, 4> outward;  // twice the area of each face, along its outward normal
  double area_sum = 0;
  for (int f = 0; f < 4; ++f) {
    const auto& c = detail::face_corners[f];
    outward[f] = (p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]);
    area_sum += outward[f].norm() / 2;
  }
  const double volume = signed_volume(mesh, t);
  add_dihedrals(outward, q);
  q.min_volume = std::min(q.min_volume, volume);
  q.volume += volume;
  q.min_radius_ratio = std::min(q.min_radius_ratio, radius_ratio(p, volume, area_sum));
}

/// Each edge counts once, however many tets share it.
void measure_edges(const TetMesh& mesh, const std::vector<TetId>& tets, Quality& q) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(6 * tets.size());
  for (const TetId t : tets)
    for (const auto& [i, j] : detail::edge_corners)
      edges.push_back(std::minmax(mesh.tet(t)[i].value, mesh.tet(t)[j].value));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [a, b] : edges) {
    const double length = (mesh.positions[a] - mesh.positions[b]).norm();
    q.min_edge = std::min(q.min_edge, length);
    q.max_edge = std::max(q.max_edge, length);
    q.mean_edge += length / static_cast<double>(edges.size());
  }
}

Quality quality_of(const TetMesh& mesh, const std::vector<TetId>& tets) {
  Quality q;
  q.tets = tets.size();
  if (tets.empty()) return q;
  q.min_dihedral = q.min_edge = q.min_volume = q.min_radius_ratio = std::numeric_limits<double>::infinity();
  std::vector<bool> used(mesh.vertex_count(), false);
  for (const TetId t : tets) {
    for (const VertexId v : mesh.tet(t)) used[v.index()] = true;
    add_tet(mesh, t, q);
  }
  q.vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
  measure_edges(mesh, tets, q);
  return q;
}

/// @return for each vertex, the first one at its place: mostly itself
std::vector<VertexId> check_vertices(const TetMesh& mesh, MeshProblems& problems) {
  const std::size_t n = mesh.vertex_count();
  std::vector<std::uint32_t> order;
  for (std::size_t v = 0; v < n; ++v) {
    const Vec3& p = mesh.positions[v];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= largest_coordinate)
      order.push_back(static_cast<std::uint32_t>(v));
    else
      problems.not_finite.emplace_back(v);
  }
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = mesh.positions[a], &q = mesh.positions[b];
    for (int i = 0; i < 3; ++i)
      if (p[i] != q[i]) return p[i] < q[i];
    return a < b;
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<VertexId> at_place;
  at_place.reserve(n);
  for (std::size_t v = 0; v < n; ++v) at_place.emplace_back(v);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (mesh.positions[order[i]] != mesh.positions[order[i - 1]]) continue;
    at_place[order[i]] = at_place[order[i - 1]];
    problems.coincident.emplace_back(order[i]);
  }
  std::sort(problems.coincident.begin(), problems.coincident.end());
  return at_place;
}

/// Volume of a tet whose corners are known to exist and to differ.
void check_volume(const TetMesh& mesh, TetId t, MeshProblems& problems) {
  const Corners p = corners_of(mesh, mesh.tet(t));
  double longest = 0;
  for (const auto& [i, j] : detail::edge_corners) longest = std::max(longest, (p[i] - p[j]).norm());
  const double volume = signed_volume(p[0], p[1], p[2], p[3]);
  if (std::abs(volume) <= 1e-14 * longest * longest * longest)
    problems.flat.push_back(t);
  else if (volume < 0)
    problems.inverted.push_back(t);
}

void check_tets(const TetMesh& mesh, MeshProblems& problems) {
  const std::size_t n = mesh.vertex_count();
  std::vector<bool> used(n, false), finite(n, true);
  for (const VertexId v : problems.not_finite) finite[v.index()] = false;
  for (std::size_t i = 0; i < mesh.tet_count(); ++i) {
    const Tet& tet = mesh.tets[i];
    if (std::any_of(tet.begin(), tet.end(), [n](VertexId v) { return v.index() >= n; })) {
      problems.out_of_range.emplace_back(i);
      continue;
    }
    for (const VertexId v : tet) used[v.index()] = true;
    Tet sorted = tet;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
      problems.repeated_vertex.emplace_back(i);
    else if (std::all_of(tet.begin(), tet.end(), [&](VertexId v) { return finite[v.index()]; }))
      check_volume(mesh, TetId(i), problems);
  }
  for (std::size_t v = 0; v < n; ++v)
    if (!used[v]) problems.unused.emplace_back(v);
}

/// The same tets between places instead of vertices: a vertex at the place of an earlier one counts as that one. Tets
/// that have no volume for this reason are left out.
TetMesh joined_by_place(const TetMesh& mesh, const std::vector<VertexId>& at_place) {
  TetMesh joined{mesh.positions, {}, {}, {}};
  joined.tets.reserve(mesh.tet_count());
  for (Tet tet : mesh.tets) {
    for (VertexId& v : tet)
      if (v.index() < at_place.size()) v = at_place[v.index()];
    Tet sorted = tet;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) tet.fill(VertexId::none());
    joined.tets.push_back(tet);
  }
  return joined;
}

/// Tets that repeat an earlier one, and those at faces that three or more share. A mesh exported twice over differs in
/// numbers only, so tets between the same places count too; those on either side of a cut don't overlap.
void check_sharing(const TetMesh& mesh, const std::vector<VertexId>& at_place, MeshProblems& problems) {
  const TetMesh joined = joined_by_place(mesh, at_place);
  const std::vector<detail::TetFace> faces = detail::sorted_faces(joined);
  std::vector<bool> duplicate(mesh.tet_count(), false), overfull(mesh.tet_count(), false);
  const auto same_tet = [&](std::uint32_t a, std::uint32_t b) {
    return std::is_permutation(joined.tets[a].begin(), joined.tets[a].end(), joined.tets[b].begin());
  };
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    while (end < faces.size() && faces[end].key == faces[begin].key) ++end;
    for (std::size_t i = begin + 1; i < end; ++i)
      for (std::size_t j = begin; j < i && !duplicate[faces[i].tet]; ++j)
        if (faces[i].tet != faces[j].tet && same_tet(faces[i].tet, faces[j].tet)) duplicate[faces[i].tet] = true;
    if (end - begin < 3) continue;
    for (std::size_t i = begin; i < end; ++i) overfull[faces[i].tet] = true;
  }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (duplicate[t]) problems.duplicate.emplace_back(t);
    if (overfull[t]) problems.overfull_face.emplace_back(t);
  }
}

template <class Ids>
void describe_ids(const Ids& ids, const std::string& adjective, const std::string& noun, std::string& line) {
  if (ids.empty()) return;
  constexpr std::size_t named = 5;
  if (!line.empty()) line += ", ";
  line += std::to_string(ids.size()) + " " + adjective + (adjective.empty() ? "" : " ") + noun;
  for (std::size_t i = 0; i < std::min(named, ids.size()); ++i)
    line += (i == 0 ? " (" : ", ") + std::to_string(ids[i].value);
  line += ids.size() > named ? ", …)" : ")";
}

template <class Ids>
std::string counted(const Ids& ids, const char* one, const char* many) {
  return ids.size() == 1 ? one : many;
}

}  // namespace

Quality quality(const TetMesh& mesh) {
  std::vector<TetId> tets(mesh.tet_count());
  for (std::size_t t = 0; t < tets.size(); ++t) tets[t] = TetId(t);
  return quality_of(mesh, tets);
}

Quality quality(const TetMesh& mesh, std::int32_t region) {
  std::vector<TetId> tets;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.regions[t] == region) tets.emplace_back(t);
  return quality_of(mesh, tets);
}

bool MeshProblems::fatal() const {
  return sizes_differ || !(inverted.empty() && flat.empty() && repeated_vertex.empty() && out_of_range.empty() &&
                           duplicate.empty() && not_finite.empty() && overfull_face.empty());
}

std::string MeshProblems::describe() const {
  std::string line;
  const auto tets = [&](const std::vector<TetId>& ids, const char* adjective, const char* rest = "") {
    describe_ids(ids, adjective, counted(ids, "tet", "tets") + rest, line);
  };
  const auto vertices = [&](const std::vector<VertexId>& ids, const char* adjective, const char* rest = "") {
    describe_ids(ids, adjective, counted(ids, "vertex", "vertices") + rest, line);
  };
  tets(out_of_range, "", " naming vertices that don't exist");
  vertices(not_finite, "", " without a finite position");
  tets(repeated_vertex, "", " naming a vertex twice");
  tets(inverted, "inverted");
  tets(flat, "zero-volume");
  tets(duplicate, "repeated");
  tets(overfull_face, "", " at faces that three or more tets share");
  vertices(coincident, "", " at exactly the place of an earlier one");
  vertices(unused, "unused");
  if (sizes_differ) line += std::string(line.empty() ? "" : ", ") + "regions and tets differ in number";
  return line;
}

MeshProblems validate(const TetMesh& mesh) {
  MeshProblems problems;
  problems.sizes_differ = mesh.regions.size() != mesh.tets.size();
  const std::vector<VertexId> at_place = check_vertices(mesh, problems);
  check_tets(mesh, problems);
  check_sharing(mesh, at_place, problems);
  return problems;
}

std::size_t orient(TetMesh& mesh) {
  std::size_t turned = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (signed_volume(mesh, TetId(t)) >= 0) continue;
    std::swap(mesh.tets[t][2], mesh.tets[t][3]);
    ++turned;
  }
  return turned;
}

}  // namespace calot
