#include "calot/patient/label_field.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/parallel.h"

namespace calot {
namespace {

constexpr std::uint32_t no_slot = 0xffffffffu;
constexpr std::size_t padding =
    3;  // voxels of outside around everything: the surface must close, and smoothing reaches 2

}  // namespace

LabelField::LabelField(const LabelMap& map, const std::vector<Label>& labels, double sigma)
    : labels_(labels), spacing_(map.grid.spacing()), bias_(labels.size() + 1, 0.0f) {
  if (labels.empty() || labels.size() > 200) throw InputError("labels", "choose between 1 and 200 labels");
  if (!(sigma >= 0 && sigma <= 2)) throw InputError("smoothing", "isn't in 0 … 2 voxels");
  crop(map);
  clean();
  smooth(sigma);
}

void LabelField::crop(const LabelMap& map) {
  std::vector<std::uint8_t> region_of(std::size_t{1} << 16, 0);
  for (std::size_t l = 0; l < labels_.size(); ++l) region_of[labels_[l]] = static_cast<std::uint8_t>(l + 1);
  const auto& full = map.grid.size;
  std::array<std::size_t, 3> first = full, last{};
  for (std::size_t v = 0; v < map.voxels.size(); ++v) {
    if (region_of[map.voxels[v]] == 0) continue;
    const std::array<std::size_t, 3> at{v % full[0], v / full[0] % full[1], v / (full[0] * full[1])};
    for (std::size_t d = 0; d < 3; ++d) {
      first[d] = std::min(first[d], at[d]);
      last[d] = std::max(last[d], at[d] + 1);
    }
  }
  if (last[0] == 0) throw InputError("labels", "have no voxels", "choose labels that the map has");
  for (std::size_t d = 0; d < 3; ++d) size_[d] = last[d] - first[d] + 2 * padding;
  regions_.assign(size_[0] * size_[1] * size_[2], 0);
  for (std::size_t k = first[2]; k < last[2]; ++k)
    for (std::size_t j = first[1]; j < last[1]; ++j)
      for (std::size_t i = first[0]; i < last[0]; ++i)
        regions_[index(i - first[0] + padding, j - first[1] + padding, k - first[2] + padding)] =
            region_of[map.voxels[map.grid.index(i, j, k)]];
  const Vec3 corner(static_cast<double>(first[0]), static_cast<double>(first[1]), static_cast<double>(first[2]));
  to_world_ = map.grid.to_world * Eigen::Translation3d(corner - Vec3::Constant(padding)) *
              Eigen::Scaling(spacing_.cwiseInverse().eval());
}

void LabelField::clean() {
  cleaning_ = keep_largest_parts(regions_, size_, labels_.size());
  for (std::size_t l = 0; l < labels_.size(); ++l)
    if (cleaning_[l].voxels == 0)
      throw InputError("label " + std::to_string(labels_[l]), "has no voxels", "choose labels that the map has");
}

/// Sets slot_ to 0 where not all voxels within `reach` along each axis belong to one region. One axis after the other:
/// a voxel's surroundings are uniform if its row's are, and the rows' beside it, and the slices'.
void LabelField::mark_mixed(std::ptrdiff_t reach) {
  constexpr std::uint8_t mixed = 255;
  std::vector<std::uint8_t> uniform = regions_, before;
  std::ptrdiff_t step = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    before = uniform;
    const auto length = static_cast<std::ptrdiff_t>(size_[axis]);
    parallel_blocks(regions_.size(), std::size_t{1} << 16, [&](std::size_t begin, std::size_t end, std::size_t) {
      for (std::size_t v = begin; v < end; ++v) {
        const auto at = static_cast<std::ptrdiff_t>(v);
        const std::ptrdiff_t place = at / step % length;
        if (place < reach || place + reach >= length) continue;  // padding: outside as far as smoothing reaches
        std::uint8_t differs = 0;
        for (std::ptrdiff_t d = -reach; d <= reach; ++d)
          differs |= static_cast<std::uint8_t>(before[static_cast<std::size_t>(at + d * step)] ^ before[v]);
        if (differs != 0) uniform[v] = mixed;
      }
    });
    step *= length;
  }
  for (std::size_t v = 0; v < regions_.size(); ++v)
    if (uniform[v] == mixed) slot_[v] = 0;
}

void LabelField::smooth(double sigma) {
  constexpr std::ptrdiff_t reach = 2;
  std::array<double, 2 * reach + 1> kernel{};
  double sum = 0;
  for (std::ptrdiff_t d = -reach; d <= reach; ++d) {
    const auto distance = static_cast<double>(d);
    sum += kernel[static_cast<std::size_t>(d + reach)] =
        sigma > 0 ? std::exp(-distance * distance / (2 * sigma * sigma)) : (d == 0 ? 1.0 : 0.0);
  }
  for (double& k : kernel) k /= sum;
  const auto visit = [&](std::size_t v, const auto& take) {  // the 5×5×5 voxels around v
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(size_[0]),
                         slice = row * static_cast<std::ptrdiff_t>(size_[1]);
    for (std::ptrdiff_t c = -reach; c <= reach; ++c)
      for (std::ptrdiff_t b = -reach; b <= reach; ++b)
        for (std::ptrdiff_t a = -reach; a <= reach; ++a)
          if (!take(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(v) + a + row * b + slice * c),
                    kernel[static_cast<std::size_t>(a + reach)] * kernel[static_cast<std::size_t>(b + reach)] *
                        kernel[static_cast<std::size_t>(c + reach)]))
            return;
  };
  slot_.assign(regions_.size(), no_slot);
  mark_mixed(reach);
  std::vector<std::size_t> mixed;
  for (std::size_t v = 0; v < slot_.size(); ++v)
    if (slot_[v] == 0) {
      slot_[v] = static_cast<std::uint32_t>(mixed.size());
      mixed.push_back(v);
    }
  const std::size_t width = labels_.size() + 1;
  values_.assign(mixed.size() * width, 0.0f);
  parallel_blocks(mixed.size(), 4096, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t m = begin; m < end; ++m)
      visit(mixed[m], [&](std::size_t w, double weight) {
        values_[m * width + regions_[w]] += static_cast<float>(weight);
        return true;
      });
  });
}

int LabelField::at(const Vec3& point) const {
  std::array<std::size_t, 3> cell{};
  std::array<float, 3> inside{};
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    const double x = point[axis] / spacing_[axis];
    if (!(x >= 0 && x < static_cast<double>(size_[d] - 1))) return 0;
    cell[d] = static_cast<std::size_t>(x);
    inside[d] = static_cast<float>(x - static_cast<double>(cell[d]));
  }
  const std::size_t base = index(cell[0], cell[1], cell[2]), width = bias_.size();
  std::array<float, 256> total;
  bool mixed = false;
  const std::array<std::size_t, 8> corners{base,
                                           base + 1,
                                           base + size_[0],
                                           base + size_[0] + 1,
                                           base + size_[0] * size_[1],
                                           base + size_[0] * size_[1] + 1,
                                           base + size_[0] * size_[1] + size_[0],
                                           base + size_[0] * size_[1] + size_[0] + 1};
  for (const std::size_t v : corners) mixed = mixed || slot_[v] != no_slot;
  if (!mixed) return regions_[base];
  std::fill_n(total.begin(), width, 0.0f);
  for (std::size_t c = 0; c < 8; ++c) {
    const float weight =
        (c & 1 ? inside[0] : 1 - inside[0]) * (c & 2 ? inside[1] : 1 - inside[1]) * (c & 4 ? inside[2] : 1 - inside[2]);
    const std::uint32_t slot = slot_[corners[c]];
    if (slot == no_slot)
      total[regions_[corners[c]]] += weight;
    else
      for (std::size_t l = 0; l < width; ++l) total[l] += weight * values_[slot * width + l];
  }
  std::size_t best = 0;
  float most = -1;
  for (std::size_t l = 0; l < width; ++l) {
    constexpr float trace = 0.02f;  // a region can't win where none of it is
    if (total[l] >= trace && total[l] + bias_[l] > most) {
      most = total[l] + bias_[l];
      best = l;
    }
  }
  return static_cast<int>(best);
}

}  // namespace calot
