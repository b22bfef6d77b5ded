#include "calot/patient/phantom_paint.h"

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/image/voxel_parts.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

// HU; sources in docs/patient.md.
namespace hu {
constexpr float liver = 47, bile = 3, fat = -90, bed = 20, wall = 42;
constexpr float noise = 11, liver_noise = 13;
}  // namespace hu

Eigen::AlignedBox3d grown(Eigen::AlignedBox3d box, double by) {
  box.min().array() -= by;
  box.max().array() += by;
  return box;
}

/// One slice while it is painted.
struct Slice {
  const VoxelGrid& grid;
  std::size_t k;
  double voxel;
  std::vector<float> hounsfield;
  std::vector<Label> labels;

  /// A body's distances within a window.
  struct Part {
    Window window;
    std::vector<float> distance;
  };
  [[nodiscard]] std::size_t column(const Window& w, std::size_t v) const {
    return w.first[0] + v % w.width() + grid.size[0] * (w.first[1] + v / w.width());
  }
  [[nodiscard]] Part sampled(const SampledField& field) const {
    Part part{window_of(grid, k, field.box()), {}};
    part.distance.resize(part.window.count());
    if (!part.window.empty()) field.fill(grid, k, part.window, part.distance);
    return part;
  }
  /// @param reach  distances beyond it aren't needed
  [[nodiscard]] Part of_balls(const BallChain& balls, const Eigen::AlignedBox3d& box, double reach) const {
    Part part{window_of(grid, k, grown(box, reach)), {}};
    part.distance.assign(part.window.count(), static_cast<float>(reach));
    if (!part.window.empty()) lower_to_distance(balls, grid_of(grid, part.window), k, reach, part.distance);
    return part;
  }
  /// Paints the body over what is there.
  void put(const Part& part, Label label, float with) {
    for (std::size_t v = 0; v < part.distance.size(); ++v) {
      const float d = part.distance[v];
      const float share = std::clamp(0.5f - d / static_cast<float>(voxel), 0.0f, 1.0f);
      if (share <= 0) continue;
      const std::size_t c = column(part.window, v);
      hounsfield[c] += share * (with - hounsfield[c]);
      if (d < 0) labels[c] = label;
    }
  }
};

/// The field's bodies, ready to be painted slice by slice.
class FieldPainter {
 public:
  explicit FieldPainter(const OperatingField& field) : field_(field) {
    for (const FieldTube& tube : field.tubes) {
      chains_.push_back(balls_along(tube.line.points, tube.line.radii));
      boxes_.push_back(bounds(chains_.back()));
    }
    bile_ = balls_along(field.bile_duct.points, field.bile_duct.radii);
    bile_box_ = bounds(bile_);
    gallbladder_box_ = bounds(field.outside);
  }

  void paint(Slice& slice) const {
    slice.put(slice.sampled(field_.fat), label_of(Structure::hepatocystic_fat), hu::fat);
    const double reach = field_.bed_thickness + 2 * slice.voxel;
    if (field_.facts.wall_thickness > 0) inflame(slice);
    const Slice::Part gallbladder = slice.of_balls(field_.outside, gallbladder_box_, reach);
    paint_liver(slice, gallbladder);
    for (std::size_t t = 0; t < field_.tubes.size(); ++t) {
      const FieldTube& tube = field_.tubes[t];
      if (tube.structure == Structure::cystic_duct && field_.facts.wall_thickness > 0)
        slice.put(gallbladder, label_of(Structure::gallbladder_wall), hu::wall);
      slice.put(slice.of_balls(chains_[t], boxes_[t], slice.voxel), label_of(tube.structure),
                static_cast<float>(tube.hounsfield));
    }
    slice.put(slice.of_balls(field_.lumen, gallbladder_box_, slice.voxel), label_of(Structure::gallbladder), hu::bile);
    slice.put(slice.of_balls(bile_, bile_box_, slice.voxel), label_of(Structure::common_bile_duct), hu::bile);
    divide_bile_duct(slice);
  }

 private:
  /// Liver and bed share what is liver without the fossa: the bed is as far from the gallbladder as it is thick.
  void paint_liver(Slice& slice, const Slice::Part& gallbladder) const {
    Slice::Part liver = slice.sampled(field_.liver.field);
    if (liver.window.empty()) return;
    const auto thickness = static_cast<float>(field_.bed_thickness);
    Slice::Part bed = gallbladder;
    const Window &l = liver.window, &g = gallbladder.window;
    for (std::size_t v = 0; v < bed.distance.size(); ++v) {
      const std::size_t i = g.first[0] + v % g.width(), j = g.first[1] + v / g.width();
      const bool both = i >= l.first[0] && i < l.last[0] && j >= l.first[1] && j < l.last[1];
      float& d = bed.distance[v];
      if (!both) {
        d = static_cast<float>(slice.voxel);
        continue;
      }
      float& liver_distance = liver.distance[i - l.first[0] + l.width() * (j - l.first[1])];
      const float from_gallbladder = d;
      d = std::max(liver_distance, from_gallbladder - thickness);
      liver_distance = std::max(liver_distance, thickness - from_gallbladder);
    }
    slice.put(liver, label_of(Structure::liver), hu::liver);
    slice.put(bed, label_of(Structure::gallbladder_bed), hu::bed);
  }

  void divide_bile_duct(Slice& slice) const {
    const Window w = window_of(slice.grid, slice.k, grown(bile_box_, slice.voxel));
    for (std::size_t v = 0; v < w.count(); ++v) {
      Label& label = slice.labels[slice.column(w, v)];
      if (label != label_of(Structure::common_bile_duct)) continue;
      const Vec3 p =
          slice.grid.to_world * Vec3(static_cast<double>(w.first[0] + v % w.width()),
                                     static_cast<double>(w.first[1] + v / w.width()), static_cast<double>(slice.k));
      if ((p - field_.mouth).dot(field_.junction_direction) < 0) label = label_of(Structure::common_hepatic_duct);
    }
  }

  /// Oedema: fat near an inflamed gallbladder is denser, in strands.
  void inflame(Slice& slice) const {
    const double reach = 18 * mm;
    const Slice::Part near = slice.of_balls(field_.outside, gallbladder_box_, reach);
    for (std::size_t v = 0; v < near.distance.size(); ++v) {
      float& value = slice.hounsfield[slice.column(near.window, v)];
      if (value > -60 || value < -130 || near.distance[v] >= static_cast<float>(reach)) continue;
      const Vec3 p = slice.grid.to_world * Vec3(static_cast<double>(near.window.first[0] + v % near.window.width()),
                                                static_cast<double>(near.window.first[1] + v / near.window.width()),
                                                static_cast<double>(slice.k));
      const double waves = std::sin(p[0] / (1.9 * mm) + 2 * std::sin(p[2] / (4 * mm))) *
                           std::sin(p[1] / (2.3 * mm) + 2 * std::sin(p[0] / (5 * mm)));
      const double fade = 1 - std::max(near.distance[v], 0.0f) / reach;
      value += static_cast<float>(55 * fade * (0.75 + 0.5 * waves));
    }
  }

  const OperatingField& field_;
  std::vector<BallChain> chains_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  BallChain bile_;
  Eigen::AlignedBox3d bile_box_, gallbladder_box_;
};

void add_noise(const Slice& slice, std::uint64_t seed, std::span<std::int16_t> out) {
  const std::size_t first = slice.k * slice.labels.size();
  for (std::size_t v = 0; v < slice.labels.size(); ++v) {
    Random random(seed ^ scramble(first + v + 1));
    const float noise = slice.labels[v] == label_of(Structure::liver) ? hu::liver_noise : hu::noise;
    const double value = slice.hounsfield[v] + static_cast<double>(noise) * random.quick_normal();
    out[v] = static_cast<std::int16_t>(std::lround(std::clamp(value, -1024.0, 3071.0)));
  }
}

Eigen::AlignedBox3d organs_box(const OperatingField& field) {
  Eigen::AlignedBox3d box = field.liver.field.measure_inside().extent;
  box.extend(bounds(field.outside));
  for (const Centreline& line : field.lines()) box.extend(bounds(balls_along(line.points, line.radii)));
  return box;
}

/// The voxels that have a label, and one more around.
struct LabelBox {
  std::array<std::size_t, 3> first, last;
};

LabelBox labelled(const LabelMap& labels) {
  const auto& n = labels.grid.size;
  LabelBox box{n, {0, 0, 0}};
  for (std::size_t k = 0, v = 0; k < n[2]; ++k)
    for (std::size_t j = 0; j < n[1]; ++j)
      for (std::size_t i = 0; i < n[0]; ++i, ++v) {
        if (labels.voxels[v] == 0) continue;
        const std::array<std::size_t, 3> at{i, j, k};
        for (std::size_t d = 0; d < 3; ++d) {
          box.first[d] = std::min(box.first[d], at[d] > 0 ? at[d] - 1 : 0);
          box.last[d] = std::max(box.last[d], std::min(at[d] + 2, n[d]));
        }
      }
  return box;
}

}  // namespace

VoxelGrid phantom_grid(const PhantomOptions& options, const OperatingField& field, const Abdomen& abdomen) {
  Eigen::AlignedBox3d box = grown(organs_box(field), 20 * mm);
  const Trunk& trunk = abdomen.trunk;
  box.max()[1] = trunk.y + trunk.half_depth + 10 * mm;
  VoxelGrid grid;
  Vec3 spacing, origin;
  if (!options.matrix) {
    spacing = Vec3::Constant(options.voxel);
    for (int d = 0; d < 3; ++d) {  // whole voxels from the origin, so that every seed's grid has the same raster
      const double first = std::floor(box.min()[d] / options.voxel), last = std::ceil(box.max()[d] / options.voxel);
      grid.size[static_cast<std::size_t>(d)] = static_cast<std::size_t>(last - first) + 1;
      origin[d] = first * options.voxel;
    }
  } else {
    grid.size = *options.matrix;
    const Vec3 count(static_cast<double>(grid.size[0]), static_cast<double>(grid.size[1]),
                     static_cast<double>(grid.size[2]));
    const double field_of_view =
        std::ceil(std::max(2 * trunk.half_width / count[0], 2 * trunk.half_depth / count[1]) * count[0] * 1e2 + 1) *
        10 * mm;
    spacing[0] = spacing[1] = field_of_view / count[0];
    spacing[2] = std::max(0.8 * mm, box.sizes()[2] / (count[2] - 1));
    const Vec3 middle(trunk.x, trunk.y, (box.min()[2] + box.max()[2]) / 2);
    origin = middle - spacing.cwiseProduct((count.array() - 1).matrix()) / 2;
  }
  grid.to_world = Eigen::Translation3d(origin) * Eigen::Scaling(spacing);
  return grid;
}

void paint_field(const OperatingField& field, const Abdomen& abdomen, std::uint64_t seed, Phantom& phantom,
                 Progress& progress) {
  const VoxelGrid& grid = phantom.labels.grid;
  const std::size_t count = grid.size[0] * grid.size[1];
  const AbdomenPainter surroundings(abdomen, field.hub, grid);
  const FieldPainter organs(field);
  constexpr std::size_t at_once = 16;
  for (std::size_t first = 0; first < grid.size[2]; first += at_once) {
    progress.at(static_cast<double>(first) / static_cast<double>(grid.size[2]));
    parallel_for(std::min(at_once, grid.size[2] - first), [&](std::size_t s) {
      Slice slice{grid, first + s, std::cbrt(grid.voxel_volume()), std::vector<float>(count),
                  std::vector<Label>(count)};
      surroundings.paint(slice.k, slice.hounsfield);
      organs.paint(slice);
      const auto place = static_cast<std::ptrdiff_t>(slice.k * count);
      std::copy(slice.labels.begin(), slice.labels.end(), phantom.labels.voxels.begin() + place);
      add_noise(slice, seed, std::span(phantom.ct.hounsfield).subspan(slice.k * count, count));
    });
  }
}

void trace_tubes(const OperatingField& field, LabelMap& labels) {
  const VoxelGrid& grid = labels.grid;
  const Eigen::Affine3d to_voxel = grid.to_world.inverse();
  const double voxel = grid.spacing().minCoeff();
  for (const FieldTube& tube : field.tubes) {
    Eigen::Vector3i last = Eigen::Vector3i::Constant(-1);
    const auto set = [&](const Eigen::Vector3i& at) {
      for (int d = 0; d < 3; ++d)
        if (at[d] < 0 || at[d] >= static_cast<int>(grid.size[static_cast<std::size_t>(d)])) return;
      Label& label = labels.voxels[grid.index(static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]),
                                              static_cast<std::size_t>(at[2]))];
      const bool free = label == 0 || label == label_of(Structure::liver) ||
                        label == label_of(Structure::hepatocystic_fat) || label == label_of(Structure::gallbladder_bed);
      if (free) label = label_of(tube.structure);
    };
    for (const Vec3& p : resampled(tube.line.points, 0.1 * voxel)) {
      const Eigen::Vector3i at = (to_voxel * p).array().round().matrix().cast<int>();
      if (last[0] < 0) last = at;
      for (int d = 0; d < 3; ++d) {  // one axis after the other, so that voxels share faces
        last[d] = at[d];
        set(last);
      }
    }
  }
}

void clean_labels(LabelMap& labels) {
  const LabelBox box = labelled(labels);
  std::array<std::size_t, 3> size{};
  for (std::size_t d = 0; d < 3; ++d) size[d] = box.last[d] - box.first[d];
  const auto empty = static_cast<std::uint8_t>(all_structures().size() + 1);  // no label counts as a region here
  std::vector<std::uint8_t> regions;
  regions.reserve(size[0] * size[1] * size[2]);
  const auto each = [&](const auto& visit) {
    for (std::size_t k = box.first[2]; k < box.last[2]; ++k)
      for (std::size_t j = box.first[1]; j < box.last[1]; ++j)
        for (std::size_t i = box.first[0]; i < box.last[0]; ++i) visit(labels.voxels[labels.grid.index(i, j, k)]);
  };
  each([&](Label label) { regions.push_back(label == 0 ? empty : static_cast<std::uint8_t>(label)); });
  keep_largest_parts(regions, size, empty);
  auto region = regions.begin();
  each([&](Label& label) {
    label = *region == empty ? Label{0} : Label{*region};
    ++region;
  });
}

}  // namespace calot
