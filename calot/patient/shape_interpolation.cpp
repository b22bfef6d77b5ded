#include "calot/patient/shape_interpolation.h"

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"

namespace calot {

AxisMap::AxisMap(const VoxelGrid& from, const VoxelGrid& to) : from_size_(from.size), to_size_(to.size) {
  const Eigen::Affine3d map = from.to_world.inverse() * to.to_world;
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    first_[d] = map.translation()[axis];
    step_[d] = map.linear()(axis, axis);
  }
}

std::vector<AxisMap::Linear> AxisMap::linear(std::size_t axis) const {
  std::vector<Linear> all(to_size_[axis]);
  const double last = static_cast<double>(from_size_[axis] - 1);
  for (std::size_t o = 0; o < all.size(); ++o) {
    const double x = std::clamp(at(axis, o), 0.0, last), low = std::min(std::floor(x), last);
    all[o].low = static_cast<std::size_t>(low);
    all[o].high = std::min(all[o].low + 1, from_size_[axis] - 1);
    all[o].part = static_cast<float>(x - low);
  }
  return all;
}

std::vector<AxisMap::Cubic> AxisMap::cubic(std::size_t axis, std::size_t begin, std::size_t end, std::size_t origin,
                                           std::size_t size) const {
  std::vector<Cubic> all(end - begin);
  const double last = static_cast<double>(size - 1);
  for (std::size_t o = begin; o < end; ++o) {
    Cubic& cubic = all[o - begin];
    const double x = std::clamp(at(axis, o) - static_cast<double>(origin), 0.0, last), low = std::floor(x), t = x - low;
    const std::array<double, 4> weight{0.5 * (-t + 2 * t * t - t * t * t), 0.5 * (2 - 5 * t * t + 3 * t * t * t),
                                       0.5 * (t + 4 * t * t - 3 * t * t * t), 0.5 * (t * t * t - t * t)};
    for (std::size_t n = 0; n < 4; ++n) {
      cubic.from[n] = static_cast<std::size_t>(std::clamp(low + static_cast<double>(n) - 1, 0.0, last));
      cubic.weight[n] = static_cast<float>(weight[n]);
    }
  }
  return all;
}

std::vector<std::size_t> AxisMap::nearest(std::size_t axis) const {
  std::vector<std::size_t> all(to_size_[axis]);
  for (std::size_t o = 0; o < all.size(); ++o)
    all[o] = static_cast<std::size_t>(
        std::clamp(std::floor(at(axis, o) + 0.5), 0.0, static_cast<double>(from_size_[axis] - 1)));
  return all;
}

bool AxisMap::inside(std::size_t i, std::size_t j, std::size_t k) const {
  const std::array<std::size_t, 3> voxel{i, j, k};
  for (std::size_t d = 0; d < 3; ++d) {
    const double x = at(d, voxel[d]);
    if (!(x >= -0.5 && x < static_cast<double>(from_size_[d]) - 0.5)) return false;
  }
  return true;
}

VoxelBox AxisMap::covered(const VoxelBox& box) const {
  VoxelBox found;
  for (std::size_t d = 0; d < 3; ++d) {
    const double low = (static_cast<double>(box.first[d]) - 1.5 - first_[d]) / step_[d];
    const double high = (static_cast<double>(box.last[d]) + 0.5 - first_[d]) / step_[d];
    const double n = static_cast<double>(to_size_[d]);
    found.first[d] = static_cast<std::size_t>(std::clamp(std::ceil(low), 0.0, n));
    found.last[d] = static_cast<std::size_t>(std::clamp(std::floor(high) + 1, 0.0, n));
  }
  return found;
}

std::vector<float> interpolated(const std::vector<float>& values, const VoxelBox& from_box, const VoxelBox& to_box,
                                const AxisMap& map) {
  const VoxelSize from = from_box.size(), to = to_box.size();
  std::array<std::vector<AxisMap::Cubic>, 3> taps;
  for (std::size_t d = 0; d < 3; ++d)
    taps[d] = map.cubic(d, to_box.first[d], to_box.last[d], from_box.first[d], from[d]);
  std::vector<float> out(to_box.count());
  const std::size_t slice = from[0] * from[1];
  const auto sum = [](const AxisMap::Cubic& tap, const float* at, std::size_t stride) {
    return tap.weight[0] * at[tap.from[0] * stride] + tap.weight[1] * at[tap.from[1] * stride] +
           tap.weight[2] * at[tap.from[2] * stride] + tap.weight[3] * at[tap.from[3] * stride];
  };
  parallel_for(to[2], [&](std::size_t k) {
    std::vector<float> plane(slice), row(from[0]);
    for (std::size_t p = 0; p < slice; ++p) plane[p] = sum(taps[2][k], &values[p], slice);
    for (std::size_t j = 0; j < to[1]; ++j) {
      for (std::size_t i = 0; i < from[0]; ++i) row[i] = sum(taps[1][j], &plane[i], from[0]);
      float* const target = &out[to[0] * (j + to[1] * k)];
      for (std::size_t i = 0; i < to[0]; ++i) target[i] = sum(taps[0][i], row.data(), 1);
    }
  });
  return out;
}

}  // namespace calot
