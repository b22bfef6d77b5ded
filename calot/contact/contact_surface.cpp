#include "calot/contact/contact_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/contact/box_tree.h"
#include "calot/contact/simplex_distance.h"

namespace calot {
namespace {

using detail::Box;
using detail::BoxTree;

// Face f of a tet lies opposite corner f; counter-clockwise from outside.
constexpr std::array<std::array<int, 3>, 4> corners_of_face{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

struct Face {
  std::array<std::uint32_t, 3> key;
  std::uint32_t tet, face;
};

ContactTriangle triangle_of(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  ContactTriangle triangle;
  for (int c = 0; c < 3; ++c) triangle.vertices[c] = mesh.tets[tet][corners_of_face[face][c]];
  triangle.tet = TetId(tet);
  triangle.face = face;
  triangle.region = mesh.regions[tet];
  return triangle;
}

bool before(const ContactTriangle& a, const ContactTriangle& b) {
  return a.tet != b.tet ? a.tet < b.tet : a.face < b.face;
}

/// The faces all of whose vertices are marked and that one tet only has, in order of (tet, face).
std::vector<ContactTriangle> single_faces(const TetMesh& mesh, const std::vector<std::uint8_t>& marked) {
  std::vector<Face> faces;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    int count = 0;
    for (const VertexId v : tet) count += marked[v.index()];
    if (count < 3) continue;
    for (std::uint32_t f = 0; f < 4; ++f) {
      if (count - marked[tet[f].index()] < 3) continue;
      Face face{{}, t, f};
      for (int c = 0; c < 3; ++c) face.key[c] = tet[corners_of_face[f][c]].value;
      std::sort(face.key.begin(), face.key.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.tet != b.tet ? a.tet < b.tet : a.face < b.face;
  });
  std::vector<ContactTriangle> single;
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    for (end = begin; end < faces.size() && faces[end].key == faces[begin].key;) ++end;
    if (end == begin + 1) single.push_back(triangle_of(mesh, faces[begin].tet, faces[begin].face));
  }
  std::sort(single.begin(), single.end(), before);
  return single;
}

Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 twice_area = (b - a).cross(c - a);
  const double length = twice_area.stableNorm();
  return length > 0 ? Vec3(twice_area / length) : Vec3(Vec3::Zero());
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

Eigen::Matrix3d contact_frame(const Vec3& normal) {
  // The axis that the normal is least along gives the first tangent.
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(normal(a)) < std::abs(normal(axis))) axis = a;
  const Vec3 tangent = normal.cross(Vec3::Unit(axis)).normalized();
  Eigen::Matrix3d frame;
  frame << normal.transpose(), tangent.transpose(), normal.cross(tangent).transpose();
  return frame;
}

ContactSurface::ContactSurface(const TetMesh& mesh)
    : triangles_(single_faces(mesh, std::vector<std::uint8_t>(mesh.vertex_count(), 1))),
      rest_(mesh.positions),
      tree_(std::make_unique<BoxTree>()) {
  index_vertices(mesh.vertex_count());
}
ContactSurface::~ContactSurface() = default;
ContactSurface::ContactSurface(ContactSurface&&) noexcept = default;
ContactSurface& ContactSurface::operator=(ContactSurface&&) noexcept = default;

void ContactSurface::follow(const TetMesh& mesh, const Remap& remap) {
  // A face can only begin or end to be boundary if tets at all its corners came or went.
  std::vector<std::uint8_t> marked(mesh.vertex_count(), 0);
  for (const VertexId v : remap.touched)
    if (remap.vertex_to_new[v.index()].valid()) marked[remap.vertex_to_new[v.index()].index()] = 1;
  for (const VertexId v : remap.added_vertices) marked[v.index()] = 1;
  std::vector<ContactTriangle> kept;
  kept.reserve(triangles_.size());
  for (ContactTriangle triangle : triangles_) {
    triangle.tet = remap.tet_to_new[triangle.tet.index()];
    if (!triangle.tet.valid()) continue;
    int count = 0;
    for (VertexId& v : triangle.vertices) {
      v = remap.vertex_to_new[v.index()];
      count += marked[v.index()];
    }
    if (count < 3) kept.push_back(triangle);
  }
  const std::vector<ContactTriangle> decided = single_faces(mesh, marked);
  triangles_.resize(kept.size() + decided.size());
  std::merge(kept.begin(), kept.end(), decided.begin(), decided.end(), triangles_.begin(), before);
  rest_ = mesh.positions;
  index_vertices(mesh.vertex_count());
  tree_is_stale_ = true;
}

void ContactSurface::index_vertices(std::size_t vertices) {
  start_.assign(vertices + 1, 0);
  for (const ContactTriangle& t : triangles_)
    for (const VertexId v : t.vertices) ++start_[v.index() + 1];
  for (std::size_t v = 0; v < vertices; ++v) start_[v + 1] += start_[v];
  around_.resize(3 * triangles_.size());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i)
    for (const VertexId v : triangles_[i].vertices) around_[next[v.index()]++] = i;
  rest_faces_.resize(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const auto& v = triangles_[i].vertices;
    const Vec3 &a = rest_[v[0].index()], &b = rest_[v[1].index()], &c = rest_[v[2].index()];
    rest_faces_[i] = {(a + b + c) / 3, unit_normal(a, b, c)};
  }
}

void ContactSurface::refit(std::span<const Vec3> positions, std::span<const Vec3> motion, double margin) {
  if (positions.size() != rest_.size() || (!motion.empty() && motion.size() != rest_.size()))
    throw InputError("contact surface",
                     std::to_string(positions.size()) + " positions for " + std::to_string(rest_.size()) + " vertices");
  positions_.assign(positions.begin(), positions.end());
  motion_.assign(motion.begin(), motion.end());
  motion_.resize(positions_.size(), Vec3::Zero());
  double largest = 0;
  for (const Vec3& m : motion_) largest = std::max(largest, m.squaredNorm());
  largest_motion_ = std::sqrt(largest);
  normals_.resize(triangles_.size());
  std::vector<Box> boxes(triangles_.size()), facing(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    for (const VertexId v : triangles_[i].vertices) {
      boxes[i].add(positions_[v.index()]);
      if (largest > 0) boxes[i].add(positions_[v.index()] + motion_[v.index()]);
    }
    boxes[i].widen(0.5 * margin);
    const auto& v = triangles_[i].vertices;
    normals_[i] = unit_normal(positions_[v[0].index()], positions_[v[1].index()], positions_[v[2].index()]);
    facing[i].add(normals_[i]);
  }
  // A tree whose leaves have grown, because parts moved apart, is worth building anew.
  if (tree_is_stale_) tree_->build(boxes, facing);
  if (tree_->refit(boxes, facing) > 2 && !tree_is_stale_) {
    tree_->build(boxes, facing);
    tree_->refit(boxes, facing);
  }
  tree_is_stale_ = false;
}

ContactSurface::Nearest ContactSurface::nearest(const Vec3& p) const {
  Nearest best;
  double least = std::numeric_limits<double>::infinity();
  Vec3 from_surface = Vec3::Zero();
  tree_->nearest(p, least, [&](std::uint32_t i) {
    const auto& v = triangles_[i].vertices;
    const detail::Corners corners{positions_[v[0].index()], positions_[v[1].index()], positions_[v[2].index()]};
    const Vec3 weights = detail::closest_on_triangle(p, corners[0], corners[1], corners[2]);
    const Vec3 d = p - detail::weighted(corners, weights);
    const double squared = d.squaredNorm();
    if (squared < least || (squared == least && i < best.triangle)) {
      least = squared;
      best.triangle = i;
      best.weights = weights;
      from_surface = d;
    }
    return least;
  });
  // On an edge or a corner, all triangles there, by their angle, say which side is out [Baerentzen2005].
  Vec3 out = Vec3::Zero();
  const auto& v = triangles_[best.triangle].vertices;
  int first = -1, zeros = 0;
  for (int c = 0; c < 3; ++c) {
    if (best.weights(c) > 1e-9)
      first = c;
    else
      ++zeros;
  }
  if (zeros == 0) out = normals_[best.triangle];
  for (const std::uint32_t i : zeros > 0 ? around(v[first]) : std::span<const std::uint32_t>()) {
    const auto& w = triangles_[i].vertices;
    bool has_all = true;
    int corner = 0;
    for (int c = 0; c < 3; ++c) {
      if (best.weights(c) > 1e-9) has_all = has_all && std::find(w.begin(), w.end(), v[c]) != w.end();
      if (w[c] == v[first]) corner = c;
    }
    if (!has_all) continue;
    const Vec3& at = positions_[v[first].index()];
    const double share = zeros == 1 ? 1
                                    : angle_between(positions_[w[(corner + 1) % 3].index()] - at,
                                                    positions_[w[(corner + 2) % 3].index()] - at);
    out += share * normals_[i];
  }
  best.distance = std::copysign(std::sqrt(least), from_surface.dot(out) >= 0 ? 1.0 : -1.0);
  return best;
}

StillSurface::StillSurface(Surface surface, double friction, bool two_sided)
    : surface_(std::move(surface)), friction_(friction), two_sided_(two_sided), tree_(std::make_unique<BoxTree>()) {
  for (const Vec3& p : surface_.positions)
    if (!p.allFinite()) throw InputError("still surface", "a vertex isn't at a finite place");
  std::vector<Box> boxes(surface_.triangles.size()), facing(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Triangle& t = surface_.triangles[i];
    for (const std::uint32_t v : t) {
      if (v >= surface_.positions.size())
        throw InputError("still surface", "triangle " + std::to_string(i) + " names vertex " + std::to_string(v) +
                                              " of " + std::to_string(surface_.positions.size()));
      boxes[i].add(surface_.positions[v]);
    }
    normals_.push_back(unit_normal(surface_.positions[t[0]], surface_.positions[t[1]], surface_.positions[t[2]]));
    facing[i].add(normals_[i]);
  }
  tree_->build(boxes);
  tree_->refit(boxes, two_sided_ ? std::span<const Box>() : std::span<const Box>(facing));
}
StillSurface::~StillSurface() = default;
StillSurface::StillSurface(StillSurface&&) noexcept = default;
StillSurface& StillSurface::operator=(StillSurface&&) noexcept = default;

}  // namespace calot
