// Taking in a change of the model.
#include <algorithm>
#include <numeric>
#include <optional>

#include "calot/base/error.h"
#include "calot/compliance/blas.h"
#include "calot/compliance/compliance.h"
#include "calot/compliance/compliance_impl.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

void Compliance::Impl::regroup() {
  std::vector<std::uint32_t> root(slots());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (std::uint32_t v = 0; v < slots(); ++v) {
    if (row_of_slot[v] < 0 || dead[v]) continue;
    for (std::uint32_t k = stiffness.row_start[v]; k < stiffness.row_start[v + 1]; ++k) {
      const std::uint32_t u = stiffness.column[k];
      if (u >= v || row_of_slot[u] < 0 || dead[u] || stiffness.block[k].isZero(0)) continue;
      const std::uint32_t a = find(u), b = find(v);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  group.resize(slots());
  for (std::uint32_t v = 0; v < slots(); ++v) group[v] = row_of_slot[v] < 0 || dead[v] ? no_group : find(v);
}

namespace {

constexpr std::size_t island_vertices = 64;  // a group up to this size is answered from its own inverse

}  // namespace

std::vector<std::vector<std::uint32_t>> Compliance::Impl::small_groups(
    const std::vector<std::uint32_t>& touched) const {
  std::vector<std::uint32_t> size(slots(), 0);
  for (std::size_t s = 0; s < slots(); ++s)
    if (group[s] != no_group) ++size[group[s]];
  std::vector<std::uint8_t> wanted(slots(), 0);  // of each group
  const auto want = [&](std::uint32_t slot) {
    if (group[slot] != no_group && size[group[slot]] <= island_vertices) wanted[group[slot]] = 1;
  };
  for (const std::uint32_t slot : touched) want(slot);
  for (const Island& island : islands)
    for (const std::uint32_t slot : island.slots) want(slot);
  std::vector<std::vector<std::uint32_t>> groups;
  std::vector<std::int32_t> place(slots(), -1);
  for (std::uint32_t s = 0; s < slots(); ++s) {
    if (group[s] == no_group || !wanted[group[s]]) continue;
    if (place[group[s]] < 0) {
      place[group[s]] = static_cast<std::int32_t>(groups.size());
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(place[group[s]])].push_back(s);
  }
  return groups;
}

void Compliance::Impl::settle_islands(const std::vector<std::vector<std::uint32_t>>& groups) {
  islands.clear();
  std::fill(island_of_slot.begin(), island_of_slot.end(), -1);
  for (const std::vector<std::uint32_t>& members : groups) {
    const auto size = static_cast<Index>(3 * members.size());
    MatrixXd a = MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < members.size(); ++i) {
      island_of_slot[members[i]] = static_cast<std::int32_t>(islands.size());
      for (std::size_t j = 0; j < members.size(); ++j)
        if (const Mat3* block = stiffness.find(members[i], members[j]))
          a.block<3, 3>(static_cast<Index>(3 * i), static_cast<Index>(3 * j)) = *block;
    }
    if (blas::potrf(static_cast<std::size_t>(size), a.data(), static_cast<std::size_t>(size)) != 0)
      throw Unsupported("", "a freed piece around slot " + std::to_string(members.front()) + " has no inverse",
                        "remove it with the cut, or use a time step > 0");
    blas::potri(static_cast<std::size_t>(size), a.data(), static_cast<std::size_t>(size));
    a.triangularView<Eigen::StrictlyUpper>() = a.transpose();
    islands.push_back({members, std::move(a)});
  }
}

double Compliance::Impl::island_entry(std::uint32_t row_slot, std::uint32_t row_axis, std::uint32_t column_slot,
                                      std::uint32_t column_axis) const {
  const Island& island = islands[static_cast<std::size_t>(island_of_slot[row_slot])];
  const auto place = [&](std::uint32_t slot) {
    return static_cast<Index>(
        3 * (std::lower_bound(island.slots.begin(), island.slots.end(), slot) - island.slots.begin()));
  };
  return island.inverse(place(row_slot) + row_axis, place(column_slot) + column_axis);
}

namespace {

// Takes the change's new blocks into Â and strikes the dead slots.
void change_stiffness(Compliance::Impl& impl, const StiffnessChange& change,
                      const std::vector<std::uint32_t>& touched_slots, const std::vector<std::uint32_t>& struck_slots) {
  for (const StiffnessChange::Entry& entry : change.entries)
    *impl.stiffness.find(touched_slots[entry.row], touched_slots[entry.column]) = entry.block;
  for (const std::uint32_t slot : struck_slots) {
    impl.dead[slot] = 1;
    for (std::uint32_t k = impl.stiffness.row_start[slot]; k < impl.stiffness.row_start[slot + 1]; ++k) {
      impl.stiffness.block[k].setZero();
      impl.stiffness.find(impl.stiffness.column[k], slot)->setZero();
    }
  }
}

std::vector<std::uint32_t> slots_of(const Compliance::Impl& impl, const std::vector<VertexId>& vertices) {
  std::vector<std::uint32_t> slots;
  for (const VertexId v : vertices) slots.push_back(impl.slot_of_vertex.at(v.index()));
  return slots;
}

// D are the rows of struck vertices and of vertices that now belong to an island; S those of the other touched
// vertices.
UpdateStep step_of(const Compliance::Impl& impl, const StiffnessChange& change,
                   const std::vector<std::uint32_t>& touched_slots, const std::vector<std::uint32_t>& struck_slots,
                   const std::vector<std::vector<std::uint32_t>>& islands) {
  UpdateStep result;
  std::vector<std::uint8_t> leaves(impl.slots(), 0);
  const auto add = [&](std::uint32_t slot) {
    for (std::uint32_t a = 0; a < 3; ++a) result.rows.push_back(static_cast<std::uint32_t>(impl.row_of_slot[slot]) + a);
  };
  const auto strike = [&](std::uint32_t slot) {
    leaves[slot] = 1;
    if (impl.row_of_slot[slot] >= 0 && impl.island_of_slot[slot] < 0) add(slot);
  };
  for (const std::uint32_t slot : struck_slots) strike(slot);
  for (const std::vector<std::uint32_t>& island : islands)
    for (const std::uint32_t slot : island) strike(slot);
  result.struck = static_cast<Index>(result.rows.size());
  std::vector<Index> kept;  // places in `touched`
  for (std::size_t k = 0; k < touched_slots.size(); ++k)
    if (const std::uint32_t slot = touched_slots[k];
        impl.row_of_slot[slot] >= 0 && impl.island_of_slot[slot] < 0 && !leaves[slot]) {
      add(slot);
      kept.push_back(static_cast<Index>(k));
    }
  const auto size = static_cast<Index>(3 * kept.size());
  result.change.resize(size, size);
  for (std::size_t j = 0; j < kept.size(); ++j)
    for (std::size_t i = 0; i < kept.size(); ++i)
      result.change.block<3, 3>(static_cast<Index>(3 * i), static_cast<Index>(3 * j)) =
          -change.removed.block<3, 3>(3 * kept[i], 3 * kept[j]);
  return result;
}

void renumber(Compliance::Impl& impl, const Remap& remap) {
  std::vector<std::uint32_t> slots(remap.vertex_to_old.size());
  for (std::size_t v = 0; v < slots.size(); ++v) slots[v] = impl.slot_of_vertex.at(remap.vertex_to_old[v].index());
  impl.slot_of_vertex = std::move(slots);
}

void require_same_mesh(const Compliance& compliance, const StiffnessChange& change) {
  if (change.remap.vertex_to_new.size() != compliance.vertex_count())
    throw InputError("change",
                     "was made from a mesh of " + std::to_string(change.remap.vertex_to_new.size()) +
                         " vertices, the compliance has " + std::to_string(compliance.vertex_count()),
                     "apply every edit of the model to its compliance, in order");
  if (!change.unsupported.empty())
    throw Unsupported("", change.unsupported, "hold it, keep it joined, or use a time step > 0");
}

// What a refused update puts back.
struct Saved {
  BlockMatrix stiffness;
  std::vector<std::uint8_t> dead;
  std::vector<std::uint32_t> group;
  Correction correction;
};

}  // namespace

UpdateReport Compliance::update(const StiffnessChange& change) {
  blas::use_one_thread();
  require_same_mesh(*this, change);
  Impl& impl = *impl_;
  const std::vector<std::uint32_t> touched = slots_of(impl, change.touched), struck = slots_of(impl, change.struck);
  std::optional<Saved> saved;
  if (impl.is_static) saved = Saved{impl.stiffness, impl.dead, impl.group, impl.correction};
  change_stiffness(impl, change, touched, struck);
  impl.regroup();
  const std::vector<std::vector<std::uint32_t>> islands = impl.small_groups(touched);
  UpdateStep step = step_of(impl, change, touched, struck, islands);
  UpdateReport report;
  report.rank = step.rows.size();
  bool lost = false;
  if (!step.rows.empty()) {
    impl.correction.add(*impl.base, step);
    const CorrectionHealth health = impl.correction.factor();
    report.smallest_eigenvalue = health.smallest_eigenvalue;
    lost = impl.is_lost(health);
  }
  if (lost && impl.is_static) {
    impl.stiffness = std::move(saved->stiffness);
    impl.dead = std::move(saved->dead);
    impl.group = std::move(saved->group);
    impl.correction = std::move(saved->correction);
    throw Unsupported("", "what the cut leaves is held too weakly to be solved",
                      "keep more of it, or use a time step > 0");
  }
  renumber(impl, change.remap);
  if (lost) {  // A dynamic model stays definite, but the update would keep few digits: factor anew instead.
    impl.refactor();
    report.refreshed = true;
    return report;
  }
  impl.settle_islands(islands);
  if (step.rows.empty() && !(touched.empty() && struck.empty())) impl.base_is_stale = true;
  if (!step.rows.empty() && impl.fold.valid()) impl.steps_since_fold.push_back(std::move(step));
  return report;
}

}  // namespace calot
