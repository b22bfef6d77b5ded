#include "calot/scene/shape_mesh.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/patient/structure.h"
#include "calot/scene/turn.h"

namespace calot {
namespace {

constexpr double most_tets = 1e6;

class ShapeMesher {
 public:
  void add(const BlockShape& block);
  void add(const TubeShape& tube);
  ShapeMesh take() { return std::move(out_); }

 private:
  std::int32_t region(const std::string& name);
  VertexId vertex(const Vec3& place, bool fixed);
  void tet(VertexId a, VertexId b, VertexId c, VertexId d, std::int32_t region, const std::string& where);
  void prism(const std::array<VertexId, 6>& corners, std::int32_t region, const std::string& where);
  std::vector<std::array<int, 3>> disc_triangles(int rings) const;
  void need_room(double tets, const std::string& where) const;

  ShapeMesh out_;
};

std::int32_t ShapeMesher::region(const std::string& name) {
  for (const auto& [number, known] : out_.mesh.region_names)
    if (known == name) return number;
  std::int32_t number = 100;
  if (const auto structure = structure_named(name)) number = label_of(*structure);
  while (out_.mesh.region_names.contains(number)) ++number;
  out_.mesh.region_names[number] = name;
  return number;
}

VertexId ShapeMesher::vertex(const Vec3& place, bool fixed) {
  out_.mesh.positions.push_back(place);
  out_.fixed.push_back(fixed ? 1 : 0);
  return VertexId(out_.mesh.positions.size() - 1);
}

void ShapeMesher::tet(VertexId a, VertexId b, VertexId c, VertexId d, std::int32_t region, const std::string& where) {
  const auto& p = out_.mesh.positions;
  const double longest = (p[a.index()] - p[b.index()]).norm() + (p[c.index()] - p[d.index()]).norm();
  if (!(signed_volume(p[a.index()], p[b.index()], p[c.index()], p[d.index()]) > 1e-6 * longest * longest * longest))
    throw InputError(where, "the shape folds onto itself, or is too flat",
                     "bend it less, give it more points, or finer elements");
  out_.mesh.tets.push_back({a, b, c, d});
  out_.mesh.regions.push_back(region);
}

// Three tets of the prism 012–345 (345 above). Each quad is cut from its corner of the smallest number, so that
// neighbours agree [Dompierre1999]: first turned so that the smallest of all is corner 0.
void ShapeMesher::prism(const std::array<VertexId, 6>& v, std::int32_t region, const std::string& where) {
  static constexpr std::array<std::array<std::size_t, 6>, 6> turned{{{0, 1, 2, 3, 4, 5},
                                                                     {1, 2, 0, 4, 5, 3},
                                                                     {2, 0, 1, 5, 3, 4},
                                                                     {3, 5, 4, 0, 2, 1},
                                                                     {4, 3, 5, 1, 0, 2},
                                                                     {5, 4, 3, 2, 1, 0}}};
  const auto smallest = static_cast<std::size_t>(std::min_element(v.begin(), v.end()) - v.begin());
  std::array<VertexId, 6> w;
  for (std::size_t i = 0; i < 6; ++i) w[i] = v[turned[smallest][i]];
  if (std::min(w[1], w[5]) < std::min(w[2], w[4])) {
    tet(w[0], w[1], w[2], w[5], region, where);
    tet(w[0], w[1], w[5], w[4], region, where);
  } else {
    tet(w[0], w[1], w[2], w[4], region, where);
    tet(w[0], w[4], w[2], w[5], region, where);
  }
  tet(w[0], w[4], w[5], w[3], region, where);
}

void ShapeMesher::need_room(double tets, const std::string& where) const {
  const double all = static_cast<double>(out_.mesh.tet_count()) + tets;
  if (!(all <= most_tets))
    throw InputError(where, "the shapes would have more than 1000000 tets", "give coarser elements");
}

void ShapeMesher::add(const BlockShape& block) {
  std::array<int, 3> n;
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = block.size[axis] / block.element_size;
    if (!(cells > 0 && cells < 1e4))
      throw InputError(block.where, "the block has no size", "give size and element_size");
    n[static_cast<std::size_t>(axis)] = std::max(1, static_cast<int>(std::lround(cells)));
  }
  need_room(6.0 * n[0] * n[1] * n[2], block.where);
  const std::int32_t number = region(block.region);
  const std::size_t first = out_.mesh.positions.size();
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        Vec3 share;
        bool fixed = false;
        for (std::size_t a = 0; a < 3; ++a) {
          share[static_cast<int>(a)] = static_cast<double>(at[a]) / n[a] - 0.5;
          fixed = fixed || (block.fixed[2 * a] && at[a] == 0) || (block.fixed[2 * a + 1] && at[a] == n[a]);
        }
        vertex(block.centre + share.cwiseProduct(block.size), fixed);
      }
  const auto id = [&](int i, int j, int k) {
    return VertexId(first + static_cast<std::size_t>(i + (n[0] + 1) * (j + (n[1] + 1) * k)));
  };
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        // Two prisms of each cube, with the same diagonal on both sides.
        const auto corner = [&](int x, int y, int z) { return id(i + x, j + y, k + z); };
        prism({corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1)},
              number, block.where);
        prism({corner(0, 0, 0), corner(1, 1, 0), corner(0, 1, 0), corner(0, 0, 1), corner(1, 1, 1), corner(0, 1, 1)},
              number, block.where);
      }
}

/// A disc of rings of 6, 12, 18 … points around its middle, point 0; ring r begins at 1 + 3 r (r − 1).
std::vector<std::array<int, 3>> ShapeMesher::disc_triangles(int rings) const {
  std::vector<std::array<int, 3>> triangles;
  const auto point = [](int ring, int place) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + place % (6 * ring); };
  for (int ring = 1; ring <= rings; ++ring)
    for (int side = 0; side < 6; ++side)
      for (int i = 0; i < ring; ++i) {
        const int inner = side * (ring - 1) + i, outer = side * ring + i;
        triangles.push_back({point(ring - 1, inner), point(ring, outer), point(ring, outer + 1)});
        if (i + 1 < ring)
          triangles.push_back({point(ring - 1, inner), point(ring, outer + 1), point(ring - 1, inner + 1)});
      }
  return triangles;
}

/// A cross-section of a tube: round as seen along its stretch, in a plane that turns towards the next stretch at a
/// bend, so that the volume of a bent tube is that of a straight one.
struct Section {
  Vec3 middle, along, axis;  // unit: the stretch's direction, the plane's normal
  double radius;
  std::size_t stretch;
};

std::vector<Section> sections_of(const TubeShape& tube) {
  std::vector<Section> sections;
  const std::size_t last = tube.points.size() - 1;
  const auto along = [&](std::size_t s) { return Vec3((tube.points[s + 1] - tube.points[s]).normalized()); };
  for (std::size_t s = 0; s < last; ++s) {
    const Vec3 way = tube.points[s + 1] - tube.points[s];
    const double mean = 0.5 * (tube.radii[s] + tube.radii[s + 1]);
    const int parts = std::max(1, static_cast<int>(std::lround(std::min(1e5, way.norm() * tube.rings / mean))));
    const Vec3 here = along(s), first = s > 0 ? Vec3((along(s - 1) + here).normalized()) : here,
               end = s + 1 < last ? Vec3((here + along(s + 1)).normalized()) : here;
    for (int i = s == 0 ? 0 : 1; i <= parts; ++i) {
      const double share = static_cast<double>(i) / parts;
      const Vec3 axis = i == 0 ? first : i == parts ? end : Vec3(((1 - share) * first + share * end).normalized());
      sections.push_back(
          {tube.points[s] + share * way, here, axis, (1 - share) * tube.radii[s] + share * tube.radii[s + 1], s});
    }
  }
  return sections;
}

void ShapeMesher::add(const TubeShape& tube) {
  const std::vector<Section> sections = sections_of(tube);
  need_room(18.0 * tube.rings * tube.rings * static_cast<double>(sections.size() - 1), tube.where);
  const auto triangles = disc_triangles(tube.rings);
  const auto each = static_cast<std::size_t>(1 + 3 * tube.rings * (tube.rings + 1));
  const std::size_t first = out_.mesh.positions.size();
  Vec3 across = sections[0].along.unitOrthogonal(), along = sections[0].along;
  for (std::size_t s = 0; s < sections.size(); ++s) {
    const Section& section = sections[s];
    across = (detail::shortest_turn(along, section.along) * across).normalized();
    along = section.along;
    const Vec3 other = along.cross(across);
    const double slant = along.dot(section.axis);
    const bool fixed = (s == 0 && tube.fixed_first) || (s + 1 == sections.size() && tube.fixed_last);
    vertex(section.middle, fixed);
    for (int ring = 1; ring <= tube.rings; ++ring)
      for (int i = 0; i < 6 * ring; ++i) {
        const double angle = 2 * M_PI * i / (6 * ring), radius = section.radius * ring / tube.rings;
        const Vec3 out = radius * (std::cos(angle) * across + std::sin(angle) * other);
        vertex(section.middle + out - out.dot(section.axis) / slant * along, fixed);
      }
  }
  for (std::size_t s = 0; s + 1 < sections.size(); ++s) {
    const std::int32_t number = region(tube.regions[sections[s + 1].stretch]);
    const auto id = [&](std::size_t section, int point) {
      return VertexId(first + section * each + static_cast<std::size_t>(point));
    };
    for (const auto& [a, b, c] : triangles)
      prism({id(s, a), id(s, b), id(s, c), id(s + 1, a), id(s + 1, b), id(s + 1, c)}, number, tube.where);
  }
}

}  // namespace

ShapeMesh mesh_of_shapes(const std::vector<BlockShape>& blocks, const std::vector<TubeShape>& tubes) {
  ShapeMesher mesher;
  for (const BlockShape& block : blocks) mesher.add(block);
  for (const TubeShape& tube : tubes) mesher.add(tube);
  return mesher.take();
}

}  // namespace calot
