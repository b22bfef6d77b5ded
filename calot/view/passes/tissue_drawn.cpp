#include "calot/view/passes/tissue_drawn.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

namespace calot::detail {
namespace {

struct StillVertex {
  std::array<float, 3> rest;
  std::array<std::int16_t, 4> normal;
};

std::vector<StillVertex> still_vertices(const TissueSkin& skin) {
  std::vector<Vec3f> normals(skin.vertices.size(), Vec3f::Zero());
  for (const auto& [a, b, c] : skin.triangles) {
    const Vec3f &p = skin.vertices[a].rest, &q = skin.vertices[b].rest, &r = skin.vertices[c].rest;
    const Vec3f normal = (q - p).cross(r - p);
    for (const std::uint32_t v : {a, b, c}) normals[v] += normal;
  }
  std::vector<StillVertex> out(normals.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vec3f& rest = skin.vertices[i].rest;
    out[i] = {{rest.x(), rest.y(), rest.z()}, packed_normal(normals[i].stableNormalized())};
  }
  return out;
}

}  // namespace

void TissueDrawn::send_skin(const TissueSkin& skin) {
  version_ = skin.version;
  ++index_uploads_;
  stream_.set_skin(skin);
  const std::vector<StillVertex> still = still_vertices(skin);
  std::vector<Triangle> triangles = skin.triangles;
  const auto key = [&](const Triangle& t) { return std::tuple(skin.vertices[t[0]].cut, skin.vertices[t[0]].look); };
  std::stable_sort(triangles.begin(), triangles.end(),
                   [&](const Triangle& a, const Triangle& b) { return key(a) < key(b); });
  parts_.clear();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (t == 0 || key(triangles[t]) != key(triangles[t - 1]))
      parts_.push_back({std::get<1>(key(triangles[t])), std::get<0>(key(triangles[t])), 3 * t, 0});
    parts_.back().count += 3;
  }
  if (!vertices_) vertices_ = GlVertexArray::make();
  glBindVertexArray(vertices_.number());
  indices_ = make_buffer(GL_ELEMENT_ARRAY_BUFFER, triangles.data(), triangles.size() * sizeof(Triangle));
  still_ = make_buffer(GL_ARRAY_BUFFER, still.data(), still.size() * sizeof(StillVertex));
  attribute(3, 3, GL_FLOAT, false, sizeof(StillVertex), offsetof(StillVertex, rest));
  attribute(4, 3, GL_SHORT, true, sizeof(StillVertex), offsetof(StillVertex, normal));
}

void TissueDrawn::upload(const Snapshot& snapshot) {
  if (snapshot.skin.version != version_) send_skin(snapshot.skin);
  const std::size_t n = stream_.vertex_count();
  if (n == 0) return;
  do {
    auto* out = static_cast<StreamVertex*>(moving_.map(n * sizeof(StreamVertex)));
    stream_.pack(snapshot.positions, snapshot.conditions, out);
  } while (!moving_.unmap());
  glBindVertexArray(vertices_.number());
  attribute(0, 3, GL_FLOAT, false, sizeof(StreamVertex), offsetof(StreamVertex, position));
  attribute(1, 3, GL_SHORT, true, sizeof(StreamVertex), offsetof(StreamVertex, normal));
  attribute(2, 4, GL_UNSIGNED_BYTE, true, sizeof(StreamVertex), offsetof(StreamVertex, condition));
}

void TissueDrawn::add_to(std::vector<Drawable>& drawables) const {
  for (const Part& part : parts_) {
    Drawable d;
    d.look = part.look;
    d.cut = part.cut;
    d.vertices = vertices_.number();
    d.first = part.first;
    d.count = static_cast<GLsizei>(part.count);
    drawables.push_back(d);
  }
}

}  // namespace calot::detail
