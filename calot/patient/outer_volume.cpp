#include "calot/patient/outer_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"

namespace calot::detail {
namespace {

struct Areas {
  std::vector<double> outer, whole;  // of each region's boundary, from 0 [m²]
};

Areas areas_of(const TetMesh& mesh, const Surface& outer, std::size_t regions) {
  Areas areas{std::vector<double>(regions + 1, 0.0), std::vector<double>(regions + 1, 0.0)};
  const auto area = [](const Surface& s, const Triangle& t) {
    return (s.positions[t[1]] - s.positions[t[0]]).cross(s.positions[t[2]] - s.positions[t[0]]).norm() / 2;
  };
  for (std::size_t t = 0; t < outer.triangles.size(); ++t)
    areas.outer[static_cast<std::size_t>(outer.regions[t])] += area(outer, outer.triangles[t]);
  for (std::size_t r = 1; r <= regions; ++r) {
    const Surface own = region_surface(mesh, static_cast<std::int32_t>(r));
    for (const Triangle& t : own.triangles) areas.whole[r] += area(own, t);
  }
  return areas;
}

/// How far each region's outer surface is to move [m].
std::vector<double> offsets(const TetMesh& mesh, const Surface& outer, const std::vector<double>& volumes) {
  const Areas areas = areas_of(mesh, outer, volumes.size());
  std::vector<double> lack(volumes.size() + 1, 0.0);
  for (std::size_t r = 0; r < volumes.size(); ++r) lack[r + 1] = volumes[r];
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    lack[static_cast<std::size_t>(mesh.regions[t])] -= signed_volume(mesh, TetId(t));
  std::vector<double> offset(lack.size(), 0.0);
  constexpr double much = 0.3;  // of the boundary: with less, the facets that are missing lie elsewhere
  for (std::size_t r = 1; r < lack.size(); ++r)
    if (areas.outer[r] > much * areas.whole[r]) offset[r] = lack[r] / areas.outer[r];
  return offset;
}

/// Worst angles of the tets around a vertex.
bool angles_within(const TetMesh& mesh, const std::vector<TetId>& tets, double low, double high) {
  TetMesh part;
  part.positions = {};
  for (const TetId t : tets) {
    const auto first = static_cast<std::uint32_t>(part.positions.size());
    for (const VertexId v : mesh.tet(t)) part.positions.push_back(mesh.position(v));
    part.tets.push_back({VertexId(first), VertexId(first + 1), VertexId(first + 2), VertexId(first + 3)});
    part.regions.push_back(1);
  }
  const Quality q = quality(part);
  return q.min_volume > 0 && q.min_dihedral >= low && q.max_dihedral <= high;
}

double shortest_edge(const TetMesh& mesh, VertexId v, const std::vector<TetId>& tets) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const TetId t : tets)
    for (const VertexId w : mesh.tet(t))
      if (w != v) shortest = std::min(shortest, (mesh.position(w) - mesh.position(v)).norm());
  return shortest;
}

}  // namespace

void fit_outer_volumes(TetMesh& mesh, const std::vector<double>& volumes, double min_dihedral, double max_dihedral) {
  const VertexTets around = vertex_tets(mesh);
  for (int round = 0; round < 3; ++round) {
    const Surface outer = boundary_surface(mesh);
    const std::vector<double> offset = offsets(mesh, outer, volumes);
    std::vector<Vec3> move(outer.positions.size(), Vec3::Zero());
    std::vector<double> area(outer.positions.size(), 0.0);
    for (std::size_t t = 0; t < outer.triangles.size(); ++t) {
      const Triangle& c = outer.triangles[t];
      const Vec3 normal = (outer.positions[c[1]] - outer.positions[c[0]])
                              .cross(outer.positions[c[2]] - outer.positions[c[0]]);  // twice the area
      for (const std::uint32_t v : c) {
        move[v] += offset[static_cast<std::size_t>(outer.regions[t])] * normal;
        area[v] += normal.norm();
      }
    }
    for (std::size_t s = 0; s < move.size(); ++s) {
      const VertexId v = outer.vertex_of_mesh[s];
      const std::vector<TetId> tets(around.tets.begin() + around.start[v.index()],
                                    around.tets.begin() + around.start[v.index() + 1]);
      Vec3 step = move[s] / std::max(area[s], 1e-300);
      const double most = 0.1 * shortest_edge(mesh, v, tets);
      if (step.norm() > most) step *= most / step.norm();
      mesh.positions[v.index()] += step;
      if (!angles_within(mesh, tets, min_dihedral, max_dihedral)) mesh.positions[v.index()] -= step;
    }
  }
}

}  // namespace calot::detail
