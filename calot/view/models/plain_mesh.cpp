#include "calot/view/models/plain_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

using std::numbers::pi;

std::uint32_t add_point(PlainMesh& mesh, const Vec3& point) {
  mesh.positions.push_back(point);
  mesh.openness.push_back(1);
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

std::uint32_t add_ring(PlainMesh& mesh, const Ring& ring) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3& point : ring) add_point(mesh, point);
  return first;
}

void add_band(PlainMesh& mesh, std::uint32_t below, std::uint32_t above, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({below + i, below + next, above + next});
    mesh.triangles.push_back({below + i, above + next, above + i});
  }
}

void add_fan(PlainMesh& mesh, std::uint32_t ring, std::uint32_t count, const Vec3& middle, bool looks_back) {
  const std::uint32_t centre = add_point(mesh, middle);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    if (looks_back)
      mesh.triangles.push_back({centre, ring + next, ring + i});
    else
      mesh.triangles.push_back({centre, ring + i, ring + next});
  }
}

Vec3 middle_of(const Ring& ring) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& point : ring) sum += point;
  return sum / static_cast<double>(ring.size());
}

/// Weighted by the corner's angle, so that how a face is cut into triangles makes no difference.
double corner_angle(const PlainMesh& mesh, const Triangle& t, std::size_t corner) {
  const Vec3& at = mesh.positions[t[corner]];
  const Vec3 a = mesh.positions[t[(corner + 1) % 3]] - at, b = mesh.positions[t[(corner + 2) % 3]] - at;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// A direction in the surface, as near to the wanted one as it goes.
Vec3f in_surface(const Vec3& wanted, const Vec3& normal) {
  Vec3 along = wanted - wanted.dot(normal) * normal;
  if (along.norm() < 1e-3 * wanted.norm() || wanted.norm() == 0) along = normal.unitOrthogonal();
  return along.normalized().cast<float>();
}

}  // namespace

void add_loft(PlainMesh& mesh, std::span<const Ring> rings) {
  const auto count = static_cast<std::uint32_t>(rings.front().size());
  std::uint32_t below = add_ring(mesh, rings.front());
  add_fan(mesh, below, count, middle_of(rings.front()), true);
  for (const Ring& ring : rings.subspan(1)) {
    const std::uint32_t above = add_ring(mesh, ring);
    add_band(mesh, below, above, count);
    below = above;
  }
  add_fan(mesh, below, count, middle_of(rings.back()), false);
}

void add_closed_loft(PlainMesh& mesh, std::span<const Ring> rings) {
  const auto count = static_cast<std::uint32_t>(rings.front().size());
  const std::uint32_t first = add_ring(mesh, rings.front());
  std::uint32_t below = first;
  for (const Ring& ring : rings.subspan(1)) {
    const std::uint32_t above = add_ring(mesh, ring);
    add_band(mesh, below, above, count);
    below = above;
  }
  add_band(mesh, below, first, count);
}

void add_turned(PlainMesh& mesh, std::span<const Turned> profile, const Vec3& origin, const Vec3& axis, int segments) {
  const Vec3 up = axis.normalized(), side = up.unitOrthogonal(), other = up.cross(side);
  const auto count = static_cast<std::uint32_t>(segments);
  std::span<const Turned> rings = profile;
  const bool starts_in_point = profile.front().radius <= 0, ends_in_point = profile.back().radius <= 0;
  if (starts_in_point) rings = rings.subspan(1);
  if (ends_in_point) rings = rings.first(rings.size() - 1);
  std::uint32_t below = 0;
  for (std::size_t k = 0; k < rings.size(); ++k) {
    Ring ring;
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * pi * i / segments;
      ring.push_back(origin + rings[k].along * up +
                     rings[k].radius * (std::cos(angle) * side + std::sin(angle) * other));
    }
    const std::uint32_t above = add_ring(mesh, ring);
    if (k > 0)
      add_band(mesh, below, above, count);
    else
      add_fan(mesh, above, count, origin + profile.front().along * up, true);
    below = above;
  }
  add_fan(mesh, below, count, origin + profile.back().along * up, false);
}

std::vector<Turned> dome(double radius, double top, int steps) {
  std::vector<Turned> profile;
  for (int k = 0; k <= steps; ++k) {
    const double angle = pi / 2 * k / steps;
    profile.push_back({k == steps ? 0 : radius * std::cos(angle), top - radius + radius * std::sin(angle)});
  }
  return profile;
}

void add_rod(PlainMesh& mesh, std::span<const Vec3> path, std::span<const double> scale, const Outline& section,
             const Vec3& sideways) {
  std::vector<Ring> rings;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Vec3 along = (path[std::min(k + 1, path.size() - 1)] - path[k == 0 ? 0 : k - 1]).normalized();
    const Vec3 x = (sideways - sideways.dot(along) * along).normalized(), y = along.cross(x);
    Ring ring;
    for (const Eigen::Vector2d& p : section) ring.push_back(path[k] + scale[k] * (p.x() * x + p.y() * y));
    rings.push_back(std::move(ring));
  }
  add_loft(mesh, rings);
}

Outline circle(double radius, int points) {
  Outline outline;
  for (int k = 0; k < points; ++k)
    outline.emplace_back(radius * std::cos(2 * pi * k / points), radius * std::sin(2 * pi * k / points));
  return outline;
}

Outline rounded_rectangle(double half_x, double half_y, double corner, int steps_per_corner) {
  Outline outline;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double sign_x = quarter == 0 || quarter == 3 ? 1 : -1, sign_y = quarter < 2 ? 1 : -1;
    const Eigen::Vector2d middle(sign_x * (half_x - corner), sign_y * (half_y - corner));
    for (int k = 0; k <= steps_per_corner; ++k) {
      const double angle = pi / 2 * (quarter + static_cast<double>(k) / steps_per_corner);
      outline.push_back(middle + corner * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  return outline;
}

ModelPart finish(const PlainMesh& mesh, ModelFrame frame, ModelMaterial material, double crease,
                 const std::function<Vec3(const Vec3&)>& grain) {
  ModelPart part{frame, material, {}, {}, {}, {}, {}};
  std::vector<Vec3> faces;
  std::vector<std::vector<std::uint32_t>> around(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions[t[0]];
    faces.push_back((mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).normalized());
    for (const std::uint32_t v : t) around[v].push_back(static_cast<std::uint32_t>(faces.size() - 1));
  }
  std::vector<std::vector<std::pair<Vec3, std::uint32_t>>> made(mesh.positions.size());
  const auto vertex_with = [&](std::uint32_t v, const Vec3& normal) {
    for (const auto& [known, vertex] : made[v])
      if (known.dot(normal) > 1 - 1e-6) return vertex;
    part.positions.push_back(mesh.positions[v].cast<float>());
    part.normals.push_back(normal.cast<float>());
    part.grains.push_back(in_surface(grain(mesh.positions[v]), normal));
    part.openness.push_back(mesh.openness[v]);
    made[v].emplace_back(normal, static_cast<std::uint32_t>(part.positions.size() - 1));
    return made[v].back().second;
  };
  const double least = std::cos(crease);
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    Triangle out{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = mesh.triangles[k][corner];
      Vec3 normal = Vec3::Zero();
      for (const std::uint32_t face : around[v]) {
        if (faces[face].dot(faces[k]) < least) continue;
        const Triangle& t = mesh.triangles[face];
        normal +=
            corner_angle(mesh, t, static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin())) * faces[face];
      }
      out[corner] = vertex_with(v, normal.normalized());
    }
    part.triangles.push_back(out);
  }
  return part;
}

}  // namespace calot::detail
