#include "calot/mesh/surface_parameters.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "calot/base/error.h"

namespace calot {
namespace {

constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();
constexpr double same_place = 1e-6;  // of a triangle's size: rounding of a point put between two others is far below

void check_sharpness(double sharpness) {
  if (!(sharpness >= 1 && std::isfinite(sharpness)))
    throw InputError("textured surface", "the sharpness of the blend is below 1 or not finite", "use e.g. 4");
}

Vec3 weights_of(const Vec3& normal, double sharpness) {
  const Vec3 weights = normal.cwiseAbs().array().pow(sharpness);  // the largest is at least 3^(−k/2)
  return weights / weights.sum();
}

Surface boundary_of(const TetMesh& mesh, std::int32_t region) {
  return region == 0 ? boundary_surface(mesh) : region_surface(mesh, region);
}

Vec3 area_normal(const Surface& surface, const Triangle& t) {
  return (surface.positions[t[1]] - surface.positions[t[0]]).cross(surface.positions[t[2]] - surface.positions[t[0]]);
}

/// Unit normals everywhere: where the faces around a vertex cancel, that of its first face.
std::vector<Vec3> rest_normals(const Surface& surface) {
  std::vector<Vec3> normals = vertex_normals(surface, surface.positions);
  for (const Triangle& t : surface.triangles)
    for (const std::uint32_t v : t)
      if (normals[v].isZero(0)) normals[v] = area_normal(surface, t).stableNormalized();
  for (Vec3& normal : normals)
    if (!(normal.norm() > 0.5)) normal = Vec3::UnitZ();
  return normals;
}

/// A face of a tet that stays, by the numbers before the edit; sorts and compares.
struct FaceKey {
  TetId tet;
  std::array<VertexId, 3> vertices;  // ascending
  friend auto operator<=>(const FaceKey&, const FaceKey&) = default;
};

FaceKey key_of(TetId tet, VertexId a, VertexId b, VertexId c) {
  FaceKey key{tet, {a, b, c}};
  std::sort(key.vertices.begin(), key.vertices.end());
  return key;
}

/// Barycentric coordinates of a point in a triangle, or false if it lies outside or off its plane.
bool place_in(const Surface& surface, const Triangle& t, const Vec3& point, Vec3& place) {
  const Vec3 &a = surface.positions[t[0]], &b = surface.positions[t[1]], &c = surface.positions[t[2]];
  const Vec3 normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  const double size = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  if (!(area > 0) || std::abs(normal.dot(point - a)) > same_place * size * std::sqrt(area)) return false;
  place = {normal.dot((c - b).cross(point - b)) / area, normal.dot((a - c).cross(point - c)) / area, 0};
  place[2] = 1 - place[0] - place[1];
  return place.minCoeff() >= -same_place;
}

/// Carries parameters from the surface before an edit to the one after it.
class Transfer {
 public:
  Transfer(const TexturedSurface& before, const Remap& remap, TexturedSurface& after, double sharpness)
      : original_(before),
        before_(before),
        remap_(remap),
        after_(after),
        sharpness_(sharpness),
        set_(after.rest.size(), false) {
    index_before();
  }
  void move_vertices();
  void keep_vertices();
  void match_faces();
  void match_copies();

 private:
  void index_before();
  void match_piece(std::size_t face);
  bool match_piece_in(const Surface& surface, std::size_t face, std::uint32_t whole);
  void take(std::uint32_t to, std::uint32_t from);
  void interpolate(std::uint32_t to, const Triangle& triangle, const Vec3& place);
  [[nodiscard]] VertexId old_vertex(std::uint32_t v) const {
    return remap_.vertex_to_old[after_.surface.vertex_of_mesh[v].index()];
  }

  const TexturedSurface& original_;
  TexturedSurface before_;  // with the vertices that the edit moves at their new places; those that leave it stay unset
  const Remap& remap_;
  TexturedSurface& after_;
  double sharpness_;
  std::vector<bool> set_;                                  // of the vertices after the edit: parameters carried over
  std::vector<std::uint32_t> surface_vertex_;              // of the mesh's vertices before it, or nowhere
  std::vector<bool> left_;                                 // of the vertices before it: moved off the surface
  std::vector<std::pair<FaceKey, std::uint8_t>> staying_;  // faces of tets that stay, sorted; with their flags
  std::vector<std::uint32_t> lost_;                        // triangles whose tet is gone
};

void Transfer::index_before() {
  surface_vertex_.assign(remap_.vertex_to_new.size(), nowhere);
  const Surface& s = before_.surface;
  for (std::uint32_t v = 0; v < s.vertex_of_mesh.size(); ++v) surface_vertex_[s.vertex_of_mesh[v].index()] = v;
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
    const auto& [a, b, c] = s.triangles[t];
    if (remap_.tet_to_new[s.tet_of_triangle[t].index()].valid())
      staying_.emplace_back(key_of(s.tet_of_triangle[t], s.vertex_of_mesh[a], s.vertex_of_mesh[b], s.vertex_of_mesh[c]),
                            before_.exposed[t]);
    else
      lost_.push_back(t);
  }
  std::sort(staying_.begin(), staying_.end());
}

/// Vertices that slide along the surface take what it has where they come to lie; positions are those of the new place.
void Transfer::move_vertices() {
  left_.assign(original_.rest.size(), false);
  for (const MovedVertex& moved : remap_.moved) {
    const std::uint32_t v = surface_vertex_[moved.vertex.index()];
    if (v == nowhere) continue;
    before_.surface.positions[v] = before_.rest[v] = moved.position;
    left_[v] = true;
    for (const Triangle& t : original_.surface.triangles) {
      Vec3 place;
      if (std::find(t.begin(), t.end(), v) == t.end() || !place_in(original_.surface, t, moved.position, place))
        continue;
      Vec3 normal = Vec3::Zero();
      for (int c = 0; c < 3; ++c) normal += place[c] * original_.normals[t[static_cast<std::size_t>(c)]];
      if (!(normal.norm() > 1e-3)) continue;  // a fold: the faces around it know better
      before_.normals[v] = normal.normalized();
      before_.weights[v] = weights_of(before_.normals[v], sharpness_);
      left_[v] = false;
      break;
    }
  }
}

void Transfer::take(std::uint32_t to, std::uint32_t from) {
  if (left_[from]) return;  // the rest shape after the edit knows better
  after_.rest[to] = before_.rest[from];
  after_.normals[to] = before_.normals[from];
  after_.weights[to] = before_.weights[from];
  set_[to] = true;
}

void Transfer::interpolate(std::uint32_t to, const Triangle& triangle, const Vec3& place) {
  Vec3 normal = Vec3::Zero();
  for (int c = 0; c < 3; ++c) normal += place[c] * before_.normals[triangle[c]];
  if (!(normal.norm() > 1e-3)) return;  // a fold: the faces around it know better
  after_.normals[to] = normal.normalized();
  after_.weights[to] = weights_of(after_.normals[to], sharpness_);
  set_[to] = true;
}

void Transfer::keep_vertices() {
  for (std::uint32_t v = 0; v < after_.rest.size(); ++v) {
    const VertexId old = old_vertex(v);
    if (old.valid() && surface_vertex_[old.index()] != nowhere) take(v, surface_vertex_[old.index()]);
  }
}

void Transfer::match_faces() {
  for (std::size_t f = 0; f < after_.surface.triangles.size(); ++f) {
    after_.exposed[f] = 1;
    const TetId old = remap_.tet_to_old[after_.surface.tet_of_triangle[f].index()];
    if (!old.valid()) {
      match_piece(f);
      continue;
    }
    const auto& [a, b, c] = after_.surface.triangles[f];
    const FaceKey key = key_of(old, old_vertex(a), old_vertex(b), old_vertex(c));
    const auto at = std::lower_bound(staying_.begin(), staying_.end(), std::pair{key, std::uint8_t{0}});
    if (at != staying_.end() && at->first == key) after_.exposed[f] = at->second;
  }
}

/// A face of an added tet: a piece of a face that lost its tet, or laid open. That face may have moved a corner first.
void Transfer::match_piece(std::size_t face) {
  for (const std::uint32_t t : lost_)
    if (match_piece_in(before_.surface, face, t)) return;
  if (remap_.moved.empty()) return;
  for (const std::uint32_t t : lost_)
    if (match_piece_in(original_.surface, face, t)) return;
}

bool Transfer::match_piece_in(const Surface& surface, std::size_t face, std::uint32_t whole_face) {
  const Triangle &piece = after_.surface.triangles[face], &whole = surface.triangles[whole_face];
  std::array<Vec3, 3> places;
  if (!(area_normal(after_.surface, piece).dot(area_normal(surface, whole)) > 0)) return false;
  for (std::size_t c = 0; c < 3; ++c)
    if (!place_in(surface, whole, after_.surface.positions[piece[c]], places[c])) return false;
  after_.exposed[face] = before_.exposed[whole_face];
  for (std::size_t c = 0; c < 3; ++c) {
    if (set_[piece[c]]) continue;
    const auto corner = std::find_if(whole.begin(), whole.end(), [&](std::uint32_t v) {
      return before_.surface.positions[v] == after_.surface.positions[piece[c]];
    });
    corner != whole.end() ? take(piece[c], *corner) : interpolate(piece[c], whole, places[c]);
  }
  return true;
}

/// Copies that touch the surface with a corner only: by place.
void Transfer::match_copies() {
  std::vector<std::uint32_t> by_place;
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  };
  const std::vector<Vec3>& places = before_.surface.positions;
  for (const VertexId added : remap_.added_vertices) {
    const auto& on_surface = after_.surface.vertex_of_mesh;
    const auto at = std::lower_bound(on_surface.begin(), on_surface.end(), added);
    if (at == on_surface.end() || *at != added) continue;
    const auto v = static_cast<std::uint32_t>(at - on_surface.begin());
    if (set_[v]) continue;
    if (by_place.empty()) {
      for (std::uint32_t p = 0; p < places.size(); ++p) by_place.push_back(p);
      std::stable_sort(by_place.begin(), by_place.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return less(places[a], places[b]); });
    }
    const auto found = std::lower_bound(by_place.begin(), by_place.end(), after_.surface.positions[v],
                                        [&](std::uint32_t p, const Vec3& place) { return less(places[p], place); });
    if (found != by_place.end() && places[*found] == after_.surface.positions[v]) take(v, *found);
  }
}

TexturedSurface bare(const TetMesh& mesh, std::int32_t region, double sharpness) {
  check_sharpness(sharpness);
  TexturedSurface result;
  result.surface = boundary_of(mesh, region);
  result.rest = result.surface.positions;
  result.normals = rest_normals(result.surface);
  for (const Vec3& normal : result.normals) result.weights.push_back(weights_of(normal, sharpness));
  result.exposed.assign(result.surface.triangles.size(), 0);
  return result;
}

}  // namespace

TexturedSurface textured_surface(const TetMesh& mesh, std::int32_t region, double sharpness) {
  return bare(mesh, region, sharpness);
}

TexturedSurface after_edit(const TexturedSurface& before, const TetMesh& mesh, const Remap& remap, std::int32_t region,
                           double sharpness) {
  TexturedSurface after = bare(mesh, region, sharpness);
  Transfer transfer(before, remap, after, sharpness);
  transfer.move_vertices();
  transfer.keep_vertices();
  transfer.match_faces();
  transfer.match_copies();
  return after;
}

}  // namespace calot
