#include "calot/cut/swept_plane.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "calot/base/error.h"
#include "calot/cut/blade.h"

namespace calot::detail {
namespace {

using Vec2 = Eigen::Vector2d;

double turn(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double squared_distance(const Vec2& x, const Vec2& a, const Vec2& b) {
  const Vec2 edge = b - a;
  const double size = edge.squaredNorm();
  const double share = size > 0 ? std::clamp((x - a).dot(edge) / size, 0.0, 1.0) : 0.0;
  return (x - a - share * edge).squaredNorm();
}

/// Twice the area vectors' sum, each turned to the first one's side.
Vec3 sum_of_areas(const Sweep& sweep) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [a, b, c] : sweep.triangles) {
    const Vec3 area = (b - a).cross(c - a);
    sum += sum.dot(area) < 0 ? Vec3(-area) : area;
  }
  return sum;
}

}  // namespace

SweptPlane::SweptPlane(const Sweep& sweep, double margin) : margin_(margin) {
  for (const auto& triangle : sweep.triangles)
    for (const Vec3& corner : triangle)
      if (!corner.allFinite()) throw InputError("sweep", "a corner is not finite", "give three numbers");
  const Vec3 areas = sum_of_areas(sweep);
  empty_ = !(areas.norm() > 0);
  if (empty_) return;
  normal_ = areas.normalized();
  double weight = 0;
  Vec3 mean = Vec3::Zero(), along = Vec3::Zero();
  for (const auto& [a, b, c] : sweep.triangles) {
    const double area = (b - a).cross(c - a).norm();
    mean += area * (a + b + c) / 3;
    weight += area;
    for (const Vec3& edge : {Vec3(b - a), Vec3(c - b), Vec3(a - c)})
      if (edge.norm() > along.norm()) along = edge;
  }
  // A corner that lies in the plane serves better than a mean, which rounding moves off it.
  point_ = mean / weight;
  const Vec3& corner = sweep.triangles.front()[0];
  if (std::abs(height(corner)) <= 1e-12 * along.norm()) point_ = corner;
  set_axes(along);
  set_triangles(sweep.triangles);
}

SweptPlane::SweptPlane(const Blade& blade, double margin) : margin_(margin) {
  const ReadyBlade checked(blade, "blade");
  const auto unit = [](const Vec3& v) { return Vec3((v / v.cwiseAbs().maxCoeff()).normalized()); };
  if (const auto* plane = std::get_if<Plane>(&blade)) {
    point_ = plane->point;
    normal_ = unit(plane->normal);
    unbounded_ = true;
    set_axes(normal_.unitOrthogonal());
    return;
  }
  const auto& patch = std::get<BladePatch>(blade);
  point_ = patch.centre;
  normal_ = unit(patch.normal);
  set_axes(unit(patch.along));
  const Vec3 u = along_ * patch.length / 2, v = across_ * patch.width / 2;
  const Vec3 a = point_ - u - v, b = point_ + u - v, c = point_ + u + v, d = point_ - u + v;
  set_triangles(std::array{std::array{a, b, c}, std::array{a, c, d}});
}

void SweptPlane::set_axes(const Vec3& along) {
  across_ = normal_.cross(along).normalized();
  along_ = across_.cross(normal_);
}

void SweptPlane::set_triangles(std::span<const std::array<Vec3, 3>> triangles) {
  low_.setConstant(std::numeric_limits<double>::infinity());
  high_ = -low_;
  for (const auto& [a, b, c] : triangles) {
    std::array<Vec2, 3> corners{flat(a), flat(b), flat(c)};
    if (turn(corners[1] - corners[0], corners[2] - corners[0]) < 0) std::swap(corners[1], corners[2]);
    for (const Vec3& corner : {a, b, c}) {
      low_ = low_.cwiseMin(flat(corner));
      high_ = high_.cwiseMax(flat(corner));
      unevenness_ = std::max(unevenness_, std::abs(height(corner)));
    }
    triangles_.push_back(corners);
  }
  low_.array() -= margin_;
  high_.array() += margin_;
}

bool SweptPlane::covers(const Vec3& x) const {
  if (unbounded_) return true;
  const Vec2 foot = flat(x);
  if ((foot.array() < low_.array()).any() || (foot.array() > high_.array()).any()) return false;
  return std::any_of(triangles_.begin(), triangles_.end(), [&](const std::array<Vec2, 3>& t) {
    bool inside = true;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 &a = t[i], &b = t[(i + 1) % 3];
      inside = inside && turn(b - a, foot - a) >= 0;
      nearest = std::min(nearest, squared_distance(foot, a, b));
    }
    return inside || nearest <= margin_ * margin_;
  });
}

}  // namespace calot::detail
