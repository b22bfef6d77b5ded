#include "calot/patient/tissue_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calot/base/parallel.h"
#include "calot/image/distance_map.h"
#include "calot/image/morphology.h"
#include "calot/patient/tube_line.h"

namespace calot {
namespace {

// Surfaces less than this share of a voxel apart touch.
constexpr double touching_share = 0.75;

bool is_sac(Structure s) {
  return s == Structure::gallbladder || s == Structure::gallbladder_wall;
}

VoxelSize voxels_in(double reach, const Vec3& spacing) {
  VoxelSize n{};
  for (std::size_t d = 0; d < 3; ++d)
    n[d] = 1 + static_cast<std::size_t>(std::ceil(reach / spacing[static_cast<Eigen::Index>(d)]));
  return n;
}

/// CT averaged over the up to 27 voxels around that have no label, for voxels without one; the CT itself elsewhere.
std::vector<float> calm_ct(const WorkLabels& labels, const CtImage& ct, const VoxelBox& box) {
  const VoxelSize n = box.size();
  const VoxelSize& whole = labels.grid.size;
  std::vector<float> calm(box.count());
  parallel_for(n[2], [&](std::size_t c) {
    for (std::size_t b = 0; b < n[1]; ++b)
      for (std::size_t a = 0; a < n[0]; ++a) {
        const std::size_t i = box.first[0] + a, j = box.first[1] + b, k = box.first[2] + c;
        const std::size_t v = labels.grid.index(i, j, k);
        float& out = calm[a + n[0] * (b + n[1] * c)];
        out = static_cast<float>(ct.hounsfield[v]);
        if (labels.voxels[v] != 0) continue;
        float sum = 0, count = 0;
        for (std::size_t z = k - (k > 0); z <= std::min(k + 1, whole[2] - 1); ++z)
          for (std::size_t y = j - (j > 0); y <= std::min(j + 1, whole[1] - 1); ++y)
            for (std::size_t x = i - (i > 0); x <= std::min(i + 1, whole[0] - 1); ++x) {
              const std::size_t w = labels.grid.index(x, y, z);
              if (labels.voxels[w] != 0) continue;
              sum += static_cast<float>(ct.hounsfield[w]);
              ++count;
            }
        out = sum / count;
      }
  });
  return calm;
}

bool is_fat(float hu, const CompletionOptions& o) {
  return static_cast<double>(hu) >= o.fat_low && static_cast<double>(hu) <= o.fat_high;
}

bool is_connective(float hu, const CompletionOptions& o) {
  return static_cast<double>(hu) >= o.connective_low && static_cast<double>(hu) <= o.connective_high;
}

/// Gallbladder and liver around the gap between them.
struct OrganGap {
  VoxelBox box;
  VoxelSize size{};
  Mask sac, liver, bed;
  std::vector<float> to_sac, to_liver;  // from outside, to the surface (half a voxel before the first centre) [m]
  std::vector<float> in_sac, in_liver;  // from inside, likewise
};

OrganGap gap_between_organs(const WorkLabels& labels, const CompletionOptions& options) {
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  const Vec3 spacing = labels.grid.spacing();
  const double reach = std::max(options.bed_reach, options.bed_thickness);
  OrganGap gap;
  gap.box = padded(joined(boxes[label_of(Structure::gallbladder)], boxes[label_of(Structure::gallbladder_wall)]),
                   voxels_in(reach, spacing), labels.grid.size);
  gap.size = gap.box.size();
  const auto cut = [&](const auto& test) {
    return cut_out(labels.voxels, labels.grid.size, gap.box,
                   [&](std::uint8_t l) { return test(static_cast<Structure>(l)); });
  };
  gap.sac = cut(is_sac);
  gap.liver = cut([](Structure s) { return s == Structure::liver; });
  gap.bed = cut([](Structure s) { return s == Structure::gallbladder_bed; });
  const float half = static_cast<float>(spacing.mean() / 2);
  const auto to_surface = [&](std::vector<float> d) {
    for (float& value : d) value = std::max(0.0f, value - half);
    return d;
  };
  gap.to_sac = to_surface(distance_to_set(gap.sac, gap.size, spacing));
  gap.to_liver = to_surface(distance_to_set(gap.liver, gap.size, spacing));
  gap.in_sac = to_surface(distance_to_unset(gap.sac, gap.size, spacing));
  gap.in_liver = to_surface(distance_to_unset(gap.liver, gap.size, spacing));
  return gap;
}

/// Direction in which a distance grows.
Vec3 uphill(const std::vector<float>& d, const VoxelSize& n, std::size_t v) {
  const VoxelSize at{v % n[0], v / n[0] % n[1], v / (n[0] * n[1])}, stride{1, n[0], n[0] * n[1]};
  Vec3 slope = Vec3::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t low = at[a] > 0 ? v - stride[a] : v, high = at[a] + 1 < n[a] ? v + stride[a] : v;
    slope[static_cast<Eigen::Index>(a)] = static_cast<double>(d[high] - d[low]);
  }
  const double size = slope.norm();
  return size > 0 ? Vec3(slope / size) : slope;
}

bool lies_between(const OrganGap& gap, std::size_t b, double reach) {
  if (static_cast<double>(gap.to_sac[b] + gap.to_liver[b]) > reach) return false;
  return uphill(gap.to_sac, gap.size, b).dot(uphill(gap.to_liver, gap.size, b)) < -0.8;
}

/// Where the two touch: twice the depth below the surface of the one, as seen from the other; empty elsewhere.
std::optional<double> contact_depth(const OrganGap& gap, std::size_t b, double touching) {
  const bool sac = gap.sac[b] != 0;
  if (!sac && gap.liver[b] == 0) return {};
  const auto depth = static_cast<double>(sac ? gap.in_sac[b] : gap.in_liver[b]);
  const auto across = static_cast<double>(sac ? gap.to_liver[b] : gap.to_sac[b]);
  if (across - depth > touching) return {};
  return across + depth;
}

/// How much of the layer the gallbladder gives: half, a quarter or nothing, so that it loses at most 2 % of its volume.
double share_of_sac(const OrganGap& gap, double thickness, double touching) {
  const auto volume = static_cast<double>(std::count(gap.sac.begin(), gap.sac.end(), 1));
  for (const double share : {0.5, 0.25}) {
    double lost = 0;
    for (std::size_t b = 0; b < gap.sac.size(); ++b)
      if (gap.sac[b] != 0)
        if (const auto depth = contact_depth(gap, b, touching); depth && *depth <= 2 * share * thickness) ++lost;
    if (lost <= 0.02 * volume) return share;
  }
  return 0;
}

enum BedVoxel : std::uint8_t { not_bed = 0, found = 1, carved = 2 };

/// What becomes bed: gaps, and, where there was no bed, the layer where the organs touch. In one part.
std::vector<std::uint8_t> new_bed(const WorkLabels& labels, const CtImage& ct, const OrganGap& gap, bool had_bed,
                                  double share, const CompletionOptions& options) {
  const std::vector<float> calm = calm_ct(labels, ct, gap.box);
  const Vec3 spacing = labels.grid.spacing();
  const Mask near_bed = had_bed ? closed(gap.bed, gap.size, spacing, options.closing) : Mask{};
  std::vector<std::uint8_t> bed(gap.box.count(), not_bed);
  for_voxels(gap.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
    if (labels.at(v) == Structure::none) {
      const bool soft = is_fat(calm[b], options) || is_connective(calm[b], options);
      if ((had_bed ? near_bed[b] != 0 : soft) && lies_between(gap, b, options.bed_reach)) bed[b] = found;
    } else if (!had_bed) {
      const std::optional<double> depth = contact_depth(gap, b, touching_share * spacing.maxCoeff());
      const double thickness = (gap.sac[b] != 0 ? share : 1 - share) * options.bed_thickness;
      if (depth && *depth <= 2 * thickness) bed[b] = carved;
    }
  });
  if (had_bed) return bed;
  Mask any(bed.size());
  for (std::size_t b = 0; b < bed.size(); ++b) any[b] = bed[b] != not_bed ? 1 : 0;
  keep_largest_part(any, gap.size, Joined::by_faces);
  for (std::size_t b = 0; b < bed.size(); ++b)
    if (any[b] == 0) bed[b] = not_bed;
  return bed;
}

}  // namespace

void add_gallbladder_bed(WorkLabels& labels, const CtImage& ct, const CompletionOptions& options,
                         std::vector<CompletionStep>& steps, std::vector<std::string>& warnings) {
  const OrganGap gap = gap_between_organs(labels, options);
  const bool had_bed = std::find(gap.bed.begin(), gap.bed.end(), 1) != gap.bed.end();
  const double share = share_of_sac(gap, options.bed_thickness, touching_share * labels.grid.spacing().maxCoeff());
  const std::vector<std::uint8_t> bed = new_bed(labels, ct, gap, had_bed, share, options);
  LabelEdit edit(labels);
  const auto apply = [&](BedVoxel kind) {
    for_voxels(gap.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
      if (bed[b] == kind) edit.set(v, Structure::gallbladder_bed);
    });
  };
  apply(found);
  edit.report(steps, Structure::gallbladder_bed, had_bed ? "gaps filled" : "found between gallbladder and liver",
              text_of("gaps up to %.3g mm, %.0f … %.0f and %.0f … %.0f HU", 1e3 * options.bed_reach, options.fat_low,
                      options.fat_high, options.connective_low, options.connective_high));
  apply(carved);
  edit.report(steps, Structure::gallbladder_bed, "carved from where gallbladder and liver touch",
              text_of("%.3g mm thick, %.3g mm of it from the gallbladder", 1e3 * options.bed_thickness,
                      1e3 * share * options.bed_thickness));
  edit.report_all(steps, "made room for the gallbladder bed");
  if (labels.count(Structure::gallbladder_bed) == 0)
    warnings.push_back(text_of("no gallbladder bed: nowhere are gallbladder and liver less than %.3g mm apart",
                               1e3 * options.bed_reach));
}

namespace {

const Centreline* line_named(const std::vector<Centreline>& lines, Structure s) {
  for (const Centreline& line : lines)
    if (line.name == name_of(s)) return &line;
  return nullptr;
}

/// The bile duct from the cystic duct's mouth upwards, until it has run 40 mm or comes to the liver.
std::vector<Vec3> hepatic_side(const WorkLabels& labels, const std::vector<Centreline>& lines, const Vec3& mouth) {
  std::vector<Vec3> whole;  // from above downwards
  for (const Structure s : {Structure::common_hepatic_duct, Structure::common_bile_duct})
    if (const Centreline* line = line_named(lines, s))
      whole.insert(whole.end(), line->points.begin(), line->points.end());
  if (whole.empty()) return {};
  const auto nearest = std::min_element(whole.begin(), whole.end(), [&](const Vec3& a, const Vec3& b) {
    return (a - mouth).squaredNorm() < (b - mouth).squaredNorm();
  });
  std::vector<Vec3> side;
  const Eigen::Affine3d to_voxel = labels.grid.to_world.inverse();
  double run = 0;
  for (auto p = nearest;; --p) {
    if (!side.empty()) run += (*p - side.back()).norm();
    const Vec3 at = to_voxel * *p;
    bool liver = run > 40e-3;
    VoxelSize voxel{};
    for (std::size_t d = 0; d < 3; ++d)
      voxel[d] = static_cast<std::size_t>(
          std::clamp(std::round(at[static_cast<Eigen::Index>(d)]), 0.0, static_cast<double>(labels.grid.size[d] - 1)));
    liver = liver || labels.at(labels.grid.index(voxel[0], voxel[1], voxel[2])) == Structure::liver;
    side.push_back(*p);
    if (liver || p == whole.begin()) return side;
  }
}

void add_segment(std::vector<Vec3>& points, const Vec3& a, const Vec3& b, double step) {
  const auto count = static_cast<int>(std::ceil((b - a).norm() / step));
  for (int n = 0; n <= count; ++n)
    points.push_back(count > 0 ? Vec3(a + (b - a) * (static_cast<double>(n) / count)) : a);
}

double length_of(const std::vector<Vec3>& curve) {
  double sum = 0;
  for (std::size_t p = 1; p < curve.size(); ++p) sum += (curve[p] - curve[p - 1]).norm();
  return sum;
}

/// Segments between equal shares of two curves.
void add_ruled(std::vector<Vec3>& points, const std::vector<Vec3>& a, const std::vector<Vec3>& b, double step) {
  const double width =
      std::max((a.front() - b.front()).norm() + (a.back() - b.back()).norm(), length_of(a) + length_of(b));
  const auto count = static_cast<std::size_t>(std::ceil(width / step)) + 1;
  const auto at = [&](const std::vector<Vec3>& curve, std::size_t n) {
    const double x = static_cast<double>(n) / static_cast<double>(count) * static_cast<double>(curve.size() - 1);
    const auto low = std::min(static_cast<std::size_t>(x), curve.size() - 1),
               high = std::min(low + 1, curve.size() - 1);
    return Vec3(curve[low] + (x - static_cast<double>(low)) * (curve[high] - curve[low]));
  };
  for (std::size_t n = 0; n <= count; ++n) add_segment(points, at(a, n), at(b, n), step);
}

Vec3 centre_of(const WorkLabels& labels, std::size_t v) {
  const auto& n = labels.grid.size;
  return labels.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                     static_cast<double>(v / (n[0] * n[1])));
}

/// Calot's triangle in its box.
struct Triangle {
  VoxelBox box;
  VoxelSize size{};
  std::vector<float> from_surface;     // [m]
  std::vector<float> from_structures;  // from duct, artery or gallbladder [m]
};

Triangle triangle_box(const WorkLabels& labels, const std::vector<Vec3>& points, const CompletionOptions& options) {
  const Vec3 spacing = labels.grid.spacing();
  const Eigen::Affine3d to_voxel = labels.grid.to_world.inverse();
  std::vector<std::size_t> voxels;
  VoxelBox own;
  for (const Vec3& p : points) {
    const Vec3 at = to_voxel * p;
    VoxelSize voxel{};
    for (std::size_t d = 0; d < 3; ++d)
      voxel[d] = static_cast<std::size_t>(
          std::clamp(std::round(at[static_cast<Eigen::Index>(d)]), 0.0, static_cast<double>(labels.grid.size[d] - 1)));
    own = joined(own, {voxel, {voxel[0] + 1, voxel[1] + 1, voxel[2] + 1}});
    voxels.push_back(labels.grid.index(voxel[0], voxel[1], voxel[2]));
  }
  Triangle triangle;
  triangle.box = padded(own, voxels_in(options.triangle_reach + options.connective_reach, spacing), labels.grid.size);
  triangle.size = triangle.box.size();
  std::sort(voxels.begin(), voxels.end());
  Mask surface(triangle.box.count());
  for_voxels(triangle.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
    surface[b] = std::binary_search(voxels.begin(), voxels.end(), v) ? 1 : 0;
  });
  triangle.from_surface = distance_to_set(surface, triangle.size, spacing);
  const Mask structures = cut_out(labels.voxels, labels.grid.size, triangle.box, [](std::uint8_t l) {
    return is_tube(static_cast<Structure>(l)) || is_sac(static_cast<Structure>(l));
  });
  triangle.from_structures = distance_to_set(structures, triangle.size, spacing);
  return triangle;
}

/// Voxels of the triangle by their HU.
Mask fat_by_density(const WorkLabels& labels, const CtImage& ct, const Triangle& triangle,
                    const CompletionOptions& options) {
  const std::vector<float> calm = calm_ct(labels, ct, triangle.box);
  const double half = labels.grid.spacing().mean() / 2;
  Mask fat(triangle.box.count());
  for_voxels(triangle.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
    if (labels.at(v) != Structure::none || static_cast<double>(triangle.from_surface[b]) > options.triangle_reach)
      return;
    const bool near = static_cast<double>(triangle.from_structures[b]) - half <= options.connective_reach;
    fat[b] = is_fat(calm[b], options) || (near && is_connective(calm[b], options)) ? 1 : 0;
  });
  return fat;
}

}  // namespace

std::vector<Vec3> triangle_points(const WorkLabels& labels, const std::vector<Centreline>& lines, double step) {
  const Centreline* cystic = line_named(lines, Structure::cystic_duct);
  if (!cystic) return {};
  const std::vector<Vec3>& duct = cystic->points;  // from its mouth to the neck
  const std::vector<Vec3> hepatic = hepatic_side(labels, lines, duct.front());
  if (hepatic.empty()) return {};
  std::vector<Vec3> points;
  add_ruled(points, hepatic, duct, step);
  const auto onto_liver = [&](const Vec3& place) {
    const Gap gap = gap_to(labels, {Structure::liver}, place);
    return gap.found && gap.distance <= 25e-3 ? centre_of(labels, gap.voxel) : place;
  };
  const Vec3 hilum = hepatic.back(), neck = duct.back();
  add_ruled(points, {hilum, neck}, {onto_liver(hilum), onto_liver(neck)}, step);
  return points;
}

void add_triangle_fat(WorkLabels& labels, const CtImage& ct, const std::vector<Centreline>& lines,
                      const CompletionOptions& options, std::vector<CompletionStep>& steps,
                      std::vector<std::string>& warnings) {
  const Vec3 spacing = labels.grid.spacing();
  const std::vector<Vec3> points = triangle_points(labels, lines, spacing.minCoeff());
  if (points.empty()) {
    warnings.emplace_back("no fat added to Calot's triangle: it needs the lines of cystic and bile duct");
    return;
  }
  const Triangle triangle = triangle_box(labels, points, options);
  const bool had_fat = labels.count(Structure::hepatocystic_fat) > 0;
  Mask fat = had_fat ? cut_out(labels.voxels, labels.grid.size, triangle.box,
                               [](std::uint8_t l) { return l == label_of(Structure::hepatocystic_fat); })
                     : fat_by_density(labels, ct, triangle, options);
  if (!had_fat) keep_largest_part(fat, triangle.size, Joined::by_faces);
  const Mask smooth = closed(fat, triangle.size, spacing, std::max(options.closing, 1.01 * spacing.maxCoeff()));
  for (std::size_t b = 0; b < fat.size(); ++b) fat[b] = fat[b] | smooth[b];
  for (const Hole& hole : holes_in(fat, triangle.size))
    if (static_cast<double>(hole.voxels.size()) * labels.grid.voxel_volume() <= options.largest_hole)
      for (const std::size_t b : hole.voxels) fat[b] = 1;
  LabelEdit edit(labels);
  for_voxels(triangle.box, labels.grid.size, [&](std::size_t v, std::size_t b) {
    if (fat[b] != 0 && labels.at(v) == Structure::none) edit.set(v, Structure::hepatocystic_fat);
  });
  edit.report(
      steps, Structure::hepatocystic_fat, had_fat ? "gaps filled" : "found in Calot's triangle",
      text_of("%.0f … %.0f HU within %.3g mm of the triangle, %.0f … %.0f HU within %.3g mm of duct, artery and "
              "gallbladder",
              options.fat_low, options.fat_high, 1e3 * options.triangle_reach, options.connective_low,
              options.connective_high, 1e3 * options.connective_reach));
  if (labels.count(Structure::hepatocystic_fat) == 0)
    warnings.emplace_back("no fat found in Calot's triangle: nothing there has HU of fat; see fat_low and fat_high");
}

}  // namespace calot
