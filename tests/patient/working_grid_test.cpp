// Resampled shapes keep their volumes, and stay smooth across thick slices.
#include "calot/patient/working_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calot/image/morphology.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

using Inside = std::function<bool(const Vec3& mm)>;

/// A shape around (0, 0, 0) on voxels of `spacing` [mm], turned about all axes.
WorkLabels drawn(const Inside& inside, Structure s, const Vec3& spacing, const Vec3& reach) {
  std::array<std::size_t, 3> size{};
  for (std::size_t d = 0; d < 3; ++d)
    size[d] = static_cast<std::size_t>(
        2 * std::ceil(reach[static_cast<Eigen::Index>(d)] / spacing[static_cast<Eigen::Index>(d)]) + 11);
  WorkLabels labels{test::oblique_grid(size, 1e-3 * spacing), {}};
  labels.voxels.resize(labels.grid.count());
  const Vec3 middle(0.37 + (static_cast<double>(size[0]) - 1) / 2, 0.21 + (static_cast<double>(size[1]) - 1) / 2,
                    -0.13 + (static_cast<double>(size[2]) - 1) / 2);
  for_voxels({{0, 0, 0}, size}, size, [&](std::size_t v, std::size_t) {
    const Vec3 at(static_cast<double>(v % size[0]), static_cast<double>(v / size[0] % size[1]),
                  static_cast<double>(v / (size[0] * size[1])));
    if (inside((at - middle).cwiseProduct(spacing))) labels.voxels[v] = static_cast<std::uint8_t>(label_of(s));
  });
  return labels;
}

struct Resampled {
  WorkLabels labels;
  double volume;  // mm³
};

Resampled resample(const WorkLabels& labels, Structure s, double spacing) {
  CompletionOptions options;
  options.spacing = spacing;
  options.margin = 5e-3;
  Progress progress;
  const WorkingGrid grid = choose_working_grid(labels, labels.grid, {}, options);
  Resampled out{resample_labels(labels, grid, progress), 0};
  out.volume = 1e9 * out.labels.grid.voxel_volume() * static_cast<double>(out.labels.count(s));
  return out;
}

bool ball(const Vec3& p) {
  return p.norm() < 12;
}
bool ellipsoid(const Vec3& p) {
  return p.cwiseQuotient(Vec3(9, 14, 20)).norm() < 1;
}
/// A bent tube of radius 2.5 and 1.6 mm: a quarter of a ring of radius 20 mm in a slanted plane.
bool tube(const Vec3& p, double radius) {
  const Vec3 q(p[0] + 10, 0.8 * p[1] - 0.6 * p[2], 0.6 * p[1] + 0.8 * p[2] + 10);
  const double angle = std::clamp(std::atan2(q[2], q[0]), 0.0, M_PI / 2);
  return (q - 20 * Vec3(std::cos(angle), 0, std::sin(angle))).norm() < radius;
}

TEST(WorkingGrid, VolumesSurviveResampling) {
  struct Case {
    const char* name;
    Inside inside;
    Structure s;
    double volume, allowed;
  };
  const auto tube_volume = [](double r) { return M_PI * r * r * 10 * M_PI + 4 * M_PI / 3 * r * r * r; };
  // Coarse voxels themselves are off by up to 6 % for the tubes.
  const std::vector<Case> cases{
      {"ball", ball, Structure::gallbladder, 4 * M_PI / 3 * 12 * 12 * 12, 0.015},
      {"ellipsoid", ellipsoid, Structure::gallbladder, 4 * M_PI / 3 * 9 * 14 * 20, 0.015},
      {"tube 2.5", [](const Vec3& p) { return tube(p, 2.5); }, Structure::common_bile_duct, tube_volume(2.5), 0.08},
      {"tube 1.6", [](const Vec3& p) { return tube(p, 1.6); }, Structure::cystic_duct, tube_volume(1.6), 0.08}};
  for (const Case& c : cases)
    for (const Vec3& spacing : {Vec3(1.3, 1.3, 1.3), Vec3(0.7, 0.7, 3)}) {
      const WorkLabels labels = drawn(c.inside, c.s, spacing, {26, 26, 26});
      const double counted = 1e9 * labels.grid.voxel_volume() * static_cast<double>(labels.count(c.s));
      const Resampled out = resample(labels, c.s, 0.6e-3);
      EXPECT_NEAR(out.volume / c.volume, 1, c.allowed) << c.name << ' ' << spacing[2];
      EXPECT_NEAR(out.volume / counted, 1, 0.01) << c.name << ' ' << spacing[2];
    }
}

TEST(WorkingGrid, ThickSlicesDontBecomeTerraces) {
  const WorkLabels labels = drawn(ball, Structure::gallbladder, {0.7, 0.7, 3}, {13, 13, 13});
  const Resampled out = resample(labels, Structure::gallbladder, 0.6e-3);
  // Distance of surface voxels from the ball's surface; terraces of the nearest voxel are off by up to half a slice.
  const VoxelBox box{{0, 0, 0}, out.labels.grid.size};
  const VoxelSize size = out.labels.grid.size;
  Vec3 middle = Vec3::Zero();
  const auto place = [&](std::size_t v) {
    return Vec3(1e3 * (out.labels.grid.to_world * Vec3(static_cast<double>(v % size[0]),
                                                       static_cast<double>(v / size[0] % size[1]),
                                                       static_cast<double>(v / (size[0] * size[1])))));
  };
  for_voxels(box, size, [&](std::size_t v, std::size_t) {
    if (out.labels.voxels[v] != 0) middle += place(v) / static_cast<double>(out.labels.count(Structure::gallbladder));
  });
  double squared = 0, count = 0;
  for_voxels(box, size, [&](std::size_t v, std::size_t) {
    if (out.labels.voxels[v] == 0) return;
    bool surface = false;
    for_face_neighbours(v, size, [&](std::size_t w) { surface = surface || out.labels.voxels[w] == 0; });
    if (!surface) return;
    squared += std::pow((place(v) - middle).norm() - (12 - 0.3), 2);
    ++count;
  });
  EXPECT_LT(std::sqrt(squared / count), 0.4);  // mm; voxels of 0.6 mm alone make 0.2
}

TEST(WorkingGrid, ThinTubesDontVanish) {
  for (const Vec3& spacing : {Vec3(1, 1, 1.2), Vec3(0.8, 0.8, 3)}) {
    WorkLabels labels =
        drawn([](const Vec3& p) { return std::abs(p[0]) < 0.45 && std::abs(p[1]) < 0.45 && std::abs(p[2]) < 20; },
              Structure::cystic_artery, spacing, {10, 10, 22});
    const double counted =
        1e9 * labels.grid.voxel_volume() * static_cast<double>(labels.count(Structure::cystic_artery));
    Resampled out = resample(labels, Structure::cystic_artery, 0.6e-3);
    EXPECT_GT(out.volume / counted, 0.99);
    EXPECT_LT(out.volume / counted, 2.3);  // along the voxels it is one or four wide: 0.36 or 1.44 mm² for 0.64
    Mask mask = out.labels.voxels;
    for (std::uint8_t& voxel : mask) voxel = voxel != 0 ? 1 : 0;
    EXPECT_EQ(keep_largest_part(mask, out.labels.grid.size, Joined::by_faces), 0u);
  }
}

TEST(WorkingGrid, TouchingStructuresStayInTouch) {
  const Vec3 spacing(0.8, 0.8, 3);
  WorkLabels labels = drawn(ball, Structure::liver, spacing, {13, 13, 13});
  const auto size = labels.grid.size;
  for (std::size_t v = 0; v < labels.voxels.size(); ++v)
    if (labels.voxels[v] != 0 && v % size[0] + v / (size[0] * size[1]) > size[0] / 2 + 4)
      labels.voxels[v] = static_cast<std::uint8_t>(label_of(Structure::gallbladder));
  Progress progress;
  CompletionOptions options;
  const WorkLabels out = resample_labels(labels, choose_working_grid(labels, labels.grid, {}, options), progress);
  Mask mask = out.voxels;
  for (std::uint8_t& voxel : mask) voxel = voxel != 0 ? 1 : 0;
  EXPECT_TRUE(holes_in(mask, out.grid.size).empty());
  const double both = 1e9 * out.grid.voxel_volume() * static_cast<double>(std::count(mask.begin(), mask.end(), 1));
  EXPECT_NEAR(both / (4 * M_PI / 3 * 12 * 12 * 12), 1, 0.03);
  EXPECT_GT(out.count(Structure::gallbladder), 1000u);
}

TEST(WorkingGrid, IsFinerForThinTubesAndTheCtsOwnWhereItCan) {
  const WorkLabels fine = drawn(ball, Structure::gallbladder, {0.9, 0.9, 0.92}, {13, 13, 13});
  CompletionOptions options;
  options.margin = 5e-3;
  const WorkingGrid own = choose_working_grid(fine, fine.grid, {}, options);
  EXPECT_TRUE(own.same_voxels);
  EXPECT_TRUE(offset_in(fine.grid, own.grid).has_value());
  const Vec3 middle = fine.grid.to_world * Vec3(15, 15, 15);
  const auto spacing_for = [&](double radius) {
    const Centreline line{"cystic artery", {middle, middle + Vec3(1e-3, 0, 0)}, {radius, radius}};
    return choose_working_grid(fine, fine.grid, {line}, options).grid.spacing().maxCoeff();
  };
  EXPECT_NEAR(spacing_for(0.6e-3), 1.2e-3 / 2.2, 1e-9);
  EXPECT_NEAR(spacing_for(0.2e-3), 0.4e-3, 1e-9);
  EXPECT_NEAR(spacing_for(2e-3), 0.92e-3, 1e-9);
}

TEST(WorkingGrid, HoldsNoMoreThan80MillionVoxelsWhateverAsksForThem) {
  WorkLabels labels;  // 300 mm wide, on few voxels
  labels.grid.size = {100, 100, 100};
  labels.grid.to_world = Eigen::Affine3d(Eigen::Scaling(3e-3));
  labels.voxels.assign(labels.grid.count(), static_cast<std::uint8_t>(label_of(Structure::liver)));
  const auto of_ct = [&](const Vec3& spacing, double asked, const std::vector<Centreline>& lines) {
    VoxelGrid ct;
    for (std::size_t d = 0; d < 3; ++d)
      ct.size[d] = static_cast<std::size_t>(std::lround(0.3 / spacing[static_cast<Eigen::Index>(d)]));
    ct.to_world = Eigen::Translation3d(spacing / 2 - Vec3::Constant(1.5e-3)) * Eigen::Scaling(spacing);
    CompletionOptions options;
    options.spacing = asked;
    return choose_working_grid(labels, ct, lines, options);
  };
  const auto expect_capped = [](const WorkingGrid& chosen, const std::string& why, const std::string& spacing) {
    EXPECT_LE(chosen.grid.count(), 80'000'000u) << why;
    EXPECT_GT(chosen.grid.count(), 78'000'000u) << why;
    EXPECT_FALSE(chosen.same_voxels);
    EXPECT_NEAR(chosen.grid.spacing()[0] * static_cast<double>(chosen.grid.size[0]), 0.3, 1e-3) << why;
    const std::string told = "(" + why + ", but not more than 80 million voxels)";
    EXPECT_NE(chosen.detail.find(told), std::string::npos) << chosen.detail;
    EXPECT_NE(chosen.warning.find("mm, not of " + spacing + " mm " + told), std::string::npos) << chosen.warning;
  };
  expect_capped(of_ct({0.8e-3, 0.8e-3, 5e-3}, 0.3e-3, {}), "as asked for", "0.3");
  expect_capped(of_ct({0.5e-3, 0.5e-3, 0.5e-3}, 0.7e-3, {}), "the CT's own voxels", "0.5");
  const Centreline artery{"cystic artery", {{0.1, 0.1, 0.1}, {0.12, 0.1, 0.1}}, {0.5e-3, 0.5e-3}};
  expect_capped(of_ct({0.8e-3, 0.8e-3, 5e-3}, 0.7e-3, {artery}), "for a tube that is 1 mm wide", "0.455");
  const WorkingGrid fits = of_ct({0.8e-3, 0.8e-3, 5e-3}, 0.7e-3, {});
  EXPECT_EQ(fits.warning, "");
  EXPECT_NEAR(fits.grid.spacing()[0], 0.7e-3, 1e-12);
  const WorkingGrid own = of_ct({0.699e-3, 0.699e-3, 0.699e-3}, 0.7e-3, {artery});
  EXPECT_LT(own.grid.spacing().maxCoeff(), 0.699e-3) << "finer than the CT's as far as it goes";
  EXPECT_NE(own.warning, "");
}

TEST(WorkingGrid, CtKeepsItsValuesBetweenAndBeyondVoxelCentres) {
  CtImage ct;
  ct.grid = test::oblique_grid({9, 8, 7}, {1e-3, 1e-3, 3e-3});
  for (std::size_t k = 0; k < 7; ++k)
    for (std::size_t j = 0; j < 8; ++j)
      for (std::size_t i = 0; i < 9; ++i)
        ct.hounsfield.push_back(static_cast<std::int16_t>(100 * static_cast<int>(i) - 40 * static_cast<int>(j) +
                                                          300 * static_cast<int>(k)));
  VoxelGrid grid;
  grid.size = {18, 16, 42};
  grid.to_world =
      ct.grid.to_world * Eigen::Translation3d(-0.25, -0.25, -0.5 + 1.0 / 12) * Eigen::Scaling(0.5, 0.5, 1.0 / 6);
  Progress progress;
  const CtImage out = resample_ct(ct, grid, progress);
  std::size_t v = 0;
  for (std::size_t k = 0; k < 42; ++k)
    for (std::size_t j = 0; j < 16; ++j)
      for (std::size_t i = 0; i < 18; ++i, ++v) {
        const Vec3 at(std::clamp(-0.25 + 0.5 * static_cast<double>(i), 0.0, 8.0),
                      std::clamp(-0.25 + 0.5 * static_cast<double>(j), 0.0, 7.0),
                      std::clamp(-0.5 + 1.0 / 12 + static_cast<double>(k) / 6, 0.0, 6.0));
        ASSERT_NEAR(out.hounsfield[v], 100 * at[0] - 40 * at[1] + 300 * at[2], 0.51);
      }
}

}  // namespace
}  // namespace calot
