// A value for every place, so that a voxel that is read to the wrong place has the wrong value.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calot/image/volume.h"

namespace calot::test {

/// What hu() of dicom_fixture.h gives at a place in RAS metres.
inline double hu_at(const Eigen::Vector3d& ras) {
  const double x = -1e3 * ras[0], y = -1e3 * ras[1], z = 1e3 * ras[2];
  return std::nearbyint(400 * std::sin(0.9 * x + 0.3) + 300 * std::cos(0.7 * y) + 250 * std::sin(0.8 * z) - 50);
}

/// Calls body(voxel number, place in RAS metres) for every voxel.
template <class Body>
void for_each_voxel(const VoxelGrid& grid, const Body& body) {
  std::size_t v = 0;
  for (std::size_t k = 0; k < grid.size[2]; ++k)
    for (std::size_t j = 0; j < grid.size[1]; ++j)
      for (std::size_t i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        body(v++, Eigen::Vector3d(grid.to_world * index));
      }
}

/// Every voxel's value against the function of its place; 1 HU is left to rounding.
inline void expect_in_place(const CtImage& ct, const std::string& what) {
  std::size_t wrong = 0;
  for_each_voxel(ct.grid, [&](std::size_t v, const Eigen::Vector3d& place) {
    wrong += std::abs(ct.hounsfield[v] - hu_at(place)) > 1.01;
  });
  EXPECT_EQ(wrong, 0u) << what;
}

}  // namespace calot::test
