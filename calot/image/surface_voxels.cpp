#include "calot/image/surface_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/image/text.h"

namespace calot {
namespace {

__extension__ using Wide = __int128;
/// Voxel coordinates in units of 2⁻¹⁶; below 2³¹ in size, so that products of three differences fit into 128 bits.
using Point = std::array<std::int64_t, 3>;
constexpr int fraction_bits = 16;
constexpr double largest_voxel = 32000;

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = Eigen::Vector3d::Constant(-INFINITY);
  void add(const Eigen::Vector3d& at) {
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  [[nodiscard]] std::string text() const {
    std::string text;
    for (int d = 0; d < 3; ++d)
      text += std::string(d ? ", " : "") + "xyz"[d] + " " + short_number(1e3 * low[d]) + " to " +
              short_number(1e3 * high[d]);
    return text + " mm";
  }
};

Box world_box(const VoxelGrid& grid) {
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d at;
    for (int d = 0; d < 3; ++d)
      at[d] = corner >> d & 1 ? static_cast<double>(grid.size[static_cast<std::size_t>(d)]) - 0.5 : -0.5;
    box.add(grid.to_world * at);
  }
  return box;
}

[[noreturn]] void outside(const Surface& surface, const VoxelGrid& grid, const std::string& where) {
  Box box;
  for (const Vec3& at : surface.positions) box.add(at);
  throw InputError(where, "lies outside the CT: " + box.text() + " against " + world_box(grid).text(),
                   "give it in the CT's coordinates (RAS), and name its unit");
}

/// The surface's vertices in voxels; checks that they are near the grid at all.
std::vector<Point> voxel_points(const Surface& surface, const VoxelGrid& grid, const std::string& where, bool& cut) {
  const Eigen::Affine3d to_voxels = grid.to_world.inverse();
  const Eigen::Vector3d size(static_cast<double>(grid.size[0]), static_cast<double>(grid.size[1]),
                             static_cast<double>(grid.size[2]));
  std::vector<Point> points;
  points.reserve(surface.positions.size());
  Box box;
  for (const Vec3& position : surface.positions) {
    const Eigen::Vector3d at = to_voxels * position;
    if (!(at.cwiseAbs().maxCoeff() < largest_voxel)) outside(surface, grid, where);
    box.add(at);
    points.push_back({std::llround(std::ldexp(at[0], fraction_bits)), std::llround(std::ldexp(at[1], fraction_bits)),
                      std::llround(std::ldexp(at[2], fraction_bits))});
  }
  if (points.empty() || (box.high.array() < -0.5).any() || (box.low.array() > size.array() - 0.5).any())
    outside(surface, grid, where);
  cut = (box.low.array() < -0.5).any() || (box.high.array() > size.array() - 0.5).any();
  return points;
}

/// Vertices at the same place are one, whatever the file says.
std::vector<std::uint32_t> weld(const std::vector<Point>& points) {
  std::vector<std::uint32_t> order(points.size()), same(points.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return points[a] != points[b] ? points[a] < points[b] : a < b; });
  for (std::size_t o = 0; o < order.size(); ++o)
    same[order[o]] = o > 0 && points[order[o]] == points[order[o - 1]] ? same[order[o - 1]] : order[o];
  return same;
}

void check_closed(const Surface& surface, const std::vector<Point>& points, const std::string& where) {
  const std::vector<std::uint32_t> same = weld(points);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = same[t[c]], b = same[t[(c + 1) % 3]];
      if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  std::sort(edges.begin(), edges.end());
  std::size_t odd = 0;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end] == edges[begin]) ++end;
    odd += (end - begin) % 2;
  }
  if (odd > 0)
    throw InputError(where, "isn't closed: " + count_of(odd, "edge") + " with an odd number of triangles",
                     "close its holes, or give a label map");
}

/// Whether an edge, seen along i, passes a point (j, k) on the side of larger j.
bool passes(const Point& p, const Point& q, std::int64_t j, std::int64_t k) {
  if ((p[2] > k) == (q[2] > k)) return false;
  const Point &a = p[2] > k ? q : p, &b = p[2] > k ? p : q;
  return Wide(b[1] - a[1]) * (k - a[2]) + Wide(a[1] - j) * (b[2] - a[2]) > 0;
}

/// The first whole number ≥ numerator / denominator.
Wide ceiling(Wide numerator, Wide denominator) {
  if (denominator < 0) {
    numerator = -numerator;
    denominator = -denominator;
  }
  const Wide quotient = numerator / denominator;
  return numerator > 0 && quotient * denominator != numerator ? quotient + 1 : quotient;
}

std::int64_t whole_at_least(std::int64_t fixed) {
  return static_cast<std::int64_t>(ceiling(fixed, Wide(1) << fraction_bits));
}

/// Marks, on every line through one triangle, the first voxel behind it.
class Crossings {
 public:
  Crossings(const VoxelGrid& grid, std::vector<std::uint8_t>& marks) : grid_(grid), marks_(marks) {}

  void add(const Point& a, const Point& b, const Point& c) {
    const auto [j_low, j_high] = lines(std::minmax({a[1], b[1], c[1]}), grid_.size[1]);
    const auto [k_low, k_high] = lines(std::minmax({a[2], b[2], c[2]}), grid_.size[2]);
    for (std::int64_t k = k_low; k < k_high; ++k)
      for (std::int64_t j = j_low; j < j_high; ++j) {
        const std::int64_t y = j << fraction_bits, z = k << fraction_bits;
        if (passes(a, b, y, z) ^ passes(b, c, y, z) ^ passes(c, a, y, z)) mark(a, b, c, j, k);
      }
  }

 private:
  static std::pair<std::int64_t, std::int64_t> lines(const std::pair<std::int64_t, std::int64_t>& extent,
                                                     std::size_t size) {
    return {std::max<std::int64_t>(0, whole_at_least(extent.first)),
            std::min(static_cast<std::int64_t>(size), whole_at_least(extent.second + 1))};
  }

  void mark(const Point& a, const Point& b, const Point& c, std::int64_t j, std::int64_t k) {
    const auto cross = [&](std::size_t d, std::size_t e) {
      return Wide(b[d] - a[d]) * (c[e] - a[e]) - Wide(b[e] - a[e]) * (c[d] - a[d]);
    };
    const Wide normal_x = cross(1, 2);  // not 0: a triangle seen edge-on has no inside
    const Wide rest = cross(2, 0) * ((j << fraction_bits) - a[1]) + cross(0, 1) * ((k << fraction_bits) - a[2]);
    const Wide i = ceiling(normal_x * a[0] - rest, normal_x * (Wide(1) << fraction_bits));
    if (i >= static_cast<Wide>(grid_.size[0])) return;
    marks_[grid_.index(i < 0 ? 0 : static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                       static_cast<std::size_t>(k))] ^= 1;
  }

  const VoxelGrid& grid_;
  std::vector<std::uint8_t>& marks_;
};

}  // namespace

SurfaceVoxels voxels_inside(const Surface& surface, const VoxelGrid& grid, const std::string& where) {
  SurfaceVoxels voxels;
  const std::vector<Point> points = voxel_points(surface, grid, where, voxels.cut);
  check_closed(surface, points, where);
  voxels.inside.resize(grid.count());
  Crossings crossings(grid, voxels.inside);
  for (const Triangle& t : surface.triangles) crossings.add(points[t[0]], points[t[1]], points[t[2]]);
  parallel_for(grid.size[2], [&](std::size_t k) {
    for (std::size_t j = 0; j < grid.size[1]; ++j) {
      std::uint8_t* const line = voxels.inside.data() + grid.index(0, j, k);
      for (std::size_t i = 1; i < grid.size[0]; ++i) line[i] ^= line[i - 1];
    }
  });
  return voxels;
}

}  // namespace calot
