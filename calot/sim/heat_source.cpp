#include "calot/sim/heat_source.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

constexpr int subdivisions = 4;
using Point = std::array<double, 4>;

/// Barycentric coordinates of evenly spread points inside a tet.
const std::vector<Point>& points_of_tet() {
  static const std::vector<Point> points = [] {
    std::vector<Point> all;
    const auto at = [](int i) { return (4 * i + 1) / (4.0 * subdivisions); };
    for (int i = 0; i < subdivisions; ++i)
      for (int j = 0; i + j < subdivisions; ++j)
        for (int k = 0; i + j + k < subdivisions; ++k)
          all.push_back({at(i), at(j), at(k), at(subdivisions - 1 - i - j - k)});
    return all;
  }();
  return points;
}

struct Corners {
  std::array<Vec3, 4> x;
  [[nodiscard]] Vec3 at(const Point& p) const { return p[0] * x[0] + p[1] * x[1] + p[2] * x[2] + p[3] * x[3]; }
  [[nodiscard]] double volume() const { return std::abs(signed_volume(x[0], x[1], x[2], x[3])); }
};

bool box_is_near(const Corners& c, const Vec3& place, double radius) {
  const Vec3 low = c.x[0].cwiseMin(c.x[1]).cwiseMin(c.x[2]).cwiseMin(c.x[3]);
  const Vec3 high = c.x[0].cwiseMax(c.x[1]).cwiseMax(c.x[2]).cwiseMax(c.x[3]);
  return ((low.array() - radius) <= place.array()).all() && ((high.array() + radius) >= place.array()).all();
}

/// Barycentric coordinates of `place`, pushed into the tet where it lies outside. Flat tets give their middle.
Point clamped(const Corners& c, const Vec3& place) {
  Eigen::Matrix3d edges;
  edges << c.x[1] - c.x[0], c.x[2] - c.x[0], c.x[3] - c.x[0];
  if (std::abs(edges.determinant()) < 1e-30) return {0.25, 0.25, 0.25, 0.25};
  const Vec3 b = edges.inverse() * (place - c.x[0]);
  Point p{1 - b.sum(), b[0], b[1], b[2]};
  double sum = 0;
  for (double& w : p) sum += w = std::max(w, 0.0);
  for (double& w : p) w /= sum;
  return p;
}

}  // namespace

void heated_tets(const TetMesh& mesh, std::span<const Vec3> positions, const Vec3& place, double radius,
                 std::span<const double> conductance, std::vector<HeatedTet>& out) {
  out.clear();
  double total = 0, nearest = radius;
  HeatedTet touched;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Corners corners;
    for (std::size_t c = 0; c < 4; ++c) corners.x[c] = positions[mesh.tets[t][c].index()];
    if (!box_is_near(corners, place, radius)) continue;
    HeatedTet heated{TetId(t), {}, (corners.at({0.25, 0.25, 0.25, 0.25}) - place).norm()};
    double power = 0;
    const double scale = corners.volume() * conductance[t];
    for (const Point& p : points_of_tet()) {
      const double density = scale * std::max(0.0, 1 - (corners.at(p) - place).squaredNorm() / (radius * radius));
      for (std::size_t c = 0; c < 4; ++c) heated.share[c] += density * p[c];
      power += density;
    }
    if (power > 0) out.push_back(heated);
    total += power;
    const Point p = clamped(corners, place);
    const double gap = (corners.at(p) - place).norm();
    if (gap < nearest || (gap <= nearest && !touched.tet.valid())) {
      nearest = gap;
      touched = {TetId(t), p, heated.distance};
    }
  }
  for (HeatedTet& heated : out)
    for (double& share : heated.share) share /= total;
  if (out.empty() && touched.tet.valid()) out.push_back(touched);
}

}  // namespace calot::detail
