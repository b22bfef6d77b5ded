#include "tests/patient/synthetic_anatomy.h"

#include <algorithm>
#include <cmath>

namespace calot::test {
namespace {

constexpr double mm = 1e-3;

/// A chain of balls, with the box that holds it.
struct Chain {
  Structure structure;
  std::vector<Vec3> centres;
  std::vector<double> radii;
  Eigen::AlignedBox3d box;

  Chain(Structure s, const std::vector<Vec3>& points, const std::vector<double>& ends) : structure(s) {
    for (std::size_t p = 0; p + 1 < points.size(); ++p)
      for (int step = 0; step <= 60; ++step) {
        const double t = step / 60.0;
        centres.emplace_back((1 - t) * points[p] + t * points[p + 1]);
        radii.push_back((1 - t) * ends[p] + t * ends[p + 1]);
      }
    for (std::size_t c = 0; c < centres.size(); ++c) {
      box.extend(Vec3(centres[c].array() - radii[c]));
      box.extend(Vec3(centres[c].array() + radii[c]));
    }
  }
  [[nodiscard]] bool holds(const Vec3& p) const {
    if (!box.contains(p)) return false;
    for (std::size_t c = 0; c < centres.size(); ++c)
      if ((p - centres[c]).squaredNorm() < radii[c] * radii[c]) return true;
    return false;
  }
};

double ellipse(double x, double a, double y, double b) {
  return std::sqrt(x * x / (a * a) + y * y / (b * b));
}

Centreline line(Structure s, std::vector<Vec3> points, double radius) {
  return {std::string(name_of(s)), points, std::vector<double>(points.size(), radius)};
}

std::vector<Centreline> lines_of(const SyntheticOptions& options) {
  const Vec3 neck = options.duct_length * Vec3(22, 10, 6).normalized();
  std::vector<Centreline> lines{
      line(Structure::cystic_duct, {Vec3::Zero(), 0.5 * neck, neck}, 1.7 * mm),
      line(Structure::common_bile_duct, {Vec3::Zero(), Vec3(-6, -10, -40) * mm, Vec3(-12, -15, -78) * mm}, 3 * mm),
      line(Structure::common_hepatic_duct, {Vec3::Zero(), Vec3(6, -3, 16) * mm, Vec3(14, -6, 36) * mm}, 2.5 * mm)};
  if (options.with_artery) {
    lines.push_back(line(Structure::right_hepatic_artery, {Vec3(-18, -2, 10) * mm, Vec3(28, -8, 30) * mm}, 2 * mm));
    lines.push_back(line(Structure::cystic_artery, {Vec3(6, -5, 20) * mm, Vec3(neck + Vec3(2, 0, 5) * mm)}, 0.8 * mm));
  }
  if (options.reversed_lines)
    for (Centreline& l : lines) std::reverse(l.points.begin(), l.points.end());
  return lines;
}

VoxelGrid grid_of(const SyntheticOptions& options) {
  const Vec3 low = (options.whole_body ? Vec3(-215, -150, -120) : Vec3(-70, -100, -98)) * mm;
  const Vec3 high = (options.whole_body ? Vec3(145, 120, 160) : Vec3(125, 80, 157)) * mm;
  VoxelGrid grid;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity() * options.voxel;
  Vec3 origin = low;
  for (std::size_t d = 0; d < 3; ++d)
    grid.size[d] = static_cast<std::size_t>((high - low)[static_cast<Eigen::Index>(d)] / options.voxel) + 1;
  if (options.flipped)
    for (Eigen::Index d = 0; d < 2; ++d) {
      origin[d] += options.voxel * static_cast<double>(grid.size[static_cast<std::size_t>(d)] - 1);
      axes(d, d) = -options.voxel;
    }
  grid.to_world.linear() = axes;
  grid.to_world.translation() = origin;
  return grid;
}

/// HU of a place that is no organ.
std::int16_t surroundings(const Vec3& p, double more_fat) {
  const double outside = ellipse(p[0] - synthetic_midline, 165 * mm + more_fat, p[1] + 15 * mm, 120 * mm + more_fat);
  if (outside > 1) return -1000;
  if (ellipse(p[0] - synthetic_midline, 22 * mm, p[1] + 75 * mm, 20 * mm) < 1) return 400;  // vertebrae
  const auto within = [&](double layer) {
    return ellipse(p[0] - synthetic_midline, 165 * mm - layer, p[1] + 15 * mm, 120 * mm - layer) < 1;
  };
  if (more_fat > 0 && !within(0)) return -100;
  if (!within(2 * mm)) return 20;
  if (!within(17 * mm)) return -100;
  return within(27 * mm) ? -30 : 55;
}

}  // namespace

CompletedAnatomy synthetic_anatomy(const SyntheticOptions& options) {
  CompletedAnatomy anatomy;
  anatomy.lines = lines_of(options);
  const Vec3 neck = options.duct_length * Vec3(22, 10, 6).normalized();
  std::vector<Chain> chains{Chain(Structure::gallbladder,
                                  {neck + Vec3(4, 2, -1) * mm, Vec3(48, 38, -18) * mm, Vec3(58, 52, -42) * mm},
                                  {4 * mm, 16 * mm, 18 * mm})};
  for (const Centreline& l : anatomy.lines)
    chains.emplace_back(*structure_named(l.name), l.points, std::vector<double>(l.points.size(), l.radii[0]));
  const VoxelGrid grid = grid_of(options);
  anatomy.labels = {grid, std::vector<Label>(grid.count(), 0), structure_names()};
  anatomy.ct = {grid, std::vector<std::int16_t>(grid.count(), 0)};
  for (std::size_t v = 0; v < grid.count(); ++v) {
    const Vec3 p = grid.to_world * Vec3(static_cast<double>(v % grid.size[0]),
                                        static_cast<double>(v / grid.size[0] % grid.size[1]),
                                        static_cast<double>(v / (grid.size[0] * grid.size[1])));
    Structure s = Structure::none;
    const Vec3 in_liver = (p - Vec3(30, -10, 75) * mm).cwiseQuotient(Vec3(78, 70, 60) * mm);
    if (in_liver.norm() < 1) s = Structure::liver;
    for (const Chain& chain : chains)
      if (chain.holds(p)) s = chain.structure;
    if (s == Structure::none && p.norm() < 20 * mm) s = Structure::hepatocystic_fat;
    anatomy.labels.voxels[v] = label_of(s);
    anatomy.ct.hounsfield[v] = s == Structure::none               ? surroundings(p, options.more_fat)
                               : s == Structure::liver            ? std::int16_t{105}
                               : s == Structure::hepatocystic_fat ? std::int16_t{-90}
                                                                  : std::int16_t{10};
  }
  return anatomy;
}

}  // namespace calot::test
