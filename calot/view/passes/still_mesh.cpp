#include "calot/view/passes/still_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/view/surface_stream.h"

namespace calot::detail {
namespace {

struct Corner {
  std::array<float, 3> position;
  std::array<std::int16_t, 4> normal, grain;  // fourth of the grain: openness
};

}  // namespace

StillMesh::StillMesh(const ModelPart& part)
    : count_(static_cast<GLsizei>(3 * part.triangles.size())), material_(part.material) {
  std::vector<Corner> corners(part.positions.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3f& p = part.positions[i];
    corners[i] = {{p.x(), p.y(), p.z()}, packed_normal(part.normals[i]), packed_normal(part.grains[i])};
    corners[i].grain[3] = static_cast<std::int16_t>(std::lrint(part.openness[i] * 32767.0F));
  }
  vertices_ = GlVertexArray::make();
  glBindVertexArray(vertices_.number());
  indices_ = make_buffer(GL_ELEMENT_ARRAY_BUFFER, part.triangles.data(), part.triangles.size() * sizeof(Triangle));
  corners_ = make_buffer(GL_ARRAY_BUFFER, corners.data(), corners.size() * sizeof(Corner));
  attribute(0, 3, GL_FLOAT, false, sizeof(Corner), offsetof(Corner, position));
  attribute(1, 3, GL_SHORT, true, sizeof(Corner), offsetof(Corner, normal));
  attribute(5, 4, GL_SHORT, true, sizeof(Corner), offsetof(Corner, grain));
}

Drawable StillMesh::drawable() const {
  Drawable d;
  d.kind = SurfaceKind::instrument;
  d.vertices = vertices_.number();
  d.count = count_;
  d.substance = static_cast<int>(material_);
  return d;
}

ModelPart part_of(const Surface& surface) {
  ModelPart part;
  part.triangles = surface.triangles;
  part.normals.assign(surface.positions.size(), Vec3f::Zero());
  for (const Vec3& p : surface.positions) part.positions.push_back(p.cast<float>());
  for (const auto& [a, b, c] : part.triangles) {
    const Vec3f normal = (part.positions[b] - part.positions[a]).cross(part.positions[c] - part.positions[a]);
    for (const std::uint32_t v : {a, b, c}) part.normals[v] += normal;
  }
  for (Vec3f& n : part.normals) n = n.stableNormalized();
  part.grains.assign(part.positions.size(), Vec3f::Zero());
  part.openness.assign(part.positions.size(), 1);
  return part;
}

namespace {

/// Lumps of the wall, a few centimetres wide, -1 ... 1.
float lumps(const Vec3f& p) {
  const Vec3f a = 95.0F * p, b = 58.0F * Vec3f(p.y(), p.z(), p.x());
  return 0.5F * std::sin(a.x() + 1.7F * std::sin(b.x())) * std::sin(a.y() + 1.3F * std::sin(b.y())) +
         0.5F * std::sin(b.z() + 2.1F * std::sin(0.7F * a.z())) * std::sin(0.8F * b.x() + 1.1F);
}

}  // namespace

ModelPart cavity_dome(const Vec3f& middle, float radius) {
  constexpr int rings = 48, sectors = 96;
  Surface surface;
  for (int ring = 0; ring <= rings; ++ring)
    for (int sector = 0; sector < sectors; ++sector) {
      const float polar = std::numbers::pi_v<float> * static_cast<float>(ring) / rings;
      const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(sector) / sectors;
      const Vec3f out(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
      const float here = radius + 0.009F * lumps(radius * out);
      surface.positions.push_back((middle + here * out).cast<double>());
    }
  for (std::uint32_t ring = 0; ring < rings; ++ring)
    for (std::uint32_t sector = 0; sector < sectors; ++sector) {
      const std::uint32_t a = ring * sectors + sector, b = ring * sectors + (sector + 1) % sectors;
      surface.triangles.push_back({a, b, a + sectors});
      surface.triangles.push_back({b, b + sectors, a + sectors});
    }
  ModelPart part = part_of(surface);
  for (const int pole : {0, rings}) {
    const auto first = part.normals.begin() + pole * sectors;
    std::fill(first, first + sectors, Vec3f(0, 0, pole == 0 ? -1.0F : 1.0F));
  }
  return part;
}

}  // namespace calot::detail
