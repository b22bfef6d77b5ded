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
    if (!is_free(v)) continue;
    for (std::uint32_t k = stiffness.row_start[v]; k < stiffness.row_start[v + 1]; ++k) {
      const std::uint32_t u = stiffness.column[k];
      if (u >= v || !is_free(u) || stiffness.block[k].isZero(0)) continue;
      const std::uint32_t a = find(u), b = find(v);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  group.resize(slots());
  for (std::uint32_t v = 0; v < slots(); ++v) group[v] = is_free(v) ? find(v) : no_group;
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

std::vector<Island> Compliance::Impl::make_islands(const std::vector<std::vector<std::uint32_t>>& groups) const {
  std::vector<Island> made;
  for (const std::vector<std::uint32_t>& members : groups) {
    const auto size = static_cast<Index>(3 * members.size());
    MatrixXd a = MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < members.size(); ++i)
      for (std::size_t j = 0; j < members.size(); ++j)
        if (const Mat3* block = stiffness.find(members[i], members[j]))
          a.block<3, 3>(static_cast<Index>(3 * i), static_cast<Index>(3 * j)) = *block;
    if (blas::potrf(static_cast<std::size_t>(size), a.data(), static_cast<std::size_t>(size)) != 0)
      throw Unsupported("", "a freed piece around slot " + std::to_string(members.front()) + " has no inverse",
                        "remove it with the cut, or use a time step > 0");
    blas::potri(static_cast<std::size_t>(size), a.data(), static_cast<std::size_t>(size));
    a.triangularView<Eigen::StrictlyUpper>() = a.transpose();
    made.push_back({members, std::move(a)});
  }
  return made;
}

void Compliance::Impl::settle_islands(std::vector<Island> made) {
  islands = std::move(made);
  island_of_slot.assign(slots(), -1);
  for (std::size_t i = 0; i < islands.size(); ++i)
    for (const std::uint32_t slot : islands[i].slots) island_of_slot[slot] = static_cast<std::int32_t>(i);
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

void Compliance::Impl::add_slots(const std::vector<std::uint8_t>& fixed_flags) {
  fixed.insert(fixed.end(), fixed_flags.begin(), fixed_flags.end());
  dead.resize(slots(), 0);
  active.resize(slots(), 0);
  row_of_slot.resize(slots(), -1);
  island_of_slot.resize(slots(), -1);
  group.resize(slots(), no_group);
}

UpdateStep Compliance::Impl::enter(const SlotStep& step) {
  for (const SlotStep::Entering& entering : step.entering) {
    if (const std::int32_t left = row_of_slot[entering.slot]; left >= 0)
      slot_of_row[static_cast<std::size_t>(left) / 3] = no_slot;
    row_of_slot[entering.slot] = static_cast<std::int32_t>(base->append(1 / entering.stiffness));
    slot_of_row.push_back(entering.slot);
  }
  UpdateStep result;
  result.struck = static_cast<Index>(3 * step.struck);
  result.change = step.change;
  for (const std::uint32_t slot : step.slots)
    for (std::uint32_t a = 0; a < 3; ++a) result.rows.push_back(static_cast<std::uint32_t>(row_of_slot[slot]) + a);
  return result;
}

namespace {

// What an update is about, in slots.
struct Concerned {
  std::vector<std::uint32_t> sites;   // touched slots, then added ones
  std::vector<std::uint32_t> struck;  // slots
  std::size_t touched = 0;            // how many of the sites
};

Concerned concerned_by(const Compliance::Impl& impl, const StiffnessChange& change) {
  Concerned result;
  for (const VertexId v : change.touched) result.sites.push_back(impl.slot_of_vertex.at(v.index()));
  for (const VertexId v : change.struck) result.struck.push_back(impl.slot_of_vertex.at(v.index()));
  result.touched = result.sites.size();
  for (std::size_t k = 0; k < change.added.size(); ++k)
    result.sites.push_back(static_cast<std::uint32_t>(impl.slots() + k));
  return result;
}

// Takes the change's new blocks into Â and strikes the dead slots. @return whether entries came that had been none
bool change_stiffness(Compliance::Impl& impl, const StiffnessChange& change, const Concerned& concerned) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
  for (const StiffnessChange::Entry& entry : change.entries) {
    const std::uint32_t row = concerned.sites[entry.row], column = concerned.sites[entry.column];
    if (row >= impl.stiffness.rows() || impl.stiffness.find(row, column) == nullptr) places.emplace_back(row, column);
  }
  std::sort(places.begin(), places.end());
  if (!places.empty()) impl.stiffness.grow(impl.slots(), places);
  bool grown = false;
  for (const StiffnessChange::Entry& entry : change.entries) {
    const std::uint32_t row = concerned.sites[entry.row], column = concerned.sites[entry.column];
    Mat3& block = *impl.stiffness.find(row, column);
    grown |= block.isZero(0) && !entry.block.isZero(0) && impl.is_free(row) && impl.is_free(column);
    block = entry.block;
  }
  for (const std::uint32_t slot : concerned.struck) {
    impl.dead[slot] = 1;
    for (std::uint32_t k = impl.stiffness.row_start[slot]; k < impl.stiffness.row_start[slot + 1]; ++k) {
      impl.stiffness.block[k].setZero();
      impl.stiffness.find(impl.stiffness.column[k], slot)->setZero();
    }
  }
  return grown;
}

// What each slot does in an update.
enum class Role : std::uint8_t { none, leaves, enters };

// Who enters: added vertices, and those of former islands that belong to a larger group now. σ is the mean of the final
// diagonal. Added vertices on an island get rows too, but nobody asks for them.
std::vector<SlotStep::Entering> entering_slots(const Compliance::Impl& impl, const Concerned& concerned,
                                               const std::vector<std::uint8_t>& on_island) {
  std::vector<SlotStep::Entering> result;
  const auto enter = [&](std::uint32_t slot) {
    result.push_back({slot, impl.stiffness.find(slot, slot)->trace() / 3});
  };
  for (const Island& island : impl.islands)
    for (const std::uint32_t slot : island.slots)
      if (!on_island[slot] && impl.is_free(slot)) enter(slot);
  for (std::size_t k = concerned.touched; k < concerned.sites.size(); ++k)
    if (impl.is_free(concerned.sites[k])) enter(concerned.sites[k]);
  return result;
}

// The change on the slots from `first` on. Between slots that stay it is what the tets' change says; where a slot
// enters its row is all of Â', less the σ it came with.
MatrixXd change_on(const Compliance::Impl& impl, const StiffnessChange& change, const Concerned& concerned,
                   const SlotStep& step, const std::vector<Role>& role) {
  constexpr Index absent = -1;
  std::vector<Index> place(impl.slots(), absent);
  for (std::size_t k = step.struck; k < step.slots.size(); ++k)
    place[step.slots[k]] = static_cast<Index>(3 * (k - step.struck));
  const auto size = static_cast<Index>(3 * (step.slots.size() - step.struck));
  MatrixXd result = MatrixXd::Zero(size, size);
  for (const StiffnessChange::Entry& entry : change.entries) {
    const std::uint32_t row = concerned.sites[entry.row], column = concerned.sites[entry.column];
    if (place[row] == absent || place[column] == absent || role[row] == Role::enters || role[column] == Role::enters)
      continue;
    result.block<3, 3>(place[row], place[column]) = entry.change;
  }
  for (const SlotStep::Entering& entering : step.entering) {
    if (place[entering.slot] == absent) continue;
    for (std::uint32_t k = impl.stiffness.row_start[entering.slot]; k < impl.stiffness.row_start[entering.slot + 1];
         ++k) {
      const Index row = place[entering.slot], column = place[impl.stiffness.column[k]];
      if (column == absent) continue;
      result.block<3, 3>(row, column) = impl.stiffness.block[k];
      result.block<3, 3>(column, row) = impl.stiffness.block[k].transpose();
    }
    result.block<3, 3>(place[entering.slot], place[entering.slot]).diagonal().array() -= entering.stiffness;
  }
  return result;
}

// D are the slots of struck vertices and of vertices that now belong to an island; S the other touched ones and those
// that enter.
SlotStep step_of(const Compliance::Impl& impl, const StiffnessChange& change, const Concerned& concerned,
                 const std::vector<std::vector<std::uint32_t>>& islands) {
  SlotStep step;
  std::vector<Role> role(impl.slots(), Role::none);
  std::vector<std::uint8_t> on_island(impl.slots(), 0);
  const auto strike = [&](std::uint32_t slot) {
    role[slot] = Role::leaves;
    if (impl.row_of_slot[slot] >= 0 && impl.island_of_slot[slot] < 0) step.slots.push_back(slot);
  };
  for (const std::uint32_t slot : concerned.struck) strike(slot);
  for (const std::vector<std::uint32_t>& island : islands)
    for (const std::uint32_t slot : island) {
      on_island[slot] = 1;
      strike(slot);
    }
  step.struck = step.slots.size();
  step.entering = entering_slots(impl, concerned, on_island);
  for (const SlotStep::Entering& entering : step.entering)
    if (!on_island[entering.slot]) {
      role[entering.slot] = Role::enters;
      step.slots.push_back(entering.slot);
    }
  for (const std::uint32_t slot : concerned.sites)
    if (role[slot] == Role::none && impl.row_of_slot[slot] >= 0 && impl.island_of_slot[slot] < 0)
      step.slots.push_back(slot);
  step.change = change_on(impl, change, concerned, step, role);
  return step;
}

void renumber(Compliance::Impl& impl, const Remap& remap, std::size_t first_added) {
  std::vector<std::uint32_t> slots(remap.vertex_to_old.size());
  for (std::size_t v = 0; v < slots.size(); ++v)
    slots[v] = remap.vertex_to_old[v].valid() ? impl.slot_of_vertex.at(remap.vertex_to_old[v].index())
                                              : static_cast<std::uint32_t>(first_added++);
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

// What a refused update puts back; only static ones can be.
class Saved {
 public:
  explicit Saved(Compliance::Impl& impl)
      : impl_(impl),
        row_of_slot_(impl.row_of_slot),
        slot_of_row_(impl.slot_of_row),
        stiffness_(impl.stiffness),
        dead_(impl.dead),
        group_(impl.group),
        correction_(impl.correction),
        appended_(impl.base->appended()) {}
  void put_back() {
    impl_.row_of_slot = std::move(row_of_slot_);
    impl_.slot_of_row = std::move(slot_of_row_);
    impl_.stiffness = std::move(stiffness_);
    impl_.dead = std::move(dead_);
    impl_.group = std::move(group_);
    impl_.correction = std::move(correction_);
    impl_.base->forget_appended(appended_);
    const std::size_t slots = impl_.dead.size();
    impl_.fixed.resize(slots);
    impl_.active.resize(slots);
    impl_.island_of_slot.resize(slots);
  }

 private:
  Compliance::Impl& impl_;
  std::vector<std::int32_t> row_of_slot_;
  std::vector<std::uint32_t> slot_of_row_;
  BlockMatrix stiffness_;
  std::vector<std::uint8_t> dead_;
  std::vector<std::uint32_t> group_;
  Correction correction_;
  std::size_t appended_;
};

[[noreturn]] void refuse_weak() {
  throw Unsupported("", "what the cut leaves is held too weakly to be solved",
                    "keep more of it, or use a time step > 0");
}

}  // namespace

UpdateReport Compliance::update(const StiffnessChange& change) {
  blas::use_one_thread();
  require_same_mesh(*this, change);
  Impl& impl = *impl_;
  const Concerned concerned = concerned_by(impl, change);
  std::optional<Saved> saved;
  if (impl.is_static) saved.emplace(impl);
  const std::size_t first_added = impl.slots();
  impl.add_slots(change.added_fixed);
  const bool grown = change_stiffness(impl, change, concerned);
  impl.regroup();
  const std::vector<std::vector<std::uint32_t>> groups = impl.small_groups(concerned.sites);
  SlotStep step = step_of(impl, change, concerned, groups);
  UpdateReport report;
  report.rank = 3 * step.slots.size();
  bool lost = false;
  std::vector<Island> islands;
  try {
    islands = impl.make_islands(groups);
    const UpdateStep in_rows = impl.enter(step);
    if (!in_rows.rows.empty()) {
      impl.correction.add(*impl.base, in_rows);
      const CorrectionHealth health = impl.correction.factor();
      report.smallest_eigenvalue = health.smallest_eigenvalue;
      lost = impl.is_lost(health);
    }
    if (lost && impl.is_static) refuse_weak();
  } catch (...) {
    if (saved) saved->put_back();
    throw;
  }
  renumber(impl, change.remap, first_added);
  if (grown || !step.entering.empty()) impl.pattern_is_small = impl.fold_is_small = true;
  if (lost) {  // A dynamic model stays definite, but the update would keep few digits: factor anew instead.
    impl.refactor();
    report.refreshed = true;
    return report;
  }
  impl.settle_islands(std::move(islands));
  if (step.slots.empty() && !(concerned.sites.empty() && concerned.struck.empty())) impl.base_is_stale = true;
  if ((!step.slots.empty() || !step.entering.empty()) && impl.fold.valid())
    impl.steps_since_fold.push_back(std::move(step));
  return report;
}

}  // namespace calot
