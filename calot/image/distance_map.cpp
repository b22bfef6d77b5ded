#include "calot/image/distance_map.h"

#include <cmath>

#include "calot/base/parallel.h"

namespace calot {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// Squared distances along a row from its voxels that equal `wanted`.
void first_axis(const std::uint8_t* row, std::uint8_t wanted, std::size_t n, double step, float* squared) {
  constexpr std::size_t never = std::numeric_limits<std::size_t>::max();
  std::size_t seen = never;
  for (std::size_t i = 0; i < n; ++i) {
    if (row[i] == wanted) seen = i;
    squared[i] = seen == never ? infinite : static_cast<float>(step * static_cast<double>(i - seen));
  }
  seen = never;
  for (std::size_t i = n; i-- > 0;) {
    if (row[i] == wanted) seen = i;
    if (seen != never) squared[i] = std::min(squared[i], static_cast<float>(step * static_cast<double>(seen - i)));
    squared[i] *= squared[i];
  }
}

/// min over q of f(q) + step² (p − q)², for every p of a line.
class Envelope {
 public:
  explicit Envelope(std::size_t n) : from_(n), begin_(n + 1) {}

  void lower(const float* f, std::size_t n, double step, float* out) {
    const double square = step * step;
    std::size_t parabolas = 0;
    for (std::size_t q = 0; q < n; ++q) {
      if (f[q] == infinite) continue;
      double begins = -1;
      while (parabolas > 0) {
        begins = crossing(f, from_[parabolas - 1], q, square);
        if (begins > begin_[parabolas - 1]) break;
        --parabolas;
      }
      from_[parabolas] = q;
      begin_[parabolas] = parabolas == 0 ? -1 : begins;
      ++parabolas;
    }
    for (std::size_t p = 0, at = 0; p < n; ++p) {
      if (parabolas == 0) {
        out[p] = infinite;
        continue;
      }
      while (at + 1 < parabolas && begin_[at + 1] < static_cast<double>(p)) ++at;
      const double apart = static_cast<double>(p) - static_cast<double>(from_[at]);
      out[p] = static_cast<float>(static_cast<double>(f[from_[at]]) + square * apart * apart);
    }
  }

 private:
  /// Where the parabola of q falls below that of v < q.
  static double crossing(const float* f, std::size_t v, std::size_t q, double square) {
    const auto a = static_cast<double>(v), b = static_cast<double>(q);
    return (static_cast<double>(f[q]) - static_cast<double>(f[v]) + square * (b * b - a * a)) / (2 * square * (b - a));
  }
  std::vector<std::size_t> from_;
  std::vector<double> begin_;
};

/// One axis of a slab of rows: `n` rows of `width` voxels, `stride` apart.
void along_rows(float* slab, std::size_t width, std::size_t n, std::size_t stride, double step) {
  std::vector<float> lines(width * n), out(n);
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t i = 0; i < width; ++i) lines[i * n + p] = slab[p * stride + i];
  Envelope envelope(n);
  for (std::size_t i = 0; i < width; ++i) {
    envelope.lower(&lines[i * n], n, step, out.data());
    std::copy(out.begin(), out.end(), &lines[i * n]);
  }
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t i = 0; i < width; ++i) slab[p * stride + i] = lines[i * n + p];
}

std::vector<float> distance(const Mask& set, std::uint8_t wanted, const VoxelSize& size,
                            const Eigen::Vector3d& spacing) {
  std::vector<float> d(set.size());
  if (set.empty()) return d;
  const std::size_t row = size[0], slice = size[0] * size[1];
  parallel_for(size[2], [&](std::size_t k) {
    for (std::size_t j = 0; j < size[1]; ++j)
      first_axis(&set[k * slice + j * row], wanted, row, spacing[0], &d[k * slice + j * row]);
    along_rows(&d[k * slice], row, size[1], row, spacing[1]);
  });
  parallel_for(size[1], [&](std::size_t j) {
    along_rows(&d[j * row], row, size[2], slice, spacing[2]);
    for (std::size_t k = 0; k < size[2]; ++k)
      for (std::size_t i = 0; i < row; ++i) {
        float& value = d[k * slice + j * row + i];
        value = std::sqrt(value);
      }
  });
  return d;
}

}  // namespace

std::vector<float> distance_to_set(const Mask& set, const VoxelSize& size, const Eigen::Vector3d& spacing) {
  return distance(set, 1, size, spacing);
}

std::vector<float> distance_to_unset(const Mask& set, const VoxelSize& size, const Eigen::Vector3d& spacing) {
  return distance(set, 0, size, spacing);
}

}  // namespace calot
