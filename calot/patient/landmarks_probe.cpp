#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "calot/patient/landmarks_parts.h"

namespace calot::detail {

Structure LabelProbe::at(const Vec3& point) const {
  const Vec3 v = to_voxel_ * point;
  std::array<std::size_t, 3> index{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double rounded = std::round(v[static_cast<Eigen::Index>(d)]);
    if (!(rounded >= 0 && rounded < static_cast<double>(map_.grid.size[d]))) return Structure::none;
    index[d] = static_cast<std::size_t>(rounded);
  }
  return static_cast<Structure>(map_.voxels[map_.grid.index(index[0], index[1], index[2])]);
}

LabelProbe::Blocked LabelProbe::blocked(const Vec3& from, const Vec3& to) const {
  const double length = (to - from).norm(), step = voxel();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step)));
  double in_liver = 0, in_gallbladder = 0;
  for (int s = 0; s < steps; ++s) {
    const Structure here = at(from + (s + 0.5) / steps * (to - from));
    if (here == Structure::liver) in_liver += length / steps;
    if (here == Structure::gallbladder || here == Structure::gallbladder_wall) in_gallbladder += length / steps;
  }
  if (in_liver + in_gallbladder == 0) return {};
  return {in_liver + in_gallbladder, in_liver >= in_gallbladder ? Structure::liver : Structure::gallbladder};
}

template <class Wanted>
std::optional<Vec3> LabelProbe::nearest_where(const Vec3& point, double reach, const Wanted& wanted) const {
  const Vec3 centre = to_voxel_ * point, spacing = map_.grid.spacing();
  std::array<std::ptrdiff_t, 3> low{}, high{};
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    const double last = static_cast<double>(map_.grid.size[d]) - 1, far = reach / spacing[axis];
    low[d] = static_cast<std::ptrdiff_t>(std::clamp(std::ceil(centre[axis] - far), 0.0, last + 1));
    high[d] = static_cast<std::ptrdiff_t>(std::clamp(std::floor(centre[axis] + far), -1.0, last));
  }
  double best = reach * reach;
  std::optional<Vec3> found;
  for (auto k = low[2]; k <= high[2]; ++k)
    for (auto j = low[1]; j <= high[1]; ++j)
      for (auto i = low[0]; i <= high[0]; ++i) {
        const Label label = map_.voxels[map_.grid.index(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                                                        static_cast<std::size_t>(k))];
        if (label == 0 || !wanted(static_cast<Structure>(label))) continue;
        const Vec3 voxel(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const double distance = (voxel - centre).cwiseProduct(spacing).squaredNorm();
        if (distance > best) continue;
        best = distance;
        found = map_.grid.to_world * voxel;
      }
  return found;
}

std::optional<Vec3> LabelProbe::nearest(const Vec3& point, std::initializer_list<Structure> wanted,
                                        double reach) const {
  return nearest_where(point, reach,
                       [&](Structure s) { return std::find(wanted.begin(), wanted.end(), s) != wanted.end(); });
}

bool LabelProbe::organ_within(const Vec3& point, double distance) const {
  return nearest_where(point, distance,
                       [](Structure s) { return s != Structure::hepatocystic_fat && s != Structure::gallbladder_bed; })
      .has_value();
}

std::string in_mm(double metres) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", metres * 1e3);
  return text.data();
}

}  // namespace calot::detail
