// Tissue against moving rigid shapes: each piece is followed along its screw motion until it comes near a triangle.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/contact/box_tree.h"
#include "calot/contact/detect_parts.h"
#include "calot/contact/simplex_distance.h"

namespace calot::detail {
namespace {

constexpr double on_it = 1e-9;         // weights below this: not on that corner's side
constexpr double least_cosine = 0.87;  // a direction may be bent by 30° to fit the surface
constexpr int finest = 64;             // samples of a path

/// Which of a triangle's corners a point on it belongs to: one (a vertex), two (an edge) or three (the face).
struct Feature {
  std::array<VertexId, 3> vertices;  // ascending
  int count = 0;
  Feature(const ContactTriangle& triangle, const Vec3& weights) {
    for (int c = 0; c < 3; ++c)
      if (weights(c) > on_it) vertices[count++] = triangle.vertices[c];
    // Ascending; three values need three exchanges at most.
    if (count > 1 && vertices[1] < vertices[0]) std::swap(vertices[0], vertices[1]);
    if (count > 2 && vertices[2] < vertices[1]) std::swap(vertices[1], vertices[2]);
    if (count > 2 && vertices[1] < vertices[0]) std::swap(vertices[0], vertices[1]);
  }
  [[nodiscard]] bool has(VertexId v) const {
    return std::find(vertices.begin(), vertices.begin() + count, v) != vertices.begin() + count;
  }
  [[nodiscard]] bool within(const ContactTriangle& triangle) const {
    for (int i = 0; i < count; ++i)
      if (std::find(triangle.vertices.begin(), triangle.vertices.end(), vertices[i]) == triangle.vertices.end())
        return false;
    return true;
  }
};

/// The contacts of one shape.
class ShapeContacts {
 public:
  ShapeContacts(const ContactSurface& surface, const MovingShape& moving, std::uint32_t number,
                const ContactOptions& options, std::vector<Candidate>& found)
      : surface_(surface), moving_(moving), number_(number), options_(options), found_(found) {
    screw_ = screw_between(moving.from, moving.to);
    for (const RoundedPiece& piece : moving.shape->pieces) longest_ = std::max(longest_, path_of(piece));
    const double steps = std::ceil((longest_ + surface.largest_motion()) / (0.5 * options.margin));
    samples_ = static_cast<int>(std::clamp(steps, 1.0, double(finest)));
    for (int k = 0; k <= samples_; ++k) poses_.push_back(pose_on(moving.from, screw_, double(k) / samples_));
  }

  void find() {
    for (std::uint32_t i = 0; i < moving_.shape->pieces.size(); ++i) {
      piece_ = i;
      const RoundedPiece& piece = moving_.shape->pieces[i];
      path_ = path_of(piece);
      place_cores(piece);
      surface_.tree().each(swept_box(piece), [&](std::uint32_t triangle) { follow(piece, triangle); });
      find_inside(piece);
    }
  }

 private:
  /// How far the corner that moves most comes; on a screw every point keeps its speed.
  [[nodiscard]] double path_of(const RoundedPiece& piece) const {
    double longest = 0;
    for (int c = 0; c < piece.corner_count; ++c)
      longest = std::max(longest, (screw_.turn.cross(moving_.from.rotation * piece.corners[c]) + screw_.shift).norm());
    return longest;
  }

  [[nodiscard]] Box swept_box(const RoundedPiece& piece) const {
    Box box;
    for (const Corners& core : cores_)
      for (const Vec3& corner : core) box.add(corner);
    // Between samples a corner leaves its chord by an eighth of (arc × angle).
    const double bulge = path_ * screw_.turn.norm() / (8.0 * samples_ * samples_);
    box.widen(piece.radius + 0.5 * options_.margin + bulge);
    return box;
  }

  /// Where the piece's corners are at every sample.
  void place_cores(const RoundedPiece& piece) {
    cores_.resize(poses_.size());
    for (std::size_t k = 0; k < poses_.size(); ++k)
      for (int c = 0; c < 3; ++c)
        cores_[k][c] = c < piece.corner_count ? Vec3(poses_[k] * piece.corners[c]) : cores_[k][0];
  }
  [[nodiscard]] Vec3 tissue_at(VertexId v, int k) const {
    return surface_.positions()[v.index()] + (double(k) / samples_) * surface_.motion()[v.index()];
  }
  [[nodiscard]] Corners triangle_at(std::uint32_t triangle, int k) const {
    const auto& v = surface_.triangles()[triangle].vertices;
    return {tissue_at(v[0], k), tissue_at(v[1], k), tissue_at(v[2], k)};
  }

  /// A pair of a core and a triangle at one sample.
  struct Approach {
    int k = -1;
    Corners corners;
    Closest closest;
    Vec3 out = Vec3::Zero();
  };

  /// Conservative advancement over the samples: a pair cannot come near sooner than its distance over its speed. Inside
  /// the margin every sample is looked at, until the pair touches; one that only passes by is judged where it is
  /// closest, as its motion is along the surface there.
  void follow(const RoundedPiece& piece, std::uint32_t triangle) {
    double speed = path_;
    for (const VertexId v : surface_.triangles()[triangle].vertices)
      speed = std::max(speed, path_ + surface_.motion()[v.index()].norm());
    Approach best;
    const double near = piece.radius + options_.margin;
    for (int k = 0; k <= samples_;) {
      const Corners corners = triangle_at(triangle, k);
      bool behind = false;
      double excess = at_least_apart(cores_[k], piece.corner_count, corners, behind) - near;
      if (excess <= 0 && !behind) excess = look(piece, triangle, k, corners, best) - near;
      if (best.k >= 0 && best.closest.distance <= piece.radius) break;
      const double safe = speed > 0 ? std::max(0.0, excess) / speed * samples_ : double(samples_);
      k += std::max(1, static_cast<int>(std::min(safe, double(samples_ + 1))));
    }
    if (best.k >= 0) touch(piece, triangle, best);
  }

  /// A lower bound of how far the core is, quickly: to a sphere around the triangle, and to its plane. A core wholly
  /// behind the plane sees the triangle from inside the tissue: it must come through the plane first.
  [[nodiscard]] static double at_least_apart(const Corners& core, int count, const Corners& corners, bool& behind) {
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    double radius = 0;
    for (const Vec3& corner : corners) radius = std::max(radius, (corner - middle).squaredNorm());
    const double sphere = (weighted(core, closest_on_simplex(middle, core, count)) - middle).norm() - std::sqrt(radius);
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& corner : core) {
      const double height = normal.dot(corner - corners[0]);
      low = std::min(low, height);
      high = std::max(high, height);
    }
    behind = high < 0;
    return std::max(sphere, low);
  }

  /// Measures a pair and keeps it in `best` if it is the closest so far that counts. @return its distance
  double look(const RoundedPiece& piece, std::uint32_t triangle, int k, const Corners& corners, Approach& best) const {
    const Closest closest = closest_points(cores_[k], piece.corner_count, corners);
    Vec3 out;
    if (closest.distance <= piece.radius + options_.margin &&
        (best.k < 0 || closest.distance < best.closest.distance) && closest.distance > 1e-9 &&
        way_out(triangle, corners, closest.weights_b, closest.a - closest.b, k, out))
      best = {k, corners, closest, out};
    return closest.distance;
  }

  /// The closest pair, and what else spreads over the triangle.
  void touch(const RoundedPiece& piece, std::uint32_t triangle, const Approach& at) {
    const bool touches = at.closest.distance <= piece.radius * (1 + 1e-9);
    add(piece, triangle, at.closest.weights_a, at.closest.weights_b, at.out, at.k, touches);
    if (piece.corner_count == 1) return;
    const auto near = [&](const Vec3& weights_a, const Vec3& weights_b) {
      const Vec3 apart = weighted(cores_[at.k], weights_a) - weighted(at.corners, weights_b);
      Vec3 out;
      if (apart.norm() < piece.radius + options_.margin && apart.norm() > 1e-9 &&
          way_out(triangle, at.corners, weights_b, apart, at.k, out))
        add(piece, triangle, weights_a, weights_b, out, at.k, touches);
    };
    for (int c = 0; c < piece.corner_count; ++c)
      near(Vec3::Unit(c), closest_on_triangle(cores_[at.k][c], at.corners[0], at.corners[1], at.corners[2]));
    for (int c = 0; c < 3; ++c)
      near(closest_on_simplex(at.corners[c], cores_[at.k], piece.corner_count), Vec3::Unit(c));
  }

  /// The direction away from the tissue at a point of its surface, towards `apart`. On an edge or a vertex it is bent
  /// out of the neighbours' way, so that sliding over flat triangles doesn't catch on their edges.
  /// @return false where `apart` points into the tissue, or a neighbour is what is really closest
  [[nodiscard]] bool way_out(std::uint32_t triangle, const Corners& corners, const Vec3& weights, const Vec3& apart,
                             int k, Vec3& out) const {
    const ContactTriangle& own = surface_.triangles()[triangle];
    const Feature feature(own, weights);
    const Vec3 toward = apart.normalized();
    if (feature.count == 3) {
      out = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
      return out.dot(toward) > 0;
    }
    // Where the surface leads from here: the neighbours' corners; across the edge, if it is on one.
    const Vec3 at = weighted(corners, weights);
    const bool on_edge = feature.count == 2;
    const Vec3 edge = on_edge
                          ? Vec3((tissue_at(feature.vertices[1], k) - tissue_at(feature.vertices[0], k)).normalized())
                          : Vec3(Vec3::Zero());
    Vec3 facing = Vec3::Zero();
    ways_.clear();
    for (const std::uint32_t i : surface_.around(feature.vertices[0])) {
      const ContactTriangle& other = surface_.triangles()[i];
      if (!feature.within(other)) continue;
      const Corners c = triangle_at(i, k);
      facing += (c[1] - c[0]).cross(c[2] - c[0]).normalized();
      for (int j = 0; j < 3; ++j) {
        if (feature.has(other.vertices[j])) continue;
        const Vec3 way = c[j] - at;
        ways_.push_back((way - way.dot(edge) * edge).normalized());
      }
    }
    // Projections in turn onto the directions that climb none of these ways.
    out = toward - toward.dot(edge) * edge;
    double steepest = 1;
    for (int round = 0; round < 20 && steepest > 1e-3; ++round) {
      steepest = 0;
      for (const Vec3& way : ways_) {
        const double climb = out.dot(way);
        if (climb <= 0) continue;
        steepest = std::max(steepest, climb);
        out -= climb * way;
      }
    }
    const double length = out.norm();
    if (!(length > least_cosine)) return false;  // the projection's length is the cosine of the bend
    out /= length;
    return steepest < 0.02 && out.dot(facing) > 0;
  }

  /// A pair that only passes by moves no further than to where it is closest: beyond, the plane through that place
  /// would hold up a tool that is free to go.
  void add(const RoundedPiece& piece, std::uint32_t triangle, const Vec3& weights_core, const Vec3& weights,
           const Vec3& out, int k, bool touches) {
    const ContactTriangle& own = surface_.triangles()[triangle];
    Vec3 body = Vec3::Zero();
    for (int c = 0; c < piece.corner_count; ++c) body += weights_core(c) * piece.corners[c];
    body += poses_[k].rotation.conjugate() * (-piece.radius * out);
    Candidate candidate;
    TissueContact& contact = candidate.contact;
    contact.point = {own.vertices, weights, own.tet};
    contact.shape = number_;
    contact.normal = -out;
    contact.friction = moving_.friction;
    contact.place = moving_.from * body;
    contact.partner_motion = moving_.to * body - contact.place;
    const Vec3 until_closest = poses_[k] * body - contact.place;
    if (!touches && contact.normal.dot(until_closest) < contact.normal.dot(contact.partner_motion))
      contact.partner_motion = until_closest;
    Vec3 motion = Vec3::Zero();
    for (int c = 0; c < 3; ++c) {
      candidate.at += weights(c) * surface_.positions()[own.vertices[c].index()];
      motion += weights(c) * surface_.motion()[own.vertices[c].index()];
    }
    contact.gap = contact.normal.dot(candidate.at - contact.place);
    // Tissue that would run over the piece in this step meets it with its near side; the far side starts out beyond.
    if (k > 0 && contact.gap < -(piece.radius + options_.margin)) return;
    candidate.expected = contact.gap + contact.normal.dot(motion - contact.partner_motion);
    if (candidate.expected > options_.margin) return;
    const Feature feature(own, weights);
    std::uint64_t core = 0;  // which corners of the piece touch
    for (int c = 0; c < 3; ++c) core |= weights_core(c) > on_it ? std::uint64_t{1} << c : 0;
    const auto id = [&](int i) { return i < feature.count ? std::uint64_t{feature.vertices[i].value} : 0xffffffffu; };
    contact.key = key_of({1, number_, piece_, core, id(0), id(1), id(2)});
    found_.push_back(candidate);
  }

  /// Points of a core that are inside tissue at the step's start: out through the nearest surface.
  void find_inside(const RoundedPiece& piece) {
    const Corners& core = cores_[0];
    int between = 1;
    for (int c = 1; c < piece.corner_count; ++c)
      between = std::max(between, static_cast<int>(std::ceil((core[c] - core[c - 1]).norm() / (2 * piece.radius))));
    between = std::min(between, 8);
    for_each_sample(piece.corner_count, between, [&](const Vec3& weights) {
      const Vec3 p = weighted(core, weights);
      if (surface_.triangles().empty() || surface_.tree().whole().squared_distance(p) > 0) return;
      const ContactSurface::Nearest nearest = surface_.nearest(p);
      if (nearest.distance >= 0) return;
      const auto& v = surface_.triangles()[nearest.triangle].vertices;
      Vec3 s = Vec3::Zero();
      for (int c = 0; c < 3; ++c) s += nearest.weights(c) * surface_.positions()[v[c].index()];
      const double depth = (s - p).norm();
      const Vec3 out = depth > 1e-9 ? Vec3((s - p) / depth) : surface_.normals()[nearest.triangle];
      add(piece, nearest.triangle, weights, nearest.weights, out, 0, true);
    });
  }

  template <class Visit>
  static void for_each_sample(int corners, int between, const Visit& visit) {
    if (corners == 1) return visit(Vec3::UnitX());
    for (int i = 0; i <= between; ++i) {
      if (corners == 2) {
        const double x = double(i) / between;
        visit({1 - x, x, 0});
        continue;
      }
      for (int j = 0; i + j <= between; ++j) {
        const double x = double(i) / between, y = double(j) / between;
        visit({1 - x - y, x, y});
      }
    }
  }

  const ContactSurface& surface_;
  const MovingShape& moving_;
  std::uint32_t number_, piece_ = 0;
  const ContactOptions& options_;
  std::vector<Candidate>& found_;
  Screw screw_;
  std::vector<Pose> poses_;     // samples_ + 1, from start to end
  std::vector<Corners> cores_;  // the same, of the present piece
  int samples_ = 1;
  double longest_ = 0, path_ = 0;
  mutable std::vector<Vec3> ways_;  // kept for its memory
};

}  // namespace

void find_shape_contacts(const ContactSurface& surface, std::span<const MovingShape> shapes,
                         const ContactOptions& options, std::vector<Candidate>& found) {
  for (std::uint32_t s = 0; s < shapes.size(); ++s) ShapeContacts(surface, shapes[s], s, options, found).find();
}

}  // namespace calot::detail
