#include "calot/patient/body_scan.h"

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"

namespace calot::detail {
namespace {

constexpr double mm = 1e-3;
constexpr double tissue_hu = -300;  // above: body; below: air
constexpr double bone_hu = 220;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

BodyScan::BodyScan(const CompletedAnatomy& anatomy) {
  Eigen::AlignedBox3d box;
  const auto& n = anatomy.ct.grid.size;
  for (int corner = 0; corner < 8; ++corner)
    box.extend(anatomy.ct.grid.to_world * Vec3((corner & 1) != 0 ? static_cast<double>(n[0] - 1) : 0.0,
                                               (corner & 2) != 0 ? static_cast<double>(n[1] - 1) : 0.0,
                                               (corner & 4) != 0 ? static_cast<double>(n[2] - 1) : 0.0));
  origin = box.min();
  for (std::size_t d = 0; d < 3; ++d)
    size[d] = 1 + static_cast<std::size_t>(box.sizes()[static_cast<Eigen::Index>(d)] / cell);
  kind.assign(size[0] * size[1] * size[2], outside_field);
  hounsfield.assign(kind.size(), 0);
  organ.assign(kind.size(), 0);
  sample(anatomy);
  flood();
}

void BodyScan::sample(const CompletedAnatomy& anatomy) {
  const Eigen::Affine3d to_voxel = anatomy.ct.grid.to_world.inverse();
  const auto& n = anatomy.ct.grid.size;
  parallel_for(size[2], [&](std::size_t k) {
    for (std::size_t j = 0; j < size[1]; ++j)
      for (std::size_t i = 0; i < size[0]; ++i) {
        const Vec3 voxel = to_voxel * Vec3(at(0, i), at(1, j), at(2, k));
        std::array<std::size_t, 3> v{};
        bool in_field = true;
        for (std::size_t d = 0; d < 3 && in_field; ++d) {
          const double rounded = std::round(voxel[static_cast<Eigen::Index>(d)]);
          in_field = rounded >= 0 && rounded < static_cast<double>(n[d]);
          if (in_field) v[d] = static_cast<std::size_t>(rounded);
        }
        if (!in_field) continue;
        const std::size_t source = anatomy.ct.grid.index(v[0], v[1], v[2]), target = index(i, j, k);
        hounsfield[target] = anatomy.ct.hounsfield[source];
        kind[target] = hounsfield[target] > tissue_hu ? tissue : air;
        const auto label = static_cast<Structure>(anatomy.labels.voxels[source]);
        organ[target] = label != Structure::none && label != Structure::hepatocystic_fat ? 1 : 0;
      }
  });
}

/// Turns the tissue that hangs together with the organs into body.
void BodyScan::flood() {
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t c) {
    if (kind[c] != tissue) return;
    kind[c] = body;
    open.push_back(c);
  };
  for (std::size_t c = 0; c < kind.size(); ++c)
    if (organ[c] != 0) reach(c);
  const std::array<std::size_t, 3> step{1, size[0], size[0] * size[1]};
  while (!open.empty()) {
    const std::size_t c = open.back();
    open.pop_back();
    const std::array<std::size_t, 3> place{c % size[0], c / size[0] % size[1], c / (size[0] * size[1])};
    for (std::size_t d = 0; d < 3; ++d) {
      if (place[d] > 0) reach(c - step[d]);
      if (place[d] + 1 < size[d]) reach(c + step[d]);
    }
  }
}

/// Whether a border column of the field lies outside of the body in this slice: air in most rows. Less is gas in a
/// bowel that the border cuts.
bool BodyScan::mostly_air(std::size_t i, std::size_t k) const {
  std::size_t in_field = 0, in_air = 0;
  for (std::size_t j = 0; j < size[1]; ++j) {
    in_field += kind[index(i, j, k)] != outside_field;
    in_air += kind[index(i, j, k)] == air;
  }
  return 10 * in_air > 7 * in_field && in_field > 0;
}

BodyScan::Sides BodyScan::sides() const {
  std::vector<double> middles, widths, rights;
  for (std::size_t k = 0; k < size[2]; ++k) {
    const bool left_seen = mostly_air(0, k), right_seen = mostly_air(size[0] - 1, k);
    if (!right_seen) continue;
    double left = 1e9, right = -1e9;
    for (std::size_t j = 0; j < size[1]; ++j)
      for (std::size_t i = 0; i < size[0]; ++i) {
        if (kind[index(i, j, k)] != body) continue;
        left = std::min(left, at(0, i));
        right = std::max(right, at(0, i));
      }
    if (right < left) continue;
    rights.push_back(right);
    if (!left_seen) continue;
    middles.push_back((left + right) / 2);
    widths.push_back(right - left);
  }
  Sides result;
  if (4 * middles.size() > size[2]) result.middle = median(middles), result.half_width = median(widths) / 2;
  if (4 * rights.size() > size[2]) result.right = median(rights);
  return result;
}

std::optional<double> BodyScan::spine(const Vec3& bile_duct) const {
  std::vector<double> bone;
  for (std::size_t c = 0; c < kind.size(); ++c) {
    if (hounsfield[c] < bone_hu || kind[c] != body) continue;
    const double x = at(0, c % size[0]) - bile_duct[0], y = at(1, c / size[0] % size[1]) - bile_duct[1];
    if (x > -90 * mm && x < 15 * mm && y > -100 * mm && y < -20 * mm) bone.push_back(at(0, c % size[0]));
  }
  constexpr std::size_t enough = 600;  // 5 mL
  for (int round = 0; round < 4; ++round) {
    if (bone.size() < enough) return {};
    const double middle = median(bone);
    if (round == 3) return middle - 30 * mm > origin[0] ? std::optional(middle) : std::nullopt;
    std::erase_if(bone, [&](double x) { return std::abs(x - middle) > 30 * mm; });
  }
  return {};
}

double BodyScan::organs_right() const {
  std::size_t last = 0;
  for (std::size_t c = 0; c < organ.size(); ++c)
    if (organ[c] != 0) last = std::max(last, c % size[0]);
  return at(0, last);
}

}  // namespace calot::detail
