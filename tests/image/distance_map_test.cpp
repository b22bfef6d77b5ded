// Distance maps against a search through all voxels, on spacings that differ by axis.
#include "calot/image/distance_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calot/base/parallel.h"

namespace calot {
namespace {

Mask scattered(const VoxelSize& size, unsigned one_in) {
  Mask mask(size[0] * size[1] * size[2]);
  std::uint32_t state = 12345;
  for (std::uint8_t& voxel : mask) {
    state = state * 1664525u + 1013904223u;
    voxel = (state >> 16) % one_in == 0 ? 1 : 0;
  }
  return mask;
}

double searched(const Mask& mask, const VoxelSize& size, const Eigen::Vector3d& spacing, std::size_t v,
                std::uint8_t wanted) {
  const auto place = [&](std::size_t w) {
    return Eigen::Vector3d(static_cast<double>(w % size[0]), static_cast<double>(w / size[0] % size[1]),
                           static_cast<double>(w / (size[0] * size[1])))
        .cwiseProduct(spacing)
        .eval();
  };
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t w = 0; w < mask.size(); ++w)
    if (mask[w] == wanted) least = std::min(least, (place(v) - place(w)).norm());
  return least;
}

TEST(DistanceMap, IsTheNearestOfAllVoxels) {
  const VoxelSize size{17, 13, 9};
  for (const Eigen::Vector3d& spacing :
       {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0.7, 0.7, 3), Eigen::Vector3d(2, 0.5, 1)})
    for (const unsigned one_in : {2u, 40u, 700u}) {
      const Mask mask = scattered(size, one_in);
      const std::vector<float> to_set = distance_to_set(mask, size, spacing);
      const std::vector<float> to_unset = distance_to_unset(mask, size, spacing);
      for (std::size_t v = 0; v < mask.size(); ++v) {
        ASSERT_NEAR(to_set[v], searched(mask, size, spacing, v, 1), 1e-5) << v;
        ASSERT_NEAR(to_unset[v], searched(mask, size, spacing, v, 0), 1e-5) << v;
      }
    }
}

TEST(DistanceMap, IsInfiniteWhereNothingIsSet) {
  const Mask none(60, 0);
  for (const float d : distance_to_set(none, {5, 4, 3}, {1, 1, 1})) EXPECT_TRUE(std::isinf(d));
  for (const float d : distance_to_unset(none, {5, 4, 3}, {1, 1, 1})) EXPECT_EQ(d, 0);
}

TEST(DistanceMap, IsTheSameOnAnyNumberOfThreads) {
  const VoxelSize size{40, 31, 23};
  const Mask mask = scattered(size, 300);
  const int before = thread_count();
  set_thread_count(1);
  const std::vector<float> one = distance_to_set(mask, size, {0.7, 0.7, 3});
  set_thread_count(2);
  const std::vector<float> two = distance_to_set(mask, size, {0.7, 0.7, 3});
  set_thread_count(before);
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace calot
