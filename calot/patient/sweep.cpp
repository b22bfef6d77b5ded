#include "calot/patient/sweep.h"

#include <algorithm>
#include <cmath>

namespace calot {

Curve spline(const std::vector<Vec3>& through) {
  Curve curve;
  const auto at = [&](std::ptrdiff_t i) {
    return through[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(through) - 1))];
  };
  for (std::ptrdiff_t i = 0; i + 1 < std::ssize(through); ++i) {
    const Vec3 a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    for (int step = 0; step < 40; ++step) {
      const double t = step / 40.0;
      curve.push_back(
          0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) + t * t * t * (3 * b - a - 3 * c + d)));
    }
  }
  curve.push_back(through.back());
  return curve;
}

namespace {
double length_of(const Curve& curve) {
  double sum = 0;
  for (std::size_t p = 1; p < curve.size(); ++p) sum += (curve[p] - curve[p - 1]).norm();
  return sum;
}
}  // namespace

Curve scaled_to_length(Curve curve, double length) {
  const double factor = length / length_of(curve);
  const Vec3 origin = curve.front();
  for (Vec3& p : curve) p = origin + factor * (p - origin);
  return curve;
}

Curve resampled(const Curve& curve, double step) {
  const double total = length_of(curve);
  const int pieces = std::max(1, static_cast<int>(std::lround(total / step)));
  Curve even{curve.front()};
  double before = 0;
  std::size_t segment = 1;
  for (int i = 1; i < pieces; ++i) {
    const double wanted = total * i / pieces;
    double size = (curve[segment] - curve[segment - 1]).norm();
    while (before + size < wanted && segment + 1 < curve.size()) {
      before += size;
      ++segment;
      size = (curve[segment] - curve[segment - 1]).norm();
    }
    const double t = size > 0 ? (wanted - before) / size : 0;
    even.push_back(curve[segment - 1] + t * (curve[segment] - curve[segment - 1]));
  }
  even.push_back(curve.back());
  return even;
}

double distance_to(const Curve& curve, const Vec3& point) {
  double nearest = (point - curve.front()).squaredNorm();
  for (std::size_t p = 1; p < curve.size(); ++p) {
    const Vec3 along = curve[p] - curve[p - 1], from = point - curve[p - 1];
    const double t = std::clamp(along.dot(from) / std::max(along.squaredNorm(), 1e-30), 0.0, 1.0);
    nearest = std::min(nearest, (from - t * along).squaredNorm());
  }
  return std::sqrt(nearest);
}

BallChain balls_along(const Curve& curve, const std::vector<double>& radii) {
  BallChain balls;
  for (std::size_t p = 0; p < curve.size(); ++p) balls.push_back({curve[p], radii[p]});
  return balls;
}

Eigen::AlignedBox3d bounds(const BallChain& balls) {
  Eigen::AlignedBox3d box;
  for (const Ball& ball : balls) {
    box.extend(Vec3(ball.centre.array() - ball.radius));
    box.extend(Vec3(ball.centre.array() + ball.radius));
  }
  return box;
}

double volume_of_revolution(const BallChain& balls) {
  std::vector<double> place(balls.size(), 0.0);
  for (std::size_t b = 1; b < balls.size(); ++b)
    place[b] = place[b - 1] + (balls[b].centre - balls[b - 1].centre).norm();
  double begin = 0, end = 0;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    begin = std::min(begin, place[b] - balls[b].radius);
    end = std::max(end, place[b] + balls[b].radius);
  }
  constexpr int slices = 400;
  double sum = 0;
  for (int s = 0; s < slices; ++s) {
    const double x = begin + (end - begin) * (s + 0.5) / slices;
    double squared = 0;
    for (std::size_t b = 0; b < balls.size(); ++b)
      squared = std::max(squared, balls[b].radius * balls[b].radius - (x - place[b]) * (x - place[b]));
    sum += squared;
  }
  return M_PI * sum * (end - begin) / slices;
}

void lower_to_distance(const BallChain& balls, const VoxelGrid& grid, std::size_t k, double reach,
                       std::span<float> distance) {
  const Vec3 origin = grid.to_world.translation(), spacing = grid.spacing();
  const double z = origin[2] + static_cast<double>(k) * spacing[2];
  for (const Ball& ball : balls) {
    const double dz = z - ball.centre[2], far = ball.radius + reach;
    if (std::abs(dz) >= far) continue;
    const double wide = std::sqrt(far * far - dz * dz);
    std::array<std::size_t, 2> first{}, last{};
    for (std::size_t d = 0; d < 2; ++d) {
      const auto axis = static_cast<Eigen::Index>(d);
      const double low = (ball.centre[axis] - wide - origin[axis]) / spacing[axis];
      const double high = (ball.centre[axis] + wide - origin[axis]) / spacing[axis];
      first[d] = static_cast<std::size_t>(std::max(0.0, std::ceil(low)));
      last[d] = static_cast<std::size_t>(std::clamp(std::floor(high) + 1, 0.0, static_cast<double>(grid.size[d])));
    }
    for (std::size_t j = first[1]; j < last[1]; ++j) {
      const double dy = origin[1] + static_cast<double>(j) * spacing[1] - ball.centre[1];
      for (std::size_t i = first[0]; i < last[0]; ++i) {
        const double dx = origin[0] + static_cast<double>(i) * spacing[0] - ball.centre[0];
        float& d = distance[i + grid.size[0] * j];
        d = std::min(d, static_cast<float>(std::sqrt(dx * dx + dy * dy + dz * dz) - ball.radius));
      }
    }
  }
}

}  // namespace calot
