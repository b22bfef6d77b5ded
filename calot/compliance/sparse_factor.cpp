#include "calot/compliance/sparse_factor.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot {
namespace {

constexpr std::size_t tile = 256;             // rows of a tile of a large front
constexpr std::size_t panel_step = 192;       // columns eliminated at once in a large front
constexpr std::size_t right_hand_sides = 32;  // columns solved together

// The update matrix of a front. Large ones go back to where they came from at once, so that the memory held is that of
// the fronts that are alive.
class UpdateMatrix {
 public:
  void make(std::size_t size) {
    if (size < large)
      small_.assign(size, 0.0);
    else
      fill_buffer(size);
    size_ = size;
  }
  void drop() {
    small_ = {};
    buffer_ = {};
    size_ = 0;
  }
  [[nodiscard]] double* data() { return size_ < large ? small_.data() : buffer_.data(); }

 private:
  void fill_buffer(std::size_t size) {
    buffer_ = Buffer::recycled(size);
    std::fill_n(buffer_.data(), size, 0.0);
  }
  static constexpr std::size_t large = 32768;
  std::size_t size_ = 0;
  std::vector<double> small_;
  Buffer buffer_;
};

// One factorisation in progress: the fronts' update matrices live here until their parent takes them in.
class Multifrontal {
 public:
  Multifrontal(const FactorPattern& pattern, const BlockMatrix& matrix, std::span<const std::uint8_t> active,
               std::span<const std::uint8_t> dead, double* values)
      : pattern_(pattern),
        matrix_(matrix),
        dead_(dead),
        values_(values),
        updates_(pattern.supernodes()),
        children_(pattern.supernodes()) {
    active_of_row_.assign(matrix.rows(), -1);
    for (std::size_t row = 0; row < matrix.rows(); ++row)
      if (active[row]) {
        active_of_row_[row] = static_cast<std::int32_t>(row_of_active_.size());
        row_of_active_.push_back(static_cast<std::uint32_t>(row));
      }
    subtree_flops_.resize(pattern.supernodes());
    first_of_subtree_.resize(pattern.supernodes());
    for (std::size_t s = 0; s < pattern.supernodes(); ++s)
      if (pattern.parent[s] >= 0)
        children_[static_cast<std::size_t>(pattern.parent[s])].push_back(static_cast<std::uint32_t>(s));
    for (std::size_t s = 0; s < pattern.supernodes(); ++s) {
      subtree_flops_[s] += flops_of(s);
      first_of_subtree_[s] = static_cast<std::uint32_t>(s);
      for (const std::uint32_t child : children_[s]) {
        subtree_flops_[s] += subtree_flops_[child];
        first_of_subtree_[s] = std::min(first_of_subtree_[s], first_of_subtree_[child]);
      }
    }
  }

  void run(Progress* progress);

 private:
  [[nodiscard]] std::vector<std::uint32_t> subtrees_within(double flops) const;
  void run_side_by_side(std::vector<std::uint32_t> roots, const Progress* progress);
  // `local` maps a position to its row in the front in hand; entries of other fronts are stale and never read.
  void eliminate(std::size_t s, std::vector<std::uint32_t>& local, bool large);
  void assemble(std::size_t s, const std::vector<std::uint32_t>& local);
  void extend_add(std::size_t s, std::size_t child, const std::vector<std::uint32_t>& local, bool shared_out);
  void factor_small(std::size_t s);
  void factor_large(std::size_t s);
  void check(int info, std::size_t s, std::size_t first_column) const;
  [[nodiscard]] double flops_of(std::size_t s) const {
    const double c = 3.0 * static_cast<double>(pattern_.own(s)), r = 3.0 * static_cast<double>(pattern_.below(s));
    return c * c * c / 3 + r * c * c + r * r * c;
  }

  const FactorPattern& pattern_;
  const BlockMatrix& matrix_;
  std::span<const std::uint8_t> dead_;
  double* values_;
  std::vector<UpdateMatrix> updates_;  // of each supernode, 3·below squared, lower triangle
  std::vector<std::vector<std::uint32_t>> children_;
  std::vector<double> subtree_flops_;            // of each supernode and all below it
  std::vector<std::uint32_t> first_of_subtree_;  // its first supernode; subtrees are contiguous in postorder
  std::vector<std::int32_t> active_of_row_;
  std::vector<std::uint32_t> row_of_active_;
};

void Multifrontal::assemble(std::size_t s, const std::vector<std::uint32_t>& local) {
  const std::size_t ld = 3 * (pattern_.own(s) + pattern_.below(s));
  double* panel = values_ + pattern_.panel_start[s];
  std::fill(panel, panel + ld * 3 * pattern_.own(s), 0.0);
  for (std::uint32_t p = pattern_.super_start[s]; p < pattern_.super_start[s + 1]; ++p) {
    const std::size_t row = row_of_active_[pattern_.perm[p]];
    const std::size_t column = 3 * std::size_t{local[p]};
    if (!dead_.empty() && dead_[row]) {
      for (std::size_t a = 0; a < 3; ++a) panel[(column + a) * ld + column + a] = 1;
      continue;
    }
    for (std::uint32_t k = matrix_.row_start[row]; k < matrix_.row_start[row + 1]; ++k) {
      const std::uint32_t other = matrix_.column[k];
      if (active_of_row_[other] < 0 || (!dead_.empty() && dead_[other])) continue;
      const std::uint32_t q = pattern_.position[static_cast<std::size_t>(active_of_row_[other])];
      if (q < p || (q > p && matrix_.block[k].isZero(0))) continue;
      const std::size_t first = 3 * std::size_t{local[q]};
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          panel[(column + static_cast<std::size_t>(a)) * ld + first + static_cast<std::size_t>(b)] =
              matrix_.block[k](a, b);
    }
  }
}

void Multifrontal::extend_add(std::size_t s, std::size_t child, const std::vector<std::uint32_t>& local,
                              bool shared_out) {
  const std::span<const std::uint32_t> rows = pattern_.rows_of(child);
  double* update = updates_[child].data();
  const std::size_t child_ld = 3 * rows.size(), own = pattern_.own(s);
  const std::size_t panel_ld = 3 * (own + pattern_.below(s)), update_ld = 3 * pattern_.below(s);
  double* panel = values_ + pattern_.panel_start[s];
  double* target_update = updates_[s].data();
  const auto add_columns = [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t j = begin; j < end; ++j) {
      const std::size_t column = local[rows[j]], shift = column < own ? 0 : own;
      for (std::size_t a = 0; a < 3; ++a) {
        const double* from = update + (3 * j + a) * child_ld;
        double* to =
            shift == 0 ? panel + (3 * column + a) * panel_ld : target_update + (3 * (column - own) + a) * update_ld;
        for (std::size_t i = j; i < rows.size(); ++i) {
          double* target = to + 3 * (local[rows[i]] - shift);
          for (std::size_t b = 0; b < 3; ++b) target[b] += from[3 * i + b];
        }
      }
    }
  };
  // Columns of one child go to different columns, so they may be shared out; children follow each other in order.
  if (shared_out)
    parallel_blocks(rows.size(), 16, add_columns);
  else
    add_columns(0, rows.size(), 0);
  updates_[child].drop();
}

void Multifrontal::check(int info, std::size_t s, std::size_t first_column) const {
  if (info == 0) return;
  const std::size_t p = pattern_.super_start[s] + (first_column + static_cast<std::size_t>(info) - 1) / 3;
  throw Unsupported(
      "", "the stiffness is not positive definite at vertex " + std::to_string(row_of_active_[pattern_.perm[p]]),
      "hold every part by at least three vertices, or use a time step > 0");
}

void Multifrontal::factor_small(std::size_t s) {
  const std::size_t c = 3 * pattern_.own(s), r = 3 * pattern_.below(s), ld = c + r;
  double* panel = values_ + pattern_.panel_start[s];
  check(blas::potrf(c, panel, ld), s, 0);
  if (r == 0) return;
  blas::trsm('R', 'T', r, c, 1, panel, ld, panel + c, ld);
  blas::syrk('N', r, c, -1, panel + c, ld, 1, updates_[s].data(), r);
}

void Multifrontal::factor_large(std::size_t s) {
  const std::size_t c = 3 * pattern_.own(s), r = 3 * pattern_.below(s), ld = c + r;
  double* panel = values_ + pattern_.panel_start[s];
  const auto at = [&](std::size_t row, std::size_t column) { return panel + column * ld + row; };
  for (std::size_t k = 0; k < c; k += panel_step) {
    const std::size_t width = std::min(panel_step, c - k), next = k + width;
    check(blas::potrf(width, at(k, k), ld), s, k);
    parallel_blocks(ld - next, tile, [&](std::size_t begin, std::size_t end, std::size_t) {
      blas::trsm('R', 'T', end - begin, width, 1, at(k, k), ld, at(next + begin, k), ld);
    });
    // The panel's later columns; its rows in tiles, each tile the columns up to its own diagonal.
    parallel_blocks(ld - next, tile, [&](std::size_t begin, std::size_t end, std::size_t) {
      const std::size_t columns = std::min(c - next, end);
      blas::gemm('N', 'T', end - begin, columns, width, -1, at(next + begin, k), ld, at(next, k), ld, 1,
                 at(next + begin, next), ld);
    });
  }
  const std::size_t tiles = (r + tile - 1) / tile;
  double* update = updates_[s].data();
  parallel_for(tiles * (tiles + 1) / 2, [&](std::size_t index) {
    std::size_t i = 0, j = index;
    for (; j > i; ++i) j -= i + 1;
    const std::size_t row = i * tile, column = j * tile, rows = std::min(tile, r - row),
                      columns = std::min(tile, r - column);
    blas::gemm('N', 'T', rows, columns, c, -1, at(c + row, 0), ld, at(c + column, 0), ld, 1, update + column * r + row,
               r);
  });
}

void Multifrontal::eliminate(std::size_t s, std::vector<std::uint32_t>& local, bool large) {
  std::uint32_t place = 0;
  for (std::uint32_t p = pattern_.super_start[s]; p < pattern_.super_start[s + 1]; ++p) local[p] = place++;
  for (const std::uint32_t p : pattern_.rows_of(s)) local[p] = place++;
  updates_[s].make(9 * pattern_.below(s) * pattern_.below(s));
  assemble(s, local);
  for (const std::uint32_t child : children_[s]) extend_add(s, child, local, large);
  if (large)
    factor_large(s);
  else
    factor_small(s);
}

// The roots of the largest subtrees that take at most `flops`, ascending.
std::vector<std::uint32_t> Multifrontal::subtrees_within(double flops) const {
  std::vector<std::uint32_t> roots;
  for (std::size_t s = 0; s < pattern_.supernodes(); ++s) {
    const std::int32_t parent = pattern_.parent[s];
    if (subtree_flops_[s] <= flops && (parent < 0 || subtree_flops_[static_cast<std::size_t>(parent)] > flops))
      roots.push_back(static_cast<std::uint32_t>(s));
  }
  return roots;
}

// Whole subtrees side by side, each on one thread.
void Multifrontal::run_side_by_side(std::vector<std::uint32_t> roots, const Progress* progress) {
  std::stable_sort(roots.begin(), roots.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return subtree_flops_[a] > subtree_flops_[b]; });
  parallel_for(roots.size(), [&](std::size_t k) {
    std::vector<std::uint32_t> local(pattern_.vertices());
    for (std::uint32_t s = first_of_subtree_[roots[k]]; s <= roots[k]; ++s) {
      if (progress && progress->stop_requested()) throw Interrupted();
      eliminate(s, local, false);
    }
  });
}

// Small subtrees run side by side, the fronts above them one after another, shared out inside. A small factor starts
// with all of its subtrees; a large one takes them a sixteenth at a time, or too many update matrices would be waiting.
void Multifrontal::run(Progress* progress) {
  const bool large = pattern_.flops > 2e10;
  const std::vector<std::uint32_t> tasks = subtrees_within(pattern_.flops / (large ? 400 : 16));
  const std::vector<std::uint32_t> portions =
      large ? subtrees_within(pattern_.flops / 16) : std::vector<std::uint32_t>{};
  std::vector<std::uint8_t> in_task(pattern_.supernodes(), 0);
  for (const std::uint32_t root : tasks)
    std::fill(in_task.begin() + first_of_subtree_[root], in_task.begin() + root + 1, std::uint8_t{1});
  std::vector<std::uint32_t> local(pattern_.vertices());
  double done = 0;
  std::size_t next_task = 0;
  const auto run_tasks_up_to = [&](std::uint32_t last) {
    std::vector<std::uint32_t> now;
    for (; next_task < tasks.size() && tasks[next_task] <= last; ++next_task) now.push_back(tasks[next_task]);
    for (const std::uint32_t root : now) done += subtree_flops_[root];
    run_side_by_side(std::move(now), progress);
  };
  const auto eliminate_above = [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t s = first; s <= last; ++s) {
      if (in_task[s]) continue;
      if (progress) progress->at(std::min(1.0, done / pattern_.flops));
      eliminate(s, local, pattern_.own(s) + pattern_.below(s) > 256);
      done += flops_of(s);
    }
  };
  const auto count = static_cast<std::uint32_t>(pattern_.supernodes());
  std::uint32_t begun = 0;
  for (const std::uint32_t portion : portions) {
    if (first_of_subtree_[portion] > begun) eliminate_above(begun, first_of_subtree_[portion] - 1);
    run_tasks_up_to(portion);
    eliminate_above(first_of_subtree_[portion], portion);
    begun = portion + 1;
  }
  if (count == 0) return;
  run_tasks_up_to(count - 1);
  eliminate_above(begun, count - 1);
}

void subtract_rows(double* x, std::size_t ld, const double* y, std::span<const std::uint32_t> rows, std::size_t k) {
  for (std::size_t j = 0; j < k; ++j)
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) x[j * ld + 3 * rows[i] + a] -= y[j * 3 * rows.size() + 3 * i + a];
}

}  // namespace

SparseFactor::SparseFactor(std::shared_ptr<const FactorPattern> pattern, const BlockMatrix& matrix,
                           std::span<const std::uint8_t> active, std::span<const std::uint8_t> dead, Progress* progress)
    : pattern_(std::move(pattern)), values_(Buffer::recycled(pattern_->panel_start.back())) {
  blas::use_one_thread();
  Multifrontal(*pattern_, matrix, active, dead, values_.data()).run(progress);
}

void SparseFactor::solve_forward(double* x, std::size_t k) const {
  blas::use_one_thread();
  const FactorPattern& f = *pattern_;
  parallel_blocks(k, right_hand_sides, [&](std::size_t begin, std::size_t end, std::size_t) {
    double* block = x + begin * size();
    const std::size_t columns = end - begin;
    std::vector<std::uint8_t> on_path(f.supernodes(), 0);
    std::vector<double> product;
    for (std::size_t s = 0; s < f.supernodes(); ++s) {
      const std::size_t first = 3 * std::size_t{f.super_start[s]}, c = 3 * f.own(s), r = 3 * f.below(s);
      for (std::size_t j = 0; j < columns && !on_path[s]; ++j)
        on_path[s] =
            std::any_of(block + j * size() + first, block + j * size() + first + c, [](double v) { return v != 0; });
      if (!on_path[s]) continue;
      blas::trsm('L', 'N', c, columns, 1, panel(s), c + r, block + first, size());
      if (r == 0) continue;
      on_path[static_cast<std::size_t>(f.parent[s])] = 1;
      product.resize(r * columns);
      blas::gemm('N', 'N', r, columns, c, 1, panel(s) + c, c + r, block + first, size(), 0, product.data(), r);
      subtract_rows(block, size(), product.data(), f.rows_of(s), columns);
    }
  });
}

void SparseFactor::solve_backward(double* x, std::size_t k) const {
  blas::use_one_thread();
  const FactorPattern& f = *pattern_;
  parallel_blocks(k, right_hand_sides, [&](std::size_t begin, std::size_t end, std::size_t) {
    double* block = x + begin * size();
    const std::size_t columns = end - begin;
    std::vector<double> below;
    for (std::size_t s = f.supernodes(); s-- > 0;) {
      const std::size_t first = 3 * std::size_t{f.super_start[s]}, c = 3 * f.own(s), r = 3 * f.below(s);
      const std::span<const std::uint32_t> rows = f.rows_of(s);
      below.resize(r * columns);
      for (std::size_t j = 0; j < columns; ++j)
        for (std::size_t i = 0; i < rows.size(); ++i)
          for (std::size_t a = 0; a < 3; ++a) below[j * r + 3 * i + a] = block[j * size() + 3 * rows[i] + a];
      if (r > 0)
        blas::gemm('T', 'N', c, columns, r, -1, panel(s) + c, c + r, below.data(), r, 1, block + first, size());
      blas::trsm('L', 'T', c, columns, 1, panel(s), c + r, block + first, size());
    }
  });
}

}  // namespace calot
