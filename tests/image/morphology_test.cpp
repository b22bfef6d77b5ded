// Opening, closing, parts and holes on shapes whose answers are known.
#include "calot/image/morphology.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace calot {
namespace {

constexpr VoxelSize size{31, 29, 27};
const Eigen::Vector3d unit(1, 1, 1);

template <class Test>
Mask mask_of(const Test& test) {
  Mask mask;
  for (int k = 0; k < 27; ++k)
    for (int j = 0; j < 29; ++j)
      for (int i = 0; i < 31; ++i) mask.push_back(test(i - 15, j - 14, k - 13) ? 1 : 0);
  return mask;
}

bool in_box(int x, int y, int z, int half) {
  return std::max({std::abs(x), std::abs(y), std::abs(z)}) <= half;
}

std::ptrdiff_t count(const Mask& mask) {
  return std::count(mask.begin(), mask.end(), 1);
}

TEST(Morphology, DilationAddsABallAndErosionTakesIt) {
  const Mask point = mask_of([](int x, int y, int z) { return x == 0 && y == 0 && z == 0; });
  const Mask ball = mask_of([](int x, int y, int z) { return x * x + y * y + z * z <= 25; });
  EXPECT_EQ(dilated(point, size, unit, 5), ball);
  EXPECT_EQ(eroded(mask_of([](int x, int y, int z) { return in_box(x, y, z, 8); }), size, unit, 3),
            mask_of([](int x, int y, int z) { return in_box(x, y, z, 5); }));
}

TEST(Morphology, SpacingStretchesTheBall) {
  const Mask point = mask_of([](int x, int y, int z) { return x == 0 && y == 0 && z == 0; });
  EXPECT_EQ(dilated(point, size, {0.5, 1, 3}, 2.9),
            mask_of([](int x, int y, int z) { return 0.25 * x * x + y * y + 9.0 * z * z <= 2.9 * 2.9; }));
}

TEST(Morphology, OpeningTakesHairsAndClosingFillsCracks) {
  const Mask box = mask_of([](int x, int y, int z) { return in_box(x, y, z, 8); });
  const Mask hairy = mask_of([](int x, int y, int z) { return in_box(x, y, z, 8) || (x == 2 && y == 3 && z > 0); });
  const Mask cracked = mask_of([](int x, int y, int z) { return in_box(x, y, z, 8) && !(x == 2 && z > 0); });
  Mask hairless = opened(box, size, unit, 1);  // but for the voxel that the ball still reaches from inside
  const auto at = [](std::size_t x, std::size_t y, std::size_t z) {
    return x + 15 + size[0] * (y + 14 + size[1] * (z + 13));
  };
  hairless[at(2, 3, 9)] = 1;
  EXPECT_EQ(opened(hairy, size, unit, 1), hairless);
  EXPECT_EQ(closed(cracked, size, unit, 1), mask_of([](int x, int y, int z) {
              return in_box(x, y, z, 8) && !(x == 2 && z > 0 && (z == 8 || std::abs(y) == 8));
            }));
}

TEST(Morphology, AnOrganIsNotEatenFromTheVolumesEnd) {
  const Mask slab = mask_of([](int, int, int z) { return z < 0; });
  EXPECT_EQ(eroded(slab, size, unit, 2), mask_of([](int, int, int z) { return z < -2; }));
}

TEST(Morphology, FaceAreaOfABox) {
  const Mask box =
      mask_of([](int x, int y, int z) { return std::abs(x) <= 2 && std::abs(y) <= 3 && std::abs(z) <= 4; });
  EXPECT_NEAR(face_area(box, size, {0.5, 1, 2}), 2 * (2.5 * 7 + 2.5 * 18 + 7 * 18), 1e-9);
}

TEST(Morphology, LargestPartByFacesAndByCorners) {
  const Mask two = mask_of([](int x, int y, int z) {
    return (x >= -5 && x < 0 && std::abs(y) < 3 && z >= -5 && z < 0) ||
           (x >= 0 && x < 4 && std::abs(y) < 3 && z >= 0 && z < 5);
  });  // they share an edge
  Mask by_faces = two, by_corners = two;
  EXPECT_EQ(keep_largest_part(by_faces, size, Joined::by_faces), 1u);
  EXPECT_EQ(by_faces,
            mask_of([](int x, int y, int z) { return x >= -5 && x < 0 && std::abs(y) < 3 && z >= -5 && z < 0; }));
  EXPECT_EQ(keep_largest_part(by_corners, size, Joined::by_corners), 0u);
  EXPECT_EQ(by_corners, two);
}

TEST(Morphology, HolesAreEnclosedAndNotOpenToTheBorder) {
  const Mask hollow = mask_of([](int x, int y, int z) {
    const bool shell = in_box(x, y, z, 8) && !in_box(x, y, z, 3);
    return shell && !(x == 5 && y == 5 && z == 5) && !(x == -6 && y == 0 && z <= -6);  // a hole, and a pit
  });
  std::vector<std::size_t> sizes;
  for (const Hole& hole : holes_in(hollow, size)) sizes.push_back(hole.voxels.size());
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(sizes, (std::vector<std::size_t>{1, 343}));
  EXPECT_EQ(count(hollow), 17 * 17 * 17 - 343 - 1 - 3);
}

TEST(VoxelBox, BoxesOfLabelsAndPadding) {
  std::vector<std::uint8_t> labels(size[0] * size[1] * size[2], 0);
  labels[3 + size[0] * (4 + size[1] * 5)] = 7;
  labels[9 + size[0] * (2 + size[1] * 26)] = 7;
  const VoxelBox box = boxes_of(labels, size)[7];
  EXPECT_EQ(box.first, (VoxelSize{3, 2, 5}));
  EXPECT_EQ(box.last, (VoxelSize{10, 5, 27}));
  EXPECT_EQ(padded(box, {2, 9, 2}, size).first, (VoxelSize{1, 0, 3}));
  EXPECT_EQ(padded(box, {2, 9, 2}, size).last, (VoxelSize{12, 14, 27}));
  EXPECT_TRUE(boxes_of(labels, size)[8].empty());
}

}  // namespace
}  // namespace calot
