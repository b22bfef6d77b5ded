// Closed surfaces made into voxels: against closed forms, and no stripes where centres lie on faces, edges or vertices.
#include "calot/image/surface_voxels.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>

#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

/// A box between two corners [voxels of `grid`], cut into triangles.
Surface box(const VoxelGrid& grid, const Vec3& low, const Vec3& high) {
  Surface surface;
  for (int c = 0; c < 8; ++c)
    surface.positions.emplace_back(grid.to_world *
                                   Vec3(c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 4 ? high[2] : low[2]));
  surface.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return surface;
}

/// A ball of unit radius made of 8 · 4^levels triangles.
Surface ball(int levels) {
  Surface surface;
  surface.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  surface.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, added] = middles.emplace(std::minmax(a, b), static_cast<std::uint32_t>(surface.positions.size()));
      if (added) surface.positions.push_back((surface.positions[a] + surface.positions[b]).normalized());
      return at->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : surface.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    surface.triangles = finer;
  }
  return surface;
}

double enclosed(const Surface& surface) {
  double six = 0;
  for (const auto& [a, b, c] : surface.triangles)
    six += surface.positions[a].dot(surface.positions[b].cross(surface.positions[c]));
  return six / 6;
}

std::size_t count(const SurfaceVoxels& voxels) {
  return std::accumulate(voxels.inside.begin(), voxels.inside.end(), std::size_t{0});
}

VoxelGrid straight(std::size_t n) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.to_world = Eigen::Affine3d(Eigen::Scaling(0.001));
  return grid;
}

TEST(SurfaceVoxels, boxes_with_faces_on_voxel_centres_fill_half_open_ranges) {
  for (const VoxelGrid& grid : {straight(12), test::oblique_grid({12, 12, 12}, {0.0007, 0.0011, 0.0023})}) {
    const SurfaceVoxels voxels = voxels_inside(box(grid, {2, 3, 4}, {7, 6, 9}), grid, "box");
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const std::size_t i = v % 12, j = v / 12 % 12, k = v / 144;
      const bool inside = i >= 2 && i < 7 && j >= 3 && j < 6 && k >= 4 && k < 9;
      ASSERT_EQ(voxels.inside[v], inside) << i << " " << j << " " << k;
    }
    EXPECT_FALSE(voxels.cut);
  }
}

TEST(SurfaceVoxels, boxes_side_by_side_share_no_voxel_and_leave_none_out) {
  const VoxelGrid grid = test::oblique_grid({14, 14, 14}, {0.0007, 0.0011, 0.0023});
  std::vector<int> covers(grid.count());
  const std::array<double, 4> cuts{1, 5, 6.5, 11};
  for (int b = 0; b < 27; ++b) {
    const auto at = [&](int d, int side) {
      return cuts[static_cast<std::size_t>(b / (d == 0 ? 1 : d == 1 ? 3 : 9) % 3 + side)];
    };
    const auto voxels =
        voxels_inside(box(grid, {at(0, 0), at(1, 0), at(2, 0)}, {at(0, 1), at(1, 1), at(2, 1)}), grid, "box");
    for (std::size_t v = 0; v < grid.count(); ++v) covers[v] += voxels.inside[v];
  }
  EXPECT_EQ(std::count(covers.begin(), covers.end(), 1), 1000);
  EXPECT_EQ(*std::max_element(covers.begin(), covers.end()), 1);
}

TEST(SurfaceVoxels, octahedra_with_vertices_and_edges_on_centres_hold_every_centre_strictly_inside) {
  const VoxelGrid grid = straight(21);
  Surface surface = ball(0);
  for (const int radius : {1, 4, 9}) {
    Surface octahedron = surface;
    for (Vec3& at : octahedron.positions) at = 0.001 * (radius * at + Vec3(10, 10, 10));
    const SurfaceVoxels voxels = voxels_inside(octahedron, grid, "octahedron");
    for (int v = 0; v < 21 * 21 * 21; ++v) {
      const int distance = std::abs(v % 21 - 10) + std::abs(v / 21 % 21 - 10) + std::abs(v / 441 - 10);
      if (distance != radius) {
        ASSERT_EQ(voxels.inside[static_cast<std::size_t>(v)], distance < radius);
      }
    }
  }
}

TEST(SurfaceVoxels, random_tetrahedra_against_barycentric_coordinates) {
  const VoxelGrid grid = test::oblique_grid({15, 17, 16}, {0.0011, 0.0009, 0.0013});
  std::mt19937 random(7);
  for (int round = 0; round < 60; ++round) {
    Surface tet;
    for (int c = 0; c < 4; ++c) {
      const auto coordinate = [&] { return static_cast<double>(random() % 1024) / 64; };
      const double x = coordinate(), y = coordinate(), z = coordinate();
      tet.positions.emplace_back(grid.to_world * Vec3(x, y, z));
    }
    tet.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    Eigen::Matrix4d corners;
    for (int c = 0; c < 4; ++c) corners.col(c) << tet.positions[static_cast<std::size_t>(c)] * 1e3, 1.0;
    if (std::abs(corners.determinant()) < 1) continue;
    const SurfaceVoxels voxels = voxels_inside(tet, grid, "tet");
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const Vec3 at = grid.to_world * Vec3(static_cast<double>(v % 15), static_cast<double>(v / 15 % 17),
                                           static_cast<double>(v / (15 * 17)));
      Eigen::Vector4d place;
      place << 1e3 * at, 1.0;
      const double smallest = corners.fullPivLu().solve(place).minCoeff();
      if (std::abs(smallest) > 1e-3) {
        ASSERT_EQ(voxels.inside[v], smallest > 0) << round << " " << v;
      }
    }
  }
}

TEST(SurfaceVoxels, volumes_of_balls_agree_with_their_surfaces) {
  const VoxelGrid grid = test::oblique_grid({70, 70, 70}, {0.0007, 0.0008, 0.0009});
  Surface surface = ball(4);
  const Vec3 centre = grid.to_world * Vec3(34.2, 34.9, 34.5);
  for (Vec3& at : surface.positions) at = 0.02 * at + centre;
  const SurfaceVoxels voxels = voxels_inside(surface, grid, "ball");
  const double volume = enclosed(surface);
  EXPECT_NEAR(static_cast<double>(count(voxels)) * grid.voxel_volume() / volume, 1, 2e-3);
  for (Triangle& t : surface.triangles)
    if (t[0] % 2) std::swap(t[0], t[1]);
  EXPECT_EQ(voxels_inside(surface, grid, "ball").inside, voxels.inside) << "whichever way triangles wind";
  Surface apart;  // every triangle with vertices of its own
  for (const Triangle& t : surface.triangles) {
    const auto n = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t v : t) apart.positions.push_back(surface.positions[v]);
    apart.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_EQ(voxels_inside(apart, grid, "ball").inside, voxels.inside);
}

TEST(SurfaceVoxels, a_hollow_ball_is_hollow) {
  const VoxelGrid grid = straight(40);
  Surface shell = ball(3);
  const auto n = static_cast<std::uint32_t>(shell.positions.size());
  for (std::uint32_t v = 0; v < n; ++v) {
    shell.positions.push_back(0.008 * shell.positions[v] + Vec3(0.02, 0.02, 0.02));
    shell.positions[v] = 0.016 * shell.positions[v] + Vec3(0.02, 0.02, 0.02);
  }
  const std::size_t outer = shell.triangles.size();
  for (std::size_t t = 0; t < outer; ++t) {
    const Triangle inner = shell.triangles[t];
    shell.triangles.push_back({inner[0] + n, inner[1] + n, inner[2] + n});
  }
  const SurfaceVoxels voxels = voxels_inside(shell, grid, "shell");
  EXPECT_EQ(voxels.inside[grid.index(20, 20, 20)], 0);
  EXPECT_EQ(voxels.inside[grid.index(20, 32, 20)], 1);
  EXPECT_NEAR(static_cast<double>(count(voxels)), enclosed(ball(3)) * (16 * 16 * 16 - 8 * 8 * 8), 75);
}

TEST(SurfaceVoxels, beyond_the_border_it_is_cut_and_outside_it_is_refused) {
  const VoxelGrid grid = test::oblique_grid({10, 10, 10}, {0.001, 0.001, 0.001});
  const SurfaceVoxels half = voxels_inside(box(grid, {-5.25, 2.5, -7.25}, {4.5, 30.25, 40}), grid, "box");
  EXPECT_TRUE(half.cut);
  EXPECT_EQ(count(half), 5u * 7u * 10u);
  const std::string far = test::message_of([&] { voxels_inside(box(grid, {20, 2, 2}, {25, 5, 5}), grid, "far.stl"); });
  EXPECT_NE(far.find("far.stl: lies outside the CT: x "), std::string::npos) << far;
  EXPECT_NE(far.find(" mm against x "), std::string::npos) << far;
  Surface metres = box(grid, {2, 2, 2}, {5, 5, 5});
  for (Vec3& at : metres.positions) at *= 1e3;
  EXPECT_NE(test::message_of([&] { voxels_inside(metres, grid, "m.stl"); }).find("lies outside"), std::string::npos);
  EXPECT_NE(test::message_of([&] { voxels_inside(Surface{}, grid, "e.stl"); }).find("lies outside"), std::string::npos);
}

TEST(SurfaceVoxels, open_surfaces_are_refused) {
  const VoxelGrid grid = straight(12);
  Surface open = box(grid, {2, 3, 4}, {7, 6, 9});
  open.triangles.pop_back();
  const std::string text = test::message_of([&] { voxels_inside(open, grid, "open.stl"); });
  EXPECT_EQ(text,
            "open.stl: isn't closed: 3 edges with an odd number of triangles; close its holes, or give a label map");
  Surface fin = box(grid, {2, 3, 4}, {7, 6, 9});
  fin.triangles.push_back({0, 1, 7});
  EXPECT_NE(test::message_of([&] { voxels_inside(fin, grid, "fin.stl"); }).find("isn't closed"), std::string::npos);
}

}  // namespace
}  // namespace calot
