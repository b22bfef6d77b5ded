#include "calot/patient/line_place.h"

#include <algorithm>
#include <limits>

namespace calot::detail {

LineProjection project(const Centreline& line, const Vec3& point) {
  LineProjection best{0, std::numeric_limits<double>::infinity()};
  double before = 0;
  for (std::size_t p = 1; p < line.points.size(); ++p) {
    const Vec3 step = line.points[p] - line.points[p - 1];
    const double size = step.norm();
    const double t = size > 0 ? std::clamp((point - line.points[p - 1]).dot(step) / (size * size), 0.0, 1.0) : 0.0;
    const double distance = (line.points[p - 1] + t * step - point).norm();
    if (distance < best.distance) best = {before + t * size, distance};
    before += size;
  }
  return best;
}

std::map<Structure, Centreline> lines_towards_gallbladder(const std::vector<Centreline>& lines, const TetMesh& mesh) {
  const auto is_gallbladder = [](std::int32_t region) {
    return region == label_of(Structure::gallbladder) || region == label_of(Structure::gallbladder_wall);
  };
  const auto distance = [&](const Vec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
      if (is_gallbladder(mesh.regions[t]))
        for (const VertexId v : mesh.tets[t]) nearest = std::min(nearest, (mesh.position(v) - point).squaredNorm());
    return nearest;
  };
  std::map<Structure, Centreline> oriented;
  for (Centreline line : lines) {
    const auto structure = structure_named(line.name);
    if (!structure || !is_tube(*structure) || line.points.size() < 2) continue;
    if (distance(line.points.front()) < distance(line.points.back())) {
      std::reverse(line.points.begin(), line.points.end());
      std::reverse(line.radii.begin(), line.radii.end());
    }
    oriented.emplace(*structure, std::move(line));
  }
  return oriented;
}

}  // namespace calot::detail
