#include "calot/patient/phantom_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calot/base/parallel.h"

namespace calot {
namespace {

/// Lattice cell and share along one axis.
struct Between {
  std::size_t low;
  float share;
};

Between between(double coordinate, std::size_t count) {
  const double inside = std::clamp(coordinate, 0.0, static_cast<double>(count - 1));
  const std::size_t low = std::min(static_cast<std::size_t>(inside), count - 2);
  return {low, static_cast<float>(inside - static_cast<double>(low))};
}

}  // namespace

double smooth_min(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - h * h * blend / 4;
}

double smooth_max(double a, double b, double blend) {
  return -smooth_min(-a, -b, blend);
}

double Superellipsoid::distance(const Vec3& p) const {
  const Vec3 x = (p - centre).cwiseAbs().cwiseQuotient(radii);
  const double largest = x.maxCoeff();
  if (largest < 1e-6) return -radii.minCoeff();
  if (power == 2) {
    const double norm = x.norm();
    return (norm - 1) * norm / x.cwiseQuotient(radii).norm();
  }
  Vec3 lower;  // scaled, so that no power overflows
  for (int d = 0; d < 3; ++d) lower[d] = std::pow(x[d] / largest, power - 1);
  const double sum = lower.dot(x) / largest;
  const double norm = largest * std::pow(sum, 1 / power);
  const double slope = std::pow(sum, 1 / power - 1) * lower.cwiseQuotient(radii).norm();
  return (norm - 1) / slope;
}

double distance_to_triangle(const Vec3& p, const std::array<Vec3, 3>& corners) {
  const Vec3 u = corners[1] - corners[0], v = corners[2] - corners[0], w = p - corners[0];
  const Vec3 normal = u.cross(v);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const double b = w.cross(v).dot(normal) / area, c = u.cross(w).dot(normal) / area;
    if (b >= 0 && c >= 0 && b + c <= 1) return std::abs(w.dot(normal)) / std::sqrt(area);
  }
  return distance_to({corners[0], corners[1], corners[2], corners[0]}, p);
}

double distance_to(const BallChain& balls, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls) nearest = std::min(nearest, (p - ball.centre).norm() - ball.radius);
  return nearest;
}

double distance_to_tube(const Curve& curve, double radius, const Vec3& p) {
  return distance_to(curve, p) - radius;
}

Window window_of(const VoxelGrid& grid, std::size_t k, const Eigen::AlignedBox3d& box) {
  const Vec3 origin = grid.to_world.translation(), spacing = grid.spacing();
  const double z = origin[2] + static_cast<double>(k) * spacing[2];
  Window window;
  if (z < box.min()[2] || z > box.max()[2]) return window;
  for (std::size_t d = 0; d < 2; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    const double low = std::ceil((box.min()[axis] - origin[axis]) / spacing[axis]);
    const double high = std::floor((box.max()[axis] - origin[axis]) / spacing[axis]) + 1;
    const auto limit = static_cast<double>(grid.size[d]);
    window.first[d] = static_cast<std::size_t>(std::clamp(low, 0.0, limit));
    window.last[d] = static_cast<std::size_t>(std::clamp(high, 0.0, limit));
  }
  return window;
}

VoxelGrid grid_of(const VoxelGrid& grid, const Window& window) {
  VoxelGrid part = grid;
  Vec3 shift = Vec3::Zero();
  for (std::size_t d = 0; d < 2; ++d) {
    part.size[d] = window.last[d] - window.first[d];
    shift[static_cast<Eigen::Index>(d)] = static_cast<double>(window.first[d]);
  }
  part.to_world.translation() += grid.to_world.linear() * shift;
  return part;
}

SampledField::SampledField(const Eigen::AlignedBox3d& box, double step, const std::function<double(const Vec3&)>& f)
    : step_(step) {
  for (std::size_t d = 0; d < 3; ++d)
    size_[d] = static_cast<std::size_t>(std::ceil(box.sizes()[static_cast<Eigen::Index>(d)] / step)) + 2;
  box_ = Eigen::AlignedBox3d(box.min(), box.min());
  box_.extend(Vec3(place(size_[0] - 1, size_[1] - 1, size_[2] - 1)));
  values_.resize(size_[0] * size_[1] * size_[2]);
  parallel_for(size_[2], [&](std::size_t k) {
    std::size_t v = k * size_[0] * size_[1];
    for (std::size_t j = 0; j < size_[1]; ++j)
      for (std::size_t i = 0; i < size_[0]; ++i) values_[v++] = static_cast<float>(f(place(i, j, k)));
  });
}

double SampledField::at(const Vec3& p) const {
  const Vec3 c = (p - box_.min()) / step_;
  const Between x = between(c[0], size_[0]), y = between(c[1], size_[1]), z = between(c[2], size_[2]);
  float sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t a = corner & 1, b = corner >> 1 & 1, e = corner >> 2;
    sum += (a ? x.share : 1 - x.share) * (b ? y.share : 1 - y.share) * (e ? z.share : 1 - z.share) *
           value(x.low + a, y.low + b, z.low + e);
  }
  return sum;
}

void SampledField::fill(const VoxelGrid& grid, std::size_t k, const Window& window, std::span<float> values) const {
  const Vec3 origin = grid.to_world.translation(), spacing = grid.spacing();
  const auto coordinate = [&](int d, std::size_t index) {
    return (origin[d] + static_cast<double>(index) * spacing[d] - box_.min()[d]) / step_;
  };
  const Between z = between(coordinate(2, k), size_[2]);
  std::vector<Between> columns;
  for (std::size_t i = window.first[0]; i < window.last[0]; ++i) columns.push_back(between(coordinate(0, i), size_[0]));
  std::vector<float> line(size_[0]);
  std::size_t out = 0;
  for (std::size_t j = window.first[1]; j < window.last[1]; ++j) {
    const Between y = between(coordinate(1, j), size_[1]);
    for (std::size_t i = 0; i < size_[0]; ++i) {
      const float low = value(i, y.low, z.low) + y.share * (value(i, y.low + 1, z.low) - value(i, y.low, z.low));
      const float high =
          value(i, y.low, z.low + 1) + y.share * (value(i, y.low + 1, z.low + 1) - value(i, y.low, z.low + 1));
      line[i] = low + z.share * (high - low);
    }
    for (const Between& x : columns) values[out++] = line[x.low] + x.share * (line[x.low + 1] - line[x.low]);
  }
}

SampledField::Measure SampledField::measure_inside() const {
  Measure measure;
  double inside = 0;
  const std::array<std::size_t, 3> stride{1, size_[0], size_[0] * size_[1]};
  for (std::size_t k = 1; k + 1 < size_[2]; ++k)
    for (std::size_t j = 1; j + 1 < size_[1]; ++j)
      for (std::size_t i = 1; i + 1 < size_[0]; ++i) {
        const std::size_t v = i + j * stride[1] + k * stride[2];
        const double d = values_[v];
        inside += std::clamp(0.5 - d / step_, 0.0, 1.0);
        if (d >= 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)  // to where the line to the neighbour outside meets zero
          for (const bool up : {false, true}) {
            const double next = values_[up ? v + stride[axis] : v - stride[axis]];
            Vec3 p = place(i, j, k);
            if (next > 0) p[static_cast<Eigen::Index>(axis)] += (up ? 1 : -1) * step_ * d / (d - next);
            measure.extent.extend(p);
          }
      }
  measure.volume = inside * step_ * step_ * step_;
  return measure;
}

}  // namespace calot
