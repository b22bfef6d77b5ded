#include <cholmod.h>

#include <algorithm>
#include <mutex>
#include <string>

#include "calot/base/error.h"
#include "calot/compliance/sparse_factor.h"

namespace calot {
namespace {

// CHOLMOD's workspace; its analysis uses METIS, whose random state is global, so one analysis at a time.
class Cholmod {
 public:
  Cholmod() : lock_(mutex()) {
    cholmod_l_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_METIS;
    common.postorder = 1;
    common.print = 0;
  }
  ~Cholmod() { cholmod_l_finish(&common); }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
  cholmod_common common{};

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::lock_guard<std::mutex> lock_;
};

// The lower triangle of the active vertex graph, in CHOLMOD's form. Zero blocks, as edits leave them behind, are no
// part of it.
struct Graph {
  std::vector<SuiteSparse_long> start, row;
};

Graph active_graph(const BlockMatrix& matrix, std::span<const std::uint8_t> active) {
  std::vector<std::int64_t> number(matrix.rows(), -1);
  std::int64_t count = 0;
  for (std::size_t v = 0; v < matrix.rows(); ++v)
    if (active[v]) number[v] = count++;
  Graph graph;
  graph.start.push_back(0);
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    if (!active[v]) continue;
    for (std::uint32_t k = matrix.row_start[v]; k < matrix.row_start[v + 1]; ++k)
      if (matrix.column[k] >= v && active[matrix.column[k]] && (matrix.column[k] == v || !matrix.block[k].isZero(0)))
        graph.row.push_back(number[matrix.column[k]]);
    graph.start.push_back(static_cast<SuiteSparse_long>(graph.row.size()));
  }
  return graph;
}

FactorPattern pattern_of(const cholmod_factor& factor) {
  const std::size_t n = factor.n, supers = factor.nsuper;
  const auto* perm = static_cast<const SuiteSparse_long*>(factor.Perm);
  const auto* super = static_cast<const SuiteSparse_long*>(factor.super);
  const auto* start = static_cast<const SuiteSparse_long*>(factor.pi);
  const auto* rows = static_cast<const SuiteSparse_long*>(factor.s);
  std::vector<std::uint64_t> row_start{0};
  std::vector<std::uint32_t> below;
  for (std::size_t s = 0; s < supers; ++s) {
    below.insert(below.end(), rows + start[s] + (super[s + 1] - super[s]), rows + start[s + 1]);
    row_start.push_back(below.size());
  }
  return complete_pattern({perm, perm + n}, {super, super + supers + 1}, std::move(row_start), std::move(below));
}

[[noreturn]] void refuse(const std::string& what) {
  throw InputError("factor", what, "compute it again with `calot precompute --backend sparse`");
}

void check_order(const FactorPattern& f) {
  const std::size_t n = f.perm.size();
  std::vector<std::uint8_t> seen(n, 0);
  for (const std::uint32_t v : f.perm) {
    if (v >= n || seen[v]) refuse("its ordering is no permutation");
    seen[v] = 1;
  }
  if (f.super_start.empty() || f.super_start.front() != 0 || f.super_start.back() != n)
    refuse("its supernodes don't cover its rows");
  for (std::size_t s = 0; s + 1 < f.super_start.size(); ++s)
    if (f.super_start[s] >= f.super_start[s + 1]) refuse("its supernodes are not in order");
  if (f.row_start.size() != f.super_start.size() || f.row_start.front() != 0 || f.row_start.back() != f.rows.size())
    refuse("its row counts don't fit its supernodes");
  for (std::size_t s = 0; s + 1 < f.row_start.size(); ++s)
    if (f.row_start[s] > f.row_start[s + 1]) refuse("its row counts are not in order");
}

// Rows ascend, lie below, and those that are not the parent's own are among the parent's rows: the elimination needs
// it.
void check_rows(const FactorPattern& f, std::size_t s) {
  const std::span<const std::uint32_t> rows = f.rows_of(s);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] < f.super_start[s + 1] || rows[i] >= f.vertices() || (i > 0 && rows[i] <= rows[i - 1]))
      refuse("its rows are not in order");
  if (rows.empty()) return;
  const std::size_t parent = f.super_of[rows.front()];
  const std::span<const std::uint32_t> above = f.rows_of(parent);
  const auto first = std::lower_bound(rows.begin(), rows.end(), f.super_start[parent + 1]);
  if (!std::includes(above.begin(), above.end(), first, rows.end())) refuse("its rows are not those of an elimination");
}

// Subtrees must be contiguous (a postorder): they are eliminated as ranges, several at a time.
void check_postorder(const FactorPattern& f) {
  std::vector<std::size_t> size(f.supernodes(), 1), first(f.supernodes());
  for (std::size_t s = 0; s < f.supernodes(); ++s) first[s] = s;
  for (std::size_t s = 0; s < f.supernodes(); ++s) {
    if (first[s] + size[s] != s + 1) refuse("its supernodes are not in postorder");
    if (f.parent[s] < 0) continue;
    const auto parent = static_cast<std::size_t>(f.parent[s]);
    size[parent] += size[s];
    first[parent] = std::min(first[parent], first[s]);
  }
}

}  // namespace

FactorPattern complete_pattern(std::vector<std::uint32_t> perm, std::vector<std::uint32_t> super_start,
                               std::vector<std::uint64_t> row_start, std::vector<std::uint32_t> rows) {
  FactorPattern f;
  f.perm = std::move(perm);
  f.super_start = std::move(super_start);
  f.row_start = std::move(row_start);
  f.rows = std::move(rows);
  check_order(f);
  const std::size_t n = f.vertices(), supers = f.super_start.size() - 1;
  f.position.resize(n);
  for (std::size_t p = 0; p < n; ++p) f.position[f.perm[p]] = static_cast<std::uint32_t>(p);
  f.super_of.resize(n);
  for (std::size_t s = 0; s < supers; ++s)
    for (std::uint32_t p = f.super_start[s]; p < f.super_start[s + 1]; ++p)
      f.super_of[p] = static_cast<std::uint32_t>(s);
  f.panel_start.push_back(0);
  for (std::size_t s = 0; s < supers; ++s) {
    check_rows(f, s);
    const std::uint64_t own = f.own(s), below = f.below(s);
    f.parent.push_back(below > 0 ? static_cast<std::int32_t>(f.super_of[f.rows_of(s).front()]) : -1);
    f.panel_start.push_back(f.panel_start.back() + 9 * own * (own + below));
    const double c = 3.0 * static_cast<double>(own), r = 3.0 * static_cast<double>(below);
    f.nonzeros += c * (c + 1) / 2 + r * c;
    f.flops += c * c * c / 3 + r * c * c + r * r * c;
  }
  check_postorder(f);
  return f;
}

FactorPattern analyse(const BlockMatrix& matrix, std::span<const std::uint8_t> active) {
  Graph graph = active_graph(matrix, active);
  if (graph.start.size() == 1) return complete_pattern({}, {0}, {0}, {});
  Cholmod cholmod;
  cholmod_sparse lower{};
  lower.nrow = lower.ncol = graph.start.size() - 1;
  lower.nzmax = graph.row.size();
  lower.p = graph.start.data();
  lower.i = graph.row.data();
  lower.stype = -1;
  lower.itype = CHOLMOD_LONG;
  lower.xtype = CHOLMOD_PATTERN;
  lower.dtype = CHOLMOD_DOUBLE;
  lower.sorted = lower.packed = 1;
  cholmod_factor* factor = cholmod_l_analyze(&lower, &cholmod.common);
  if (!factor)
    throw FailedError("memory", "the analysis of the stiffness matrix ran out of memory", "use a coarser mesh");
  FactorPattern pattern = pattern_of(*factor);
  cholmod_l_free_factor(&factor, &cholmod.common);
  return pattern;
}

}  // namespace calot
