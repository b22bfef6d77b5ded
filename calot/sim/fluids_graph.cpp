#include "calot/sim/fluids_graph.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>

namespace calot::detail {
namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

Vec3 middle(const TetMesh& mesh, TetId tet) {
  const Tet& c = mesh.tet(tet);
  return (mesh.position(c[0]) + mesh.position(c[1]) + mesh.position(c[2]) + mesh.position(c[3])) / 4;
}

constexpr bool is_sac(VesselKind kind) {
  return kind == VesselKind::gallbladder || kind == VesselKind::gallbladder_wall;
}

/// Per length [Pa s/m⁴].
double resistance(const TissueProperties& tissue) {
  return 8 * tissue.viscosity / (std::numbers::pi * std::pow(tissue.inner_radius, 4));
}

}  // namespace

void VesselGraph::build(const TetMesh& mesh, std::span<const Neighbours> neighbours,
                        std::span<const std::uint8_t> kind_of_tet, std::span<const TissueProperties> kinds) {
  std::vector<double> per_length(kinds.size(), 0);
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (has_lumen(kinds[k].vessel)) per_length[k] = resistance(kinds[k]);
  tet_count_ = mesh.tet_count();
  tets_.clear();
  next_.clear();
  cost_.clear();
  number_.assign(tet_count_, none);
  for (std::size_t t = 0; t < tet_count_; ++t) {
    if (!has_lumen(kinds[kind_of_tet[t]].vessel)) continue;
    number_[t] = static_cast<std::uint32_t>(tets_.size());
    tets_.emplace_back(t);
  }
  start_.assign(1, 0);
  for (const TetId t : tets_) {
    const std::uint8_t here = kind_of_tet[t.index()];
    for (const TetId other : neighbours[t.index()]) {
      if (!other.valid() || number_[other.index()] == none) continue;
      const std::uint8_t there = kind_of_tet[other.index()];
      if (fluid_of(kinds[here].vessel) != fluid_of(kinds[there].vessel)) continue;
      if (is_sac(kinds[here].vessel) && is_sac(kinds[there].vessel)) continue;
      next_.push_back(number_[other.index()]);
      cost_.push_back((middle(mesh, t) - middle(mesh, other)).norm() * (per_length[here] + per_length[there]) / 2);
    }
    start_.push_back(static_cast<std::uint32_t>(next_.size()));
  }
}

void VesselGraph::resistances(std::span<const std::uint8_t> seed, std::span<const std::uint8_t> closed,
                              std::vector<double>& out) const {
  out.assign(tet_count_, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto blocked = [&](std::uint32_t k) { return !closed.empty() && closed[tets_[k].index()] != 0; };
  for (std::uint32_t k = 0; k < tets_.size(); ++k) {
    if (seed[tets_[k].index()] == 0 || blocked(k)) continue;
    out[tets_[k].index()] = 0;
    if (start_[k] != start_[k + 1]) queue.emplace(0, k);
  }
  while (!queue.empty()) {
    const auto [far, k] = queue.top();
    queue.pop();
    if (far > out[tets_[k].index()]) continue;
    for (std::uint32_t e = start_[k]; e < start_[k + 1]; ++e) {
      const double there = far + cost_[e];
      if (blocked(next_[e]) || there >= out[tets_[next_[e]].index()]) continue;
      out[tets_[next_[e]].index()] = there;
      queue.emplace(there, next_[e]);
    }
  }
}

std::vector<std::vector<TetId>> VesselGraph::components() const {
  std::vector<std::vector<TetId>> all;
  std::vector<std::uint8_t> seen(tets_.size(), 0);
  std::vector<std::uint32_t> stack;
  for (std::uint32_t first = 0; first < tets_.size(); ++first) {
    if (seen[first] != 0) continue;
    all.emplace_back();
    stack.assign(1, first);
    seen[first] = 1;
    while (!stack.empty()) {
      const std::uint32_t k = stack.back();
      stack.pop_back();
      all.back().push_back(tets_[k]);
      for (std::uint32_t e = start_[k]; e < start_[k + 1]; ++e) {
        if (seen[next_[e]] != 0) continue;
        seen[next_[e]] = 1;
        stack.push_back(next_[e]);
      }
    }
    std::sort(all.back().begin(), all.back().end());
  }
  return all;
}

}  // namespace calot::detail
