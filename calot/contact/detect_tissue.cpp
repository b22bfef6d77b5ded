// Tissue against itself and against still surfaces: pairs of triangles that look at each other.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/contact/box_tree.h"
#include "calot/contact/detect_parts.h"
#include "calot/contact/simplex_distance.h"

namespace calot::detail {
namespace {

constexpr double opposed = -0.3;      // dot product of normals that look at each other
constexpr double sideways = 0.6;      // a pair of points may lie off the normal by this share of its gap
constexpr double rest_reach = 10e-3;  // triangles closer than this in the rest shape may be two sides of one wall [m]

/// One side of a pair of triangles, as tissue or as something still.
struct Side {
  Corners corners, motion;
  Vec3 normal;
  std::array<std::uint32_t, 3> ids;
};

Side tissue_side(const ContactSurface& surface, std::uint32_t i) {
  Side side;
  for (int c = 0; c < 3; ++c) {
    const VertexId v = surface.triangles()[i].vertices[c];
    side.corners[c] = surface.positions()[v.index()];
    side.motion[c] = surface.motion()[v.index()];
    side.ids[c] = v.value;
  }
  side.normal = surface.normals()[i];
  return side;
}

std::uint64_t edge_name(const Side& side, int e) {
  const std::uint64_t x = side.ids[e], y = side.ids[(e + 1) % 3];
  return std::min(x, y) << 32 | std::max(x, y);
}

/// Two triangles across from each other.
class Meeting {
 public:
  Meeting(const Side& a, const Side& b, double deepest, double margin)
      : a_(a), b_(b), deepest_(deepest), margin_(margin), between_((b.normal - a.normal).normalized()) {
    double motion = 0;
    for (int c = 0; c < 3; ++c) motion = std::max({motion, a.motion[c].squaredNorm(), b.motion[c].squaredNorm()});
    motion = std::sqrt(motion);
    // A gap's sign and, but for a slant, its size are those of the distance from the other's plane.
    const double slant = std::sqrt(1 + sideways * sideways);
    highest_ = slant * (margin + 2 * motion) + 1e-6;
    lowest_ = -slant * deepest - 1e-6;
  }

  /// Calls visit(weights of a, weights of b, normal from b to a, gap, expected gap, name of the features).
  template <class Visit>
  void each(const Visit& visit) const {
    Vec3 from_b, from_a;  // of the corners of one from the plane of the other
    for (int c = 0; c < 3; ++c) {
      from_b(c) = b_.normal.dot(a_.corners[c] - b_.corners[0]);
      from_a(c) = a_.normal.dot(b_.corners[c] - a_.corners[0]);
    }
    if (from_b.minCoeff() > highest_ || from_b.maxCoeff() < lowest_ || from_a.minCoeff() > highest_ ||
        from_a.maxCoeff() < lowest_)
      return;
    bool met = false;
    for (int c = 0; c < 3; ++c) {
      if (from_b(c) > lowest_ && from_b(c) < highest_) {
        const Vec3 on_b = closest_on_triangle(a_.corners[c], b_.corners[0], b_.corners[1], b_.corners[2]);
        met |= offer(Vec3::Unit(c), on_b, is_inside(on_b) ? b_.normal : between_, a_.ids[c], visit);
      }
      if (from_a(c) > lowest_ && from_a(c) < highest_) {
        const Vec3 on_a = closest_on_triangle(b_.corners[c], a_.corners[0], a_.corners[1], a_.corners[2]);
        met |= offer(on_a, Vec3::Unit(c), is_inside(on_a) ? Vec3(-a_.normal) : between_, b_.ids[c], visit);
      }
    }
    // Edges that cross matter where no corner lies over the other triangle, as between two thin ducts.
    for (int e = 0; e < 3 && !met; ++e)
      for (int f = 0; f < 3; ++f) edges(e, f, visit);
  }

 private:
  static bool is_inside(const Vec3& weights) { return weights.minCoeff() > 1e-6; }

  template <class Visit>
  void edges(int e, int f, const Visit& visit) const {
    const Vec3 &p0 = a_.corners[e], &p1 = a_.corners[(e + 1) % 3], &q0 = b_.corners[f], &q1 = b_.corners[(f + 1) % 3];
    const auto [s, t] = closest_on_segments(p0, p1, q0, q1);
    if (std::min(s, t) < 1e-3 || std::max(s, t) > 1 - 1e-3) return;  // a corner: seen to above
    const Vec3 u = (p1 - p0).normalized(), v = (q1 - q0).normalized();
    Vec3 normal = u.cross(v);
    const double sine = normal.norm();
    if (sine < 0.1) return;
    normal *= (normal.dot(between_) < 0 ? -1 : 1) / sine;
    if (normal.dot(between_) < 0.7) return;
    Vec3 weights_a = Vec3::Zero(), weights_b = Vec3::Zero();
    weights_a(e) = 1 - s;
    weights_a((e + 1) % 3) = s;
    weights_b(f) = 1 - t;
    weights_b((f + 1) % 3) = t;
    offer(weights_a, weights_b, normal, key_of({edge_name(a_, e), edge_name(b_, f)}), visit);
  }

  template <class Visit>
  bool offer(const Vec3& weights_a, const Vec3& weights_b, const Vec3& normal, std::uint64_t name,
             const Visit& visit) const {
    const Vec3 apart = weighted(a_.corners, weights_a) - weighted(b_.corners, weights_b);
    const double gap = normal.dot(apart);
    if (gap < -deepest_ || (apart - gap * normal).norm() > sideways * std::abs(gap) + 1e-6) return false;
    const double expected = gap + normal.dot(weighted(a_.motion, weights_a) - weighted(b_.motion, weights_b));
    if (expected > margin_) return false;
    visit(weights_a, weights_b, normal, gap, expected, name);
    return true;
  }

  const Side &a_, &b_;
  double deepest_, margin_, highest_ = 0, lowest_ = 0;
  Vec3 between_;
};

/// How two triangles lie to each other in the rest shape.
enum class AtRest : std::uint8_t {
  apart,
  close,         // as cut faces are, or organs that lie against each other
  back_to_back,  // two sides of one wall
};
AtRest at_rest(const ContactSurface& surface, std::uint32_t i, std::uint32_t j) {
  const ContactSurface::RestFace &a = surface.rest_faces()[i], &b = surface.rest_faces()[j];
  const Vec3 apart = a.middle - b.middle;
  const double distance = apart.norm();
  if (distance > rest_reach) return AtRest::apart;
  if (a.normal.dot(b.normal) < 0 && (b.normal - a.normal).normalized().dot(apart) < -0.3 * distance)
    return AtRest::back_to_back;
  return AtRest::close;
}

/// Faces that were close to each other may seem to have passed through each other: those round a bend when they are
/// squeezed, those of a rough cut when they shear. What really meets there begins with a gap and is held from then on.
constexpr double deepest_where_close = 0.5e-3;

/// Two sides of a crease: they look at each other in the rest shape, and an edge of the surface leads from one to the
/// other. The tissue they join in keeps them apart; as contacts they would only push the crease open.
bool in_a_crease(const ContactSurface& surface, std::uint32_t i, std::uint32_t j) {
  if (surface.rest_faces()[i].normal.dot(surface.rest_faces()[j].normal) >= opposed) return false;
  const auto& ours = surface.triangles()[j].vertices;
  for (const VertexId v : surface.triangles()[i].vertices)
    for (const std::uint32_t k : surface.around(v))
      for (const VertexId w : surface.triangles()[k].vertices)
        if (std::find(ours.begin(), ours.end(), w) != ours.end()) return true;
  return false;
}

bool share_a_vertex(const Side& a, const Side& b) {
  return std::any_of(a.ids.begin(), a.ids.end(),
                     [&](std::uint32_t v) { return std::find(b.ids.begin(), b.ids.end(), v) != b.ids.end(); });
}

Side still_side(const StillSurface& still, std::uint32_t i) {
  Side side;
  for (int c = 0; c < 3; ++c) {
    side.ids[c] = still.surface().triangles[i][c];
    side.corners[c] = still.surface().positions[side.ids[c]];
    side.motion[c].setZero();
    side.ids[c] |= 0x80000000u;  // no tissue vertex has that number
  }
  side.normal = still.normals()[i];
  return side;
}

}  // namespace

void find_self_contacts(const ContactSurface& surface, const ContactOptions& options, std::vector<Candidate>& found) {
  BoxTree::pairs(surface.tree(), surface.tree(), opposed, [&](std::uint32_t i, std::uint32_t j) {
    if (surface.normals()[i].dot(surface.normals()[j]) >= opposed) return;
    if (i > j) std::swap(i, j);
    const AtRest rest = at_rest(surface, i, j);
    if (rest == AtRest::back_to_back) return;
    const Side a = tissue_side(surface, i), b = tissue_side(surface, j);
    if (share_a_vertex(a, b) || in_a_crease(surface, i, j)) return;
    const ContactTriangle &triangle = surface.triangles()[i], &other = surface.triangles()[j];
    const double deepest =
        rest == AtRest::close ? std::min(deepest_where_close, options.deepest_overlap) : options.deepest_overlap;
    Meeting(a, b, deepest, options.margin)
        .each([&](const Vec3& weights_a, const Vec3& weights_b, const Vec3& normal, double gap, double expected,
                  std::uint64_t name) {
          Candidate candidate;
          TissueContact& contact = candidate.contact;
          contact.partner = ContactPartner::tissue;
          contact.point = {triangle.vertices, weights_a, triangle.tet};
          contact.other = {other.vertices, weights_b, other.tet};
          contact.place = weighted(b.corners, weights_b);
          contact.normal = normal;
          contact.gap = gap;
          contact.friction = options.tissue_friction;
          contact.key = key_of({3, name});
          candidate.expected = expected;
          candidate.at = weighted(a.corners, weights_a);
          found.push_back(candidate);
        });
  });
}

void find_still_contacts(const ContactSurface& surface, std::span<const StillSurface> still,
                         const ContactOptions& options, std::vector<Candidate>& found) {
  constexpr double deepest_in_a_sheet = 0.5e-3;  // beyond it, the far side of thin tissue would seem to be inside
  for (std::uint32_t s = 0; s < still.size(); ++s) {
    const bool sheet = still[s].two_sided();
    BoxTree::pairs(surface.tree(), still[s].tree(), opposed, [&](std::uint32_t i, std::uint32_t j) {
      const Side a = tissue_side(surface, i);
      Side b = still_side(still[s], j);
      if (sheet && a.normal.dot(b.normal) > 0) b.normal = -b.normal;
      if (a.normal.dot(b.normal) >= opposed) return;
      const ContactTriangle& triangle = surface.triangles()[i];
      Meeting(a, b, sheet ? std::min(deepest_in_a_sheet, options.deepest_overlap) : options.deepest_overlap,
              options.margin)
          .each([&](const Vec3& weights_a, const Vec3& weights_b, const Vec3& normal, double gap, double expected,
                    std::uint64_t name) {
            Candidate candidate;
            TissueContact& contact = candidate.contact;
            contact.partner = ContactPartner::still;
            contact.shape = s;
            contact.point = {triangle.vertices, weights_a, triangle.tet};
            contact.place = weighted(b.corners, weights_b);
            contact.normal = normal;
            contact.gap = gap;
            contact.friction = still[s].friction();
            contact.key = key_of({2, s, name});
            candidate.expected = expected;
            candidate.at = weighted(a.corners, weights_a);
            found.push_back(candidate);
          });
    });
  }
}

}  // namespace calot::detail
