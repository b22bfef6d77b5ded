#include "calot/patient/line_of_label.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "calot/image/distance_map.h"
#include "calot/patient/sweep.h"

namespace calot {
namespace {

constexpr double step_length = 0.5e-3;

/// The label alone, with an empty voxel around it.
struct TubeBox {
  VoxelSize size{};
  Mask mask;
  std::vector<float> depth;  // distance to the nearest outer centre [m]
  Vec3 spacing;
  Eigen::Affine3d to_world;

  [[nodiscard]] Vec3 place(std::size_t v) const {
    return to_world * Vec3(static_cast<double>(v % size[0]), static_cast<double>(v / size[0] % size[1]),
                           static_cast<double>(v / (size[0] * size[1])));
  }
  [[nodiscard]] double depth_at(const Vec3& place) const {  // of the nearest voxel; 0 outside
    const Vec3 at = to_world.inverse() * place;
    std::array<std::size_t, 3> voxel{};
    for (std::size_t d = 0; d < 3; ++d) {
      const double x = std::round(at[static_cast<Eigen::Index>(d)]);
      if (!(x >= 0 && x < static_cast<double>(size[d]))) return 0;
      voxel[d] = static_cast<std::size_t>(x);
    }
    return static_cast<double>(depth[voxel[0] + size[0] * (voxel[1] + size[1] * voxel[2])]);
  }
};

TubeBox tube_box(const WorkLabels& labels, Structure tube) {
  const VoxelBox own = boxes_of(labels.voxels, labels.grid.size)[label_of(tube)];
  TubeBox box;
  for (std::size_t d = 0; d < 3; ++d) box.size[d] = own.size()[d] + 2;
  box.mask.assign(box.size[0] * box.size[1] * box.size[2], 0);
  for (std::size_t k = own.first[2]; k < own.last[2]; ++k)
    for (std::size_t j = own.first[1]; j < own.last[1]; ++j)
      for (std::size_t i = own.first[0]; i < own.last[0]; ++i)
        if (labels.at(labels.grid.index(i, j, k)) == tube)
          box.mask[(i - own.first[0] + 1) +
                   box.size[0] * ((j - own.first[1] + 1) + box.size[1] * (k - own.first[2] + 1))] = 1;
  box.spacing = labels.grid.spacing();
  const Vec3 corner(static_cast<double>(own.first[0]) - 1, static_cast<double>(own.first[1]) - 1,
                    static_cast<double>(own.first[2]) - 1);
  box.to_world = labels.grid.to_world * Eigen::Translation3d(corner);
  box.depth = distance_to_unset(box.mask, box.size, box.spacing);
  return box;
}

/// Cheapest ways within the label from one voxel; a step costs its length times `price` of where it leads.
struct Ways {
  std::vector<float> cost;
  std::vector<std::uint32_t> from;
};

template <class Price>
Ways ways_from(const TubeBox& box, std::size_t first, const Price& price) {
  Ways ways{std::vector<float>(box.mask.size(), std::numeric_limits<float>::infinity()),
            std::vector<std::uint32_t>(box.mask.size(), 0)};
  using Entry = std::pair<float, std::size_t>;  // ties go by number: the same way every time
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  ways.cost[first] = 0;
  ways.from[first] = static_cast<std::uint32_t>(first);
  open.emplace(0.0f, first);
  const auto row = static_cast<std::ptrdiff_t>(box.size[0]), slice = row * static_cast<std::ptrdiff_t>(box.size[1]);
  while (!open.empty()) {
    const auto [cost, v] = open.top();
    open.pop();
    if (cost > ways.cost[v]) continue;
    for (std::ptrdiff_t c = -1; c <= 1; ++c)
      for (std::ptrdiff_t b = -1; b <= 1; ++b)
        for (std::ptrdiff_t a = -1; a <= 1; ++a) {
          const auto w = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(v) + a + row * b + slice * c);
          if (box.mask[w] == 0) continue;
          const Vec3 apart = Vec3(static_cast<double>(a), static_cast<double>(b), static_cast<double>(c));
          const float next = cost + static_cast<float>(apart.cwiseProduct(box.spacing).norm() * price(w));
          if (next >= ways.cost[w]) continue;
          ways.cost[w] = next;
          ways.from[w] = static_cast<std::uint32_t>(v);
          open.emplace(next, w);
        }
  }
  return ways;
}

std::size_t farthest(const Ways& ways) {
  std::size_t best = 0;
  float most = -1;
  for (std::size_t v = 0; v < ways.cost.size(); ++v)
    if (ways.cost[v] < std::numeric_limits<float>::infinity() && ways.cost[v] > most) {
      most = ways.cost[v];
      best = v;
    }
  return best;
}

/// From one far end to the other through the middle.
Curve middle_path(const TubeBox& box) {
  const auto first = static_cast<std::size_t>(std::max_element(box.depth.begin(), box.depth.end()) - box.depth.begin());
  const double deepest = static_cast<double>(box.depth[first]);
  const auto plain = [](std::size_t) { return 1.0; };
  const std::size_t a = farthest(ways_from(box, first, plain)), b = farthest(ways_from(box, a, plain));
  const Ways ways = ways_from(box, a, [&](std::size_t v) {
    const double share = deepest / static_cast<double>(box.depth[v]);
    return share * share * share;
  });
  Curve path{box.place(b)};
  for (std::size_t v = b; v != a;) path.push_back(box.place(v = ways.from[v]));
  if (path.size() < 2) path.push_back(path.front());
  return path;
}

/// Takes the last bit, which turns to the end's far corner, away and goes on straight to the end of the label.
void straighten_end(Curve& line, const TubeBox& box, double radius) {
  const auto cut = static_cast<std::size_t>(std::ceil(1.5 * radius / step_length));
  if (line.size() <= 3 * cut + 3) return;
  line.resize(line.size() - cut);
  const Vec3 direction = (line.back() - line[line.size() - 1 - 2 * cut]).normalized();
  while (box.depth_at(line.back() + step_length * direction) > 0) line.push_back(line.back() + step_length * direction);
}

void smooth(Curve& line, int passes) {
  for (int pass = 0; pass < passes; ++pass) {
    Curve next = line;
    for (std::size_t p = 1; p + 1 < line.size(); ++p) next[p] = (line[p - 1] + 2 * line[p] + line[p + 1]) / 4;
    line.swap(next);
  }
}

/// Radii from the depth, smoothed, then scaled to the label's volume.
std::vector<double> radii_along(const Curve& line, const TubeBox& box, double volume) {
  std::vector<double> radii;
  const double half = box.spacing.minCoeff() / 2;
  for (const Vec3& p : line) radii.push_back(std::max(box.depth_at(p) - half, half));
  // A cap's shallow end is no thinner tube: within a radius of the ends the depth a radius inside counts.
  const double widest = *std::max_element(radii.begin(), radii.end());
  const auto cap = std::min(static_cast<std::size_t>(std::ceil(1.2 * widest / step_length)), (radii.size() - 1) / 2);
  const std::size_t reach = 4;
  std::vector<double> even(radii.size());
  for (std::size_t p = 0; p < radii.size(); ++p) {
    const std::size_t middle = std::clamp(p, cap, radii.size() - 1 - cap);
    const std::size_t begin = middle - std::min(middle - cap, reach);
    const std::size_t end = std::min(middle + reach, radii.size() - 1 - cap) + 1;
    for (std::size_t q = begin; q < end; ++q) even[p] += radii[q] / static_cast<double>(end - begin);
  }
  double swept = 0;
  for (std::size_t p = 1; p < line.size(); ++p)
    swept += (line[p] - line[p - 1]).norm() * (even[p] * even[p] + even[p - 1] * even[p - 1]) / 2;
  const double factor = std::clamp(std::sqrt(volume / std::max(M_PI * swept, 1e-18)), 0.7, 1.5);
  for (double& r : even) r *= factor;
  return even;
}

}  // namespace

Centreline line_of_label(const WorkLabels& labels, Structure tube) {
  const TubeBox box = tube_box(labels, tube);
  Curve path = middle_path(box);
  if (path.front() == path.back()) path.back() += Vec3(0, 0, 1e-4);
  const auto voxels = static_cast<double>(std::count(box.mask.begin(), box.mask.end(), 1));
  const double volume = voxels * labels.grid.voxel_volume();
  Curve line = resampled(path, step_length);
  smooth(line, 12);
  const double radius = static_cast<double>(*std::max_element(box.depth.begin(), box.depth.end()));
  straighten_end(line, box, radius);
  std::reverse(line.begin(), line.end());
  straighten_end(line, box, radius);
  smooth(line, 12);
  line = resampled(line, step_length);
  return {std::string(name_of(tube)), line, radii_along(line, box, volume)};
}

}  // namespace calot
