#include "calot/sim/clip_section.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace calot {
namespace {

constexpr int rows = 3;      // across the clip's width
constexpr int columns = 17;  // along its legs

/// Where along y a line through (x, z) meets the triangle; nothing where it misses or only grazes.
std::optional<double> meets(double x, double z, const std::array<Vec3, 3>& c, Vec3& weights) {
  const auto twice_area = [](double ax, double az, double bx, double bz) { return ax * bz - az * bx; };
  const double all = twice_area(c[1].x() - c[0].x(), c[1].z() - c[0].z(), c[2].x() - c[0].x(), c[2].z() - c[0].z());
  if (all == 0) return std::nullopt;
  const double w0 = twice_area(c[1].x() - x, c[1].z() - z, c[2].x() - x, c[2].z() - z) / all;
  const double w1 = twice_area(c[2].x() - x, c[2].z() - z, c[0].x() - x, c[0].z() - z) / all;
  const double w2 = 1 - w0 - w1;
  if (w0 < 0 || w1 < 0 || w2 < 0) return std::nullopt;
  weights = {w0, w1, w2};
  return w0 * c[0].y() + w1 * c[1].y() + w2 * c[2].y();
}

struct Line {
  double x = 0, z = 0, reach = 0;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  SurfacePoint a, b;
};

std::vector<Line> lines_of(const ClipFigures& figures, double reach, double slope) {
  std::vector<Line> lines;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      Line line;
      // Off the middle by a little that is no round number: generated meshes have their edges there.
      line.x = figures.width * ((row + 0.5) / rows - 0.5 + 0.0137);
      line.z = figures.leg_length * ((column + 0.5) / columns - 0.5 + 0.0011);
      line.reach = reach + slope * line.z;
      lines.push_back(line);
    }
  return lines;
}

/// Range of the section of one tet with x = 0, grown by it; false where the plane misses the tet.
bool grow(ClipSection& section, double reach, double slope, const std::array<Vec3, 4>& c) {
  bool cuts = false;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = i + 1; k < 4; ++k) {
      if ((c[i].x() < 0) == (c[k].x() < 0)) continue;
      const double share = c[i].x() / (c[i].x() - c[k].x());
      const Vec3 p = c[i] + share * (c[k] - c[i]);
      section.low_z = std::min(section.low_z, p.z());
      section.high_z = std::max(section.high_z, p.z());
      section.low_y = std::min(section.low_y, p.y());
      section.high_y = std::max(section.high_y, p.y());
      section.beyond = std::max(section.beyond, std::abs(p.y()) - reach - slope * p.z());
      cuts = true;
    }
  return cuts;
}

class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t k) {
    i = root(i);
    k = root(k);
    parent_[std::max(i, k)] = std::min(i, k);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// The region's tets that the plane x = 0 of a frame cuts; two hang together where they share an edge that it cuts.
struct CutTets {
  std::vector<TetId> tets;  // ascending
  std::vector<std::array<Vec3, 4>> corners;
  Groups groups{0};
};

CutTets cut_tets(const Pose& frame, std::int32_t region, const TetMesh& mesh, std::span<const Vec3> positions) {
  CutTets cut;
  const Pose to_frame = frame.inverse();
  const Vec3 across = frame.rotation * Vec3::UnitX();
  const auto height = [&](VertexId v) { return across.dot(positions[v.index()] - frame.position); };
  std::vector<std::pair<std::uint64_t, std::size_t>> edges;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (mesh.regions[t] != region) continue;
    const Tet& tet = mesh.tets[t];
    std::array<bool, 4> below{};
    for (std::size_t i = 0; i < 4; ++i) below[i] = height(tet[i]) < 0;
    if (below[0] == below[1] && below[0] == below[2] && below[0] == below[3]) continue;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = i + 1; k < 4; ++k)
        if (below[i] != below[k]) {
          const auto [low, high] = std::minmax(tet[i].value, tet[k].value);
          edges.emplace_back((std::uint64_t{low} << 32U) | high, cut.tets.size());
        }
    cut.tets.emplace_back(t);
    cut.corners.push_back({to_frame * positions[tet[0].index()], to_frame * positions[tet[1].index()],
                           to_frame * positions[tet[2].index()], to_frame * positions[tet[3].index()]});
  }
  std::sort(edges.begin(), edges.end());
  cut.groups = Groups(cut.tets.size());
  for (std::size_t e = 1; e < edges.size(); ++e)
    if (edges[e].first == edges[e - 1].first) cut.groups.join(edges[e].second, edges[e - 1].second);
  return cut;
}

}  // namespace

Vec3 place_of(const SurfacePoint& point, std::span<const Vec3> positions) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) sum += point.weights[k] * positions[point.vertices[static_cast<std::size_t>(k)].index()];
  return sum;
}

std::vector<ClipStation> clip_stations(const ClipFigures& figures, const Pose& frame, double reach, double reach_slope,
                                       const TissueSurface& surface) {
  std::vector<Line> lines = lines_of(figures, reach, reach_slope);
  const Pose to_frame = frame.inverse();
  const double around =
      figures.width + figures.leg_length / 2 + std::abs(reach) + std::abs(reach_slope) * figures.leg_length / 2;
  for (const auto& triangle : surface.triangles) {
    const Vec3 &a = surface.positions[triangle[0].index()], &b = surface.positions[triangle[1].index()],
               &c = surface.positions[triangle[2].index()];
    bool misses = false;
    for (int axis = 0; axis < 3; ++axis)
      misses |= std::min({a[axis], b[axis], c[axis]}) > frame.position[axis] + around ||
                std::max({a[axis], b[axis], c[axis]}) < frame.position[axis] - around;
    if (misses) continue;
    const std::array<Vec3, 3> corners{to_frame * a, to_frame * b, to_frame * c};
    for (Line& line : lines) {
      Vec3 weights = Vec3::Zero();
      const std::optional<double> y = meets(line.x, line.z, corners, weights);
      if (!y || std::abs(*y) > line.reach) continue;
      if (*y < line.low) {
        line.low = *y;
        line.a = {triangle, weights, TetId::none()};
      }
      if (*y > line.high) {
        line.high = *y;
        line.b = {triangle, weights, TetId::none()};
      }
    }
  }
  std::vector<ClipStation> stations;
  for (const Line& line : lines)
    if (line.high > line.low)
      stations.push_back({line.a, line.b, figures.width * figures.leg_length / (rows * columns), line.high - line.low});
  return stations;
}

ClipSection clip_section(const Pose& frame, double reach, double reach_slope, std::span<const TetId> seeds,
                         std::int32_t region, const TetMesh& mesh, std::span<const Vec3> positions) {
  constexpr double far = std::numeric_limits<double>::infinity();
  ClipSection section{far, -far, far, -far, -far, 0};
  CutTets cut = cut_tets(frame, region, mesh, positions);
  std::vector<bool> taken(cut.tets.size(), false);  // by root
  for (std::size_t i = 0; i < cut.tets.size(); ++i)
    if (std::binary_search(seeds.begin(), seeds.end(), cut.tets[i])) taken[cut.groups.root(i)] = true;
  for (std::size_t i = 0; i < cut.tets.size(); ++i)
    if (taken[cut.groups.root(i)] && grow(section, reach, reach_slope, cut.corners[i])) ++section.tets;
  return section;
}

std::vector<TetId> clip_tets(const ClipFigures& figures, const Pose& frame, double reach, double reach_slope,
                             const TetMesh& mesh, std::span<const Vec3> positions) {
  std::vector<TetId> tets;
  const Pose to_frame = frame.inverse();
  const double half = figures.leg_length / 2, around = half + figures.width + reach + std::abs(reach_slope) * half;
  const Vec3 low = frame.position.array() - around, high = frame.position.array() + around;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Vec3 least = positions[mesh.tets[t][0].index()], most = least;
    for (const VertexId v : mesh.tets[t]) {
      least = least.cwiseMin(positions[v.index()]);
      most = most.cwiseMax(positions[v.index()]);
    }
    if ((least.array() > high.array()).any() || (most.array() < low.array()).any()) continue;
    least.setConstant(std::numeric_limits<double>::infinity());
    most = -least;
    for (const VertexId v : mesh.tets[t]) {
      const Vec3 p = to_frame * positions[v.index()];
      least = least.cwiseMin(p);
      most = most.cwiseMax(p);
    }
    const double open = reach + reach_slope * std::clamp((least.z() + most.z()) / 2, -half, half);
    const bool inside = least.x() <= figures.width / 2 && most.x() >= -figures.width / 2 && least.z() <= half &&
                        most.z() >= -half && least.y() <= open && most.y() >= -open;
    if (inside) tets.emplace_back(t);
  }
  return tets;
}

}  // namespace calot
