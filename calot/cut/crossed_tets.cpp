#include "calot/cut/crossed_tets.h"

#include "calot/base/error.h"
#include "calot/cut/swept_plane.h"

namespace calot {

std::vector<TetId> crossed_tets(const TetMesh& mesh, std::span<const Vec3> current, const Sweep& sweep) {
  if (current.size() != mesh.vertex_count())
    throw InputError("crossed_tets", "positions don't fit the mesh", "give one for each vertex");
  std::vector<TetId> crossed;
  const detail::SweptPlane plane(sweep, 0);
  if (plane.empty()) return crossed;
  std::vector<double> height(current.size());
  for (std::size_t v = 0; v < current.size(); ++v) height[v] = plane.height(current[v]);
  const auto crosses = [&](VertexId a, VertexId b) {
    const double ha = height[a.index()], hb = height[b.index()];
    if (!(ha * hb < 0)) return false;
    return plane.covers(current[a.index()] + ha / (ha - hb) * (current[b.index()] - current[a.index()]));
  };
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    bool hit = false;
    for (std::size_t a = 0; a < 4 && !hit; ++a)
      for (std::size_t b = a + 1; b < 4 && !hit; ++b) hit = crosses(tet[a], tet[b]);
    if (hit) crossed.push_back(TetId(t));
  }
  return crossed;
}

}  // namespace calot
