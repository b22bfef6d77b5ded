#include "calot/compliance/fold.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t tile = 256;

// Rows sorted by group, cut into tiles that never straddle two groups.
struct GroupTiles {
  std::vector<std::uint32_t> order;                       // sorted position → row
  struct Range {
    std::size_t begin, end;
    std::uint32_t group;
  };
  std::vector<Range> tiles;
};

GroupTiles tiles_of(const std::vector<std::uint32_t>& group) {
  GroupTiles result;
  result.order.resize(group.size());
  std::iota(result.order.begin(), result.order.end(), 0u);
  std::stable_sort(result.order.begin(), result.order.end(), [&](std::uint32_t a, std::uint32_t b) { return group[a] < group[b]; });
  for (std::size_t begin = 0; begin < group.size();) {
    std::size_t end = begin;
    while (end < group.size() && end - begin < tile && group[result.order[end]] == group[result.order[begin]]) ++end;
    result.tiles.push_back({begin, end, group[result.order[begin]]});
    begin = end;
  }
  return result;
}

// Rows of the correction's columns in sorted order: F = C0_:T, |order|×|T|.
MatrixXd sorted_columns(const DenseBase& base, Rows rows, const std::vector<std::uint32_t>& order) {
  MatrixXd f(static_cast<Index>(order.size()), static_cast<Index>(rows.size()));
  parallel_blocks(rows.size(), 8, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t k = begin; k < end; ++k) {
      const double* from = base.column(rows[k]);
      double* to = f.col(static_cast<Index>(k)).data();
      for (std::size_t i = 0; i < order.size(); ++i) to[i] = from[order[i]];
    }
  });
  return f;
}

}  // namespace

std::unique_ptr<DenseBase> fold_dense(const DenseBase& base, const Correction& correction, const std::vector<std::uint32_t>& group,
                                      Buffer into) {
  blas::use_one_thread();
  const std::size_t n = base.size(), t = correction.rows().size();
  if (into.size() != n * n) into = Buffer(n * n);
  const GroupTiles sorted = tiles_of(group);
  const MatrixXd f = sorted_columns(base, correction.rows(), sorted.order);
  MatrixXd fm(static_cast<Index>(n), static_cast<Index>(t));
  parallel_blocks(n, tile, [&](std::size_t begin, std::size_t end, std::size_t) {
    blas::gemm('N', 'N', end - begin, t, t, 1, f.data() + begin, n, correction.core().data(), t, 0, fm.data() + begin, n);
  });
  const std::size_t tiles = sorted.tiles.size();
  double* out = into.data();
  parallel_for(tiles * (tiles + 1) / 2, [&](std::size_t index) {
    std::size_t i = 0, j = index;
    for (; j > i; ++i) j -= i + 1;
    const GroupTiles::Range a = sorted.tiles[i], b = sorted.tiles[j];
    const std::size_t height = a.end - a.begin, width = b.end - b.begin;
    const bool joined = a.group == b.group && a.group != no_group;
    thread_local std::vector<double> sum;
    sum.assign(height * width, 0.0);
    if (joined) {
      for (std::size_t c = 0; c < width; ++c) {
        const double* from = base.column(sorted.order[b.begin + c]);
        for (std::size_t r = 0; r < height; ++r) sum[c * height + r] = from[sorted.order[a.begin + r]];
      }
      blas::gemm('N', 'T', height, width, t, 1, fm.data() + a.begin, n, f.data() + b.begin, n, 1, sum.data(), height);
    }
    for (std::size_t c = 0; c < width; ++c) {
      double* to = out + std::size_t{sorted.order[b.begin + c]} * n;
      // On the diagonal the lower half serves both, so that the result stays exactly symmetric.
      for (std::size_t r = i == j ? c : 0; r < height; ++r) to[sorted.order[a.begin + r]] = sum[c * height + r];
    }
    for (std::size_t r = 0; r < height; ++r) {
      double* to = out + std::size_t{sorted.order[a.begin + r]} * n;
      for (std::size_t c = 0; c < (i == j ? r : width); ++c) to[sorted.order[b.begin + c]] = sum[c * height + r];
    }
  });
  return std::make_unique<DenseBase>(std::move(into), n);
}

}  // namespace calot
