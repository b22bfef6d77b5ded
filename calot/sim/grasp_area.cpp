#include "calot/sim/grasp_area.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace calot {
namespace {

/// A point of a triangle, in the instrument's frame, with x measured from the jaws' middle line.
struct Corner {
  Vec3 place, weights;
};

/// A convex piece of a triangle: up to 3 corners and one more for each of the planes that clip it.
struct Piece {
  std::array<Corner, 12> corners;
  int count = 0;
};

/// Keeps what has normal · x ≥ offset.
Piece clipped(const Piece& piece, const Vec3& normal, double offset) {
  Piece kept;
  for (int i = 0; i < piece.count; ++i) {
    const Corner &a = piece.corners[static_cast<std::size_t>(i)],
                 &b = piece.corners[static_cast<std::size_t>((i + 1) % piece.count)];
    const double from = normal.dot(a.place) - offset, to = normal.dot(b.place) - offset;
    if (from >= 0) kept.corners[static_cast<std::size_t>(kept.count++)] = a;
    if ((from >= 0) == (to >= 0)) continue;
    const double share = from / (from - to);
    kept.corners[static_cast<std::size_t>(kept.count++)] = {a.place + share * (b.place - a.place),
                                                            a.weights + share * (b.weights - a.weights)};
  }
  return kept;
}

/// Area as seen along y [m²], and where its middle is on the triangle. A surface that is seen edge-on still counts a
/// little: jaws pinch what lies across their mouth, too.
double seen_area(const Piece& piece, Vec3& weights) {
  constexpr double edge_on = 0.1;
  double area = 0;
  weights.setZero();
  for (int i = 1; i + 1 < piece.count; ++i) {
    const Corner &a = piece.corners[0], &b = piece.corners[static_cast<std::size_t>(i)],
                 &c = piece.corners[static_cast<std::size_t>(i + 1)];
    const Vec3 normal = (b.place - a.place).cross(c.place - a.place) / 2;
    const double part = std::abs(normal.y()) + edge_on * normal.norm();
    area += part;
    weights += part * (a.weights + b.weights + c.weights) / 3;
  }
  if (area > 0) weights /= area;
  return area;
}

/// Angle from the mouth's middle towards jaw a.
double angle_of(const Vec3& place) {
  return std::atan2(-place.y(), place.z());
}

class Mouth {
 public:
  Mouth(const InstrumentGeometry& geometry, const MouthSearch& search) : geometry_(geometry), search_(search) {
    to_frame_ = search.pose.inverse();
    const double half = search.opening / 2, length = geometry.jaw_length;
    normal_a_ = {0, std::cos(half), std::sin(half)};
    normal_b_ = {0, -std::cos(half), std::sin(half)};
    const double across =
        std::max(geometry.jaw_width, geometry.tip_width) / 2 + search.side_margin + std::abs(geometry.middle(length));
    const double high = length * std::sin(half) + search.face_margin;
    const Vec3 low_corner(-across, -high, 0), high_corner(across, high, length);
    low_ = high_ = search.pose * low_corner;
    for (int k = 1; k < 8; ++k) {
      const Vec3 corner = search.pose * Vec3(((k & 1) != 0 ? high_corner : low_corner).x(),
                                             ((k & 2) != 0 ? high_corner : low_corner).y(),
                                             ((k & 4) != 0 ? high_corner : low_corner).z());
      low_ = low_.cwiseMin(corner);
      high_ = high_.cwiseMax(corner);
    }
  }

  /// The triangle's piece in the mouth; none of no corner.
  [[nodiscard]] Piece piece_of(const std::array<VertexId, 3>& triangle, std::span<const Vec3> positions) const {
    Piece piece;
    const Vec3 &a = positions[triangle[0].index()], &b = positions[triangle[1].index()],
               &c = positions[triangle[2].index()];
    for (int axis = 0; axis < 3; ++axis)
      if (std::min({a[axis], b[axis], c[axis]}) > high_[axis] || std::max({a[axis], b[axis], c[axis]}) < low_[axis])
        return piece;
    piece.count = 3;
    piece.corners[0] = {to_frame_ * a, Vec3::UnitX()};
    piece.corners[1] = {to_frame_ * b, Vec3::UnitY()};
    piece.corners[2] = {to_frame_ * c, Vec3::UnitZ()};
    for (std::size_t i = 0; i < 3; ++i) piece.corners[i].place.x() -= geometry_.middle(piece.corners[i].place.z());
    const double start = geometry_.face_start * std::cos(search_.opening / 2);
    piece = within_sides(piece, search_.side_margin);
    piece = clipped(piece, Vec3::UnitZ(), start);
    piece = clipped(piece, -Vec3::UnitZ(), -geometry_.jaw_length);
    piece = clipped(piece, normal_a_, -search_.face_margin);
    return clipped(piece, normal_b_, -search_.face_margin);
  }

  /// Smallest distance from a jaw's inner face, signed.
  [[nodiscard]] double gap(const Piece& piece, JawSide side) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < piece.count; ++i)
      least = std::min(
          least, (side == JawSide::a ? normal_a_ : normal_b_).dot(piece.corners[static_cast<std::size_t>(i)].place));
    return least;
  }

  /// What of a piece is within the jaws' outline, without margin.
  [[nodiscard]] Piece under_faces(const Piece& piece) const {
    return search_.side_margin > 0 ? within_sides(piece, 0) : piece;
  }

 private:
  [[nodiscard]] Piece within_sides(Piece piece, double margin) const {
    const double taper =
        (geometry_.tip_width - geometry_.jaw_width) / 2 / (geometry_.jaw_length - geometry_.face_start);
    const double half_width = geometry_.jaw_width / 2 - taper * geometry_.face_start + margin;
    for (const double sign : {1.0, -1.0}) piece = clipped(piece, {sign, 0, taper}, -half_width);
    return piece;
  }

  const InstrumentGeometry& geometry_;
  const MouthSearch& search_;
  Pose to_frame_;
  Vec3 normal_a_, normal_b_;  // of the inner faces, into the mouth
  Vec3 low_, high_;           // box around the mouth in the world
};

/// One half of a piece, as seen by the jaw on that side.
void add_half(const Mouth& mouth, const Piece& half, JawSide side, const std::array<VertexId, 3>& triangle,
              double limit_angle, double reach, std::vector<JawShare>& shares) {
  Vec3 weights, unused;
  const double loose = seen_area(half, weights);
  if (loose <= 0) return;
  const Piece under = mouth.under_faces(half);
  Vec3 under_weights;
  const double area = seen_area(under, under_weights);
  if (area > 0) weights = under_weights;
  // What is near the face: beyond a plane at `reach` from the place furthest towards the jaw.
  const double sign = side == JawSide::a ? 1 : -1;
  const Vec3 towards_jaw(0, -sign * std::cos(limit_angle), -std::sin(limit_angle));
  const double near = seen_area(clipped(under, towards_jaw, -reach), unused);
  const double gap = mouth.gap(area > 0 ? under : half, side);
  for (std::size_t k = 0; k < 3; ++k)
    if (const double w = weights[static_cast<int>(k)]; w > 0)
      shares.push_back({triangle[k], side, w * area, w * near, gap});
}

void merge(std::vector<JawShare>& shares) {
  std::stable_sort(shares.begin(), shares.end(), [](const JawShare& x, const JawShare& y) {
    return x.vertex != y.vertex ? x.vertex < y.vertex : x.side < y.side;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (kept > 0 && shares[kept - 1].vertex == shares[i].vertex && shares[kept - 1].side == shares[i].side) {
      shares[kept - 1].area += shares[i].area;
      shares[kept - 1].near += shares[i].near;
      shares[kept - 1].gap = std::min(shares[kept - 1].gap, shares[i].gap);
    } else {
      shares[kept++] = shares[i];
    }
  }
  shares.resize(kept);
}

}  // namespace

void look_into_mouth(const InstrumentGeometry& geometry, const MouthSearch& search, const TissueSurface& surface,
                     MouthContents& contents) {
  contents.shares.clear();
  contents.extent_a = contents.extent_b = -std::numeric_limits<double>::infinity();
  const Mouth mouth(geometry, search);
  // First how far the tissue reaches, then what of it is near a face.
  contents.inside.clear();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Piece piece = mouth.piece_of(surface.triangles[t], surface.positions);
    if (piece.count >= 3) contents.inside.push_back(static_cast<std::uint32_t>(t));
    for (int i = 0; i < piece.count; ++i) {
      const double angle = angle_of(piece.corners[static_cast<std::size_t>(i)].place);
      contents.extent_a = std::max(contents.extent_a, angle);
      contents.extent_b = std::max(contents.extent_b, -angle);
    }
  }
  if (!std::isfinite(contents.extent_a)) return;
  const double half = search.opening / 2, middle = (contents.extent_a - contents.extent_b) / 2;
  const Vec3 middle_normal(0, std::cos(middle), std::sin(middle));
  for (const std::uint32_t t : contents.inside) {
    const auto& triangle = surface.triangles[t];
    const Piece piece = mouth.piece_of(triangle, surface.positions);
    add_half(mouth, clipped(piece, -middle_normal, 0), JawSide::a, triangle, std::min(half, contents.extent_a),
             search.reach, contents.shares);
    add_half(mouth, clipped(piece, middle_normal, 0), JawSide::b, triangle, std::min(half, contents.extent_b),
             search.reach, contents.shares);
  }
  merge(contents.shares);
}

}  // namespace calot
