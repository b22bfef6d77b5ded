#include <cholmod.h>

#include <memory>
#include <mutex>
#include <numeric>

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

// The lower triangle of the active vertex graph, in CHOLMOD's form.
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
      if (matrix.column[k] >= v && active[matrix.column[k]]) graph.row.push_back(number[matrix.column[k]]);
    graph.start.push_back(static_cast<SuiteSparse_long>(graph.row.size()));
  }
  return graph;
}

void fill(FactorPattern& pattern, const cholmod_factor& factor) {
  const auto n = factor.n, supers = factor.nsuper;
  const auto* perm = static_cast<const SuiteSparse_long*>(factor.Perm);
  const auto* super = static_cast<const SuiteSparse_long*>(factor.super);
  const auto* start = static_cast<const SuiteSparse_long*>(factor.pi);
  const auto* rows = static_cast<const SuiteSparse_long*>(factor.s);
  pattern.perm.assign(perm, perm + n);
  pattern.position.resize(n);
  for (std::size_t p = 0; p < n; ++p) pattern.position[pattern.perm[p]] = static_cast<std::uint32_t>(p);
  pattern.super_start.assign(super, super + supers + 1);
  pattern.super_of.resize(n);
  pattern.row_start.push_back(0);
  pattern.panel_start.push_back(0);
  for (std::size_t s = 0; s < supers; ++s) {
    const std::uint64_t own = pattern.own(s);
    for (std::uint32_t p = pattern.super_start[s]; p < pattern.super_start[s + 1]; ++p)
      pattern.super_of[p] = static_cast<std::uint32_t>(s);
    pattern.rows.insert(pattern.rows.end(), rows + start[s] + own, rows + start[s + 1]);
    pattern.row_start.push_back(pattern.rows.size());
    const std::uint64_t below = pattern.below(s);
    pattern.panel_start.push_back(pattern.panel_start.back() + 9 * own * (own + below));
    const double c = 3.0 * static_cast<double>(own), r = 3.0 * static_cast<double>(below);
    pattern.nonzeros += c * (c + 1) / 2 + r * c;
    pattern.flops += c * c * c / 3 + r * c * c + r * r * c;
  }
  pattern.parent.resize(supers);
  for (std::size_t s = 0; s < supers; ++s)
    pattern.parent[s] = pattern.below(s) ? static_cast<std::int32_t>(pattern.super_of[pattern.rows_of(s)[0]]) : -1;
}

}  // namespace

FactorPattern analyse(const BlockMatrix& matrix, std::span<const std::uint8_t> active) {
  Graph graph = active_graph(matrix, active);
  FactorPattern pattern;
  if (graph.start.size() == 1) {
    pattern.super_start = {0};
    pattern.row_start = pattern.panel_start = {0};
    return pattern;
  }
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
  fill(pattern, *factor);
  cholmod_l_free_factor(&factor, &cholmod.common);
  return pattern;
}

}  // namespace calot
