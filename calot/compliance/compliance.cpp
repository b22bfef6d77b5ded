#include "calot/compliance/compliance.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"
#include "calot/compliance/compliance_impl.h"
#include "calot/compliance/inverse.h"
#include "calot/fem/support.h"

namespace calot {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr std::uint32_t no_row = ~0u;

}  // namespace

std::vector<std::uint8_t> active_slots(const Compliance::Impl& impl) {
  std::vector<std::uint8_t> active(impl.slots());
  for (std::size_t s = 0; s < active.size(); ++s) active[s] = impl.is_free(s);
  return active;
}

std::vector<std::uint32_t> Compliance::Impl::rows_of(std::span<const DofId> dofs) const {
  std::vector<std::uint32_t> rows;
  rows.reserve(dofs.size());
  for (const DofId dof : dofs) {
    const VertexId vertex = vertex_of(dof);
    if (vertex.index() >= slot_of_vertex.size())
      throw InputError("vertex " + std::to_string(vertex.value),
                       "is not in the mesh of " + std::to_string(slot_of_vertex.size()) + " vertices",
                       "numbers count from 0");
    const std::int32_t first = row_of_slot[slot_of_vertex[vertex.index()]];
    rows.push_back(first < 0 ? no_row : static_cast<std::uint32_t>(first) + dof.value % 3);
  }
  return rows;
}

MatrixXd Compliance::Impl::to_rows(const MatrixXd& x) const {
  MatrixXd result(static_cast<Index>(3 * slot_of_row.size()), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t r = 0; r < slot_of_row.size(); ++r) {
      auto at = result.col(j).segment<3>(static_cast<Index>(3 * r));
      if (slot_of_row[r] != no_slot && in_base(slot_of_row[r]))
        at = x.col(j).segment<3>(static_cast<Index>(3 * slot_of_row[r]));
      else
        at.setZero();
    }
  return result;
}

MatrixXd Compliance::Impl::to_slots(const MatrixXd& x) const {
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(3 * slots()), x.cols());
  for (Index j = 0; j < x.cols(); ++j)
    for (std::size_t r = 0; r < slot_of_row.size(); ++r)
      if (slot_of_row[r] != no_slot && in_base(slot_of_row[r]))
        result.col(j).segment<3>(static_cast<Index>(3 * slot_of_row[r])) =
            x.col(j).segment<3>(static_cast<Index>(3 * r));
  return result;
}

namespace {

// A force on one part moves that part only: rows of other groups are exactly zero, not merely small.
void silence_other_groups(const Compliance::Impl& impl, const MatrixXd& forces, MatrixXd& x) {
  std::vector<std::uint8_t> pushed(impl.slots() + 1);
  for (Index j = 0; j < x.cols(); ++j) {
    std::fill(pushed.begin(), pushed.end(), std::uint8_t{0});
    for (std::size_t s = 0; s < impl.slots(); ++s)
      if (impl.group[s] != no_group && !forces.col(j).segment<3>(static_cast<Index>(3 * s)).isZero(0))
        pushed[impl.group[s]] = 1;
    for (std::size_t s = 0; s < impl.slots(); ++s)
      if (impl.group[s] == no_group || !pushed[impl.group[s]]) x.col(j).segment<3>(static_cast<Index>(3 * s)).setZero();
  }
}

}  // namespace

namespace {

void add_islands(const Compliance::Impl& impl, const MatrixXd& forces, MatrixXd& x) {
  for (const Island& island : impl.islands) {
    MatrixXd f(static_cast<Index>(3 * island.slots.size()), forces.cols());
    for (std::size_t k = 0; k < island.slots.size(); ++k)
      f.middleRows<3>(static_cast<Index>(3 * k)) = forces.middleRows<3>(static_cast<Index>(3 * island.slots[k]));
    if (f.isZero(0)) continue;
    const MatrixXd u = island.inverse * f;
    for (std::size_t k = 0; k < island.slots.size(); ++k)
      x.middleRows<3>(static_cast<Index>(3 * island.slots[k])) += u.middleRows<3>(static_cast<Index>(3 * k));
  }
}

}  // namespace

MatrixXd Compliance::Impl::apply(const MatrixXd& forces, int refinements) const {
  blas::use_one_thread();
  MatrixXd x = to_slots(correction.apply(*base, to_rows(forces)));
  add_islands(*this, forces, x);
  silence_other_groups(*this, forces, x);
  MatrixXd residual(x.rows(), x.cols());
  for (int pass = 0; pass < refinements; ++pass) {
    parallel_for(static_cast<std::size_t>(x.cols()), [&](std::size_t j) {
      const auto c = static_cast<Index>(j);
      stiffness.multiply({x.col(c).data(), static_cast<std::size_t>(x.rows())},
                         {residual.col(c).data(), static_cast<std::size_t>(x.rows())});
      residual.col(c) = forces.col(c) - residual.col(c);
    });
    x += to_slots(correction.apply(*base, to_rows(residual)));
    add_islands(*this, residual, x);
    silence_other_groups(*this, forces, x);
  }
  return x;
}

namespace {

// Doubles to take for a matrix of n rows that is to be written into again and again while splits add some; what is not
// used is not paid for.
std::size_t room_for(std::size_t n) {
  return n * n + n * n / 16;
}

// Factors Â, and inverts it for a dense home; `into` is a matrix to write over, if it is large enough.
std::unique_ptr<ComplianceBase> make_base(Backend backend, const std::shared_ptr<const FactorPattern>& pattern,
                                          const BlockMatrix& stiffness, std::span<const std::uint8_t> active,
                                          std::span<const std::uint8_t> dead, Buffer into, Progress* progress) {
  if (progress) progress->phase("factoring");
  SparseFactor factor(pattern, stiffness, active, dead, progress);
  if (backend == Backend::sparse) return std::make_unique<SparseBase>(std::move(factor));
  if (progress) progress->phase("inverting");
  const std::size_t n = factor.size();
  if (into.size() < n * n) into = Buffer(room_for(n));
  invert(factor, into.data(), progress);
  return std::make_unique<DenseBase>(std::move(into), n);
}

}  // namespace

void Compliance::Impl::lay_out_rows(std::shared_ptr<const FactorPattern> made, std::vector<std::uint8_t> of_slots) {
  pattern = std::move(made);
  active = std::move(of_slots);
  active.resize(slots(), 0);
  std::vector<std::uint32_t> slot_of_active;
  for (std::size_t s = 0; s < slots(); ++s)
    if (active[s]) slot_of_active.push_back(static_cast<std::uint32_t>(s));
  row_of_slot.assign(slots(), -1);
  slot_of_row.resize(pattern->vertices());
  for (std::size_t p = 0; p < pattern->vertices(); ++p) {
    slot_of_row[p] = slot_of_active[pattern->perm[p]];
    row_of_slot[slot_of_row[p]] = static_cast<std::int32_t>(3 * p);
  }
  correction = Correction(3 * slot_of_row.size());
}

void Compliance::Impl::start_rows(std::shared_ptr<const FactorPattern> made) {
  lay_out_rows(std::move(made), active_slots(*this));
  settle_islands({});
  regroup();
}

void Compliance::Impl::build(Progress* progress) {
  // Nothing of the old compliance is given up before the new one is there: a stop or a lack of memory changes nothing.
  if (progress) progress->phase("ordering");
  std::vector<std::uint8_t> now_active = active_slots(*this);
  auto made = std::make_shared<FactorPattern>(analyse(stiffness, now_active));
  const std::size_t n = 3 * made->vertices();
  require_memory(made->panel_start.back() * sizeof(double) + (backend == Backend::dense ? n * n * sizeof(double) : 0),
                 "the compliance");
  std::unique_ptr<ComplianceBase> fresh = make_base(backend, made, stiffness, now_active, {}, {}, progress);
  lay_out_rows(std::move(made), std::move(now_active));
  pattern_is_small = base_is_stale = false;
  settle_islands({});
  spare = {};
  base = std::move(fresh);
  compact();
  regroup();
}

// A fold computes C anew from the cut Â, in the pattern analysed before if that has room for it. That is as quick as
// adding the correction to the matrix (5 Gflop against 2·n²·rank) and, unlike it, leaves no rounding behind:
// docs/decisions/0006-fold-by-refactoring.md.
std::function<Folded()> Compliance::Impl::fold_work() {
  std::vector<std::uint8_t> folded_active = pattern_is_small ? active_slots(*this) : active;
  const std::size_t n = 3 * static_cast<std::size_t>(std::count(folded_active.begin(), folded_active.end(), 1));
  if (backend == Backend::dense && spare.size() < n * n)
    require_memory(n * n * sizeof(double), "a second matrix to fold into");
  steps_since_fold.clear();  // The Â taken along here knows every update so far, whatever became of an earlier fold.
  base_is_stale = fold_is_small = false;
  return [backend = backend, known = pattern_is_small ? nullptr : pattern, stiffness = stiffness,
          active = std::move(folded_active), dead = dead, into = std::make_shared<Buffer>(std::move(spare))]() {
    const auto fitting = known ? known : std::make_shared<const FactorPattern>(analyse(stiffness, active));
    return Folded{make_base(backend, fitting, stiffness, active, dead, std::move(*into), nullptr), fitting, active};
  };
}

void Compliance::Impl::adopt(Folded folded) {
  if (auto* dense = dynamic_cast<DenseBase*>(base.get())) spare = dense->take();
  base = std::move(folded.base);
  lay_out_rows(std::move(folded.pattern), std::move(folded.active));
  pattern_is_small = fold_is_small;
  std::vector<UpdateStep> steps;
  std::vector<std::uint32_t> rows;
  for (const SlotStep& step : steps_since_fold) {
    steps.push_back(enter(step));
    rows.insert(rows.end(), steps.back().rows.begin(), steps.back().rows.end());
  }
  steps_since_fold.clear();
  correction.extend(*base, rows);
  for (const UpdateStep& step : steps) correction.add(*base, step);
  if (is_lost(correction.factor()))
    refactor();
  else
    compact();
}

void Compliance::Impl::refactor() {
  std::vector<std::uint8_t> now_active = pattern_is_small ? active_slots(*this) : active;
  auto made = pattern_is_small ? std::make_shared<const FactorPattern>(analyse(stiffness, now_active)) : pattern;
  std::unique_ptr<ComplianceBase> fresh = make_base(Backend::sparse, made, stiffness, now_active, dead, {}, nullptr);
  if (fold.valid()) abandoned.push_back(std::move(fold));
  steps_since_fold.clear();
  pattern_is_small = base_is_stale = false;
  base = std::move(fresh);
  lay_out_rows(std::move(made), std::move(now_active));
  settle_islands({});
  compact();
}

// Splits leave dead slots behind, and blocks between vertices that no tet joins any more. Without this they would pile
// up for as long as an operation lasts.
void Compliance::Impl::compact() {
  std::vector<std::uint32_t> number(slots(), no_slot);
  std::uint32_t kept = 0;
  for (std::size_t s = 0; s < slots(); ++s)
    if (!dead[s] || active[s]) number[s] = kept++;
  if (slots() - kept < std::max<std::size_t>(64, slots() / 8)) return;
  const auto keep = [&](auto& values) {
    for (std::size_t s = 0; s < number.size(); ++s)
      if (number[s] != no_slot) values[number[s]] = values[s];
    values.resize(kept);
  };
  BlockMatrix smaller;
  smaller.row_start.push_back(0);
  for (std::size_t s = 0; s < slots(); ++s) {
    if (number[s] == no_slot) continue;
    for (std::uint32_t k = stiffness.row_start[s]; k < stiffness.row_start[s + 1]; ++k) {
      if (number[stiffness.column[k]] == no_slot || (stiffness.column[k] != s && stiffness.block[k].isZero(0)))
        continue;
      smaller.column.push_back(number[stiffness.column[k]]);
      smaller.block.push_back(stiffness.block[k]);
    }
    smaller.row_start.push_back(static_cast<std::uint32_t>(smaller.column.size()));
  }
  stiffness = std::move(smaller);
  keep(fixed);
  keep(dead);
  keep(active);
  keep(row_of_slot);
  keep(island_of_slot);
  for (std::uint32_t& slot : slot_of_row)
    if (slot != no_slot) slot = number[slot];
  for (std::uint32_t& slot : slot_of_vertex) slot = number[slot];
  for (Island& island : islands)
    for (std::uint32_t& slot : island.slots) slot = number[slot];
  regroup();
}

bool Compliance::Impl::is_lost(const CorrectionHealth& health) const {
  // Written so that a NaN is lost too.
  return !health.definite || (is_static ? !(health.smallest_eigenvalue >= 1e-10) : !(health.error <= 1e-4));
}

void Compliance::Impl::drop_abandoned() {
  std::erase_if(abandoned,
                [](const auto& late) { return late.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
}

bool Compliance::Impl::away_from_home() const {
  return backend == Backend::dense && dynamic_cast<const DenseBase*>(base.get()) == nullptr;
}

Compliance::Compliance(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Compliance::Compliance(Compliance&&) noexcept = default;
Compliance& Compliance::operator=(Compliance&&) noexcept = default;
Compliance::~Compliance() = default;

Backend Compliance::backend() const {
  return impl_->backend;
}
std::size_t Compliance::vertex_count() const {
  return impl_->slot_of_vertex.size();
}

MatrixXd Compliance::block(std::span<const DofId> rows, std::span<const DofId> columns) const {
  blas::use_one_thread();
  const std::vector<std::uint32_t> all_rows = impl_->rows_of(rows), all_columns = impl_->rows_of(columns);
  const auto slot_of = [&](std::uint32_t row) { return impl_->slot_of_row[row / 3]; };
  const auto asked_of_base = [&](std::uint32_t row) {
    return row != no_row && impl_->island_of_slot[slot_of(row)] < 0;
  };
  std::vector<std::uint32_t> base_rows, base_columns;
  std::copy_if(all_rows.begin(), all_rows.end(), std::back_inserter(base_rows), asked_of_base);
  std::copy_if(all_columns.begin(), all_columns.end(), std::back_inserter(base_columns), asked_of_base);
  const MatrixXd found = impl_->correction.block(*impl_->base, base_rows, base_columns);
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  Index c = 0;
  for (std::size_t j = 0; j < all_columns.size(); ++j) {
    if (all_columns[j] == no_row) continue;
    const std::uint32_t column_slot = slot_of(all_columns[j]), group = impl_->group[column_slot];
    Index r = 0;
    for (std::size_t i = 0; i < all_rows.size(); ++i) {
      if (all_rows[i] == no_row) continue;
      const std::uint32_t row_slot = slot_of(all_rows[i]);
      double& entry = result(static_cast<Index>(i), static_cast<Index>(j));
      if (impl_->group[row_slot] == group)
        entry = impl_->island_of_slot[row_slot] >= 0
                    ? impl_->island_entry(row_slot, all_rows[i] % 3, column_slot, all_columns[j] % 3)
                    : found(r, c);
      if (impl_->island_of_slot[row_slot] < 0) ++r;
    }
    if (impl_->island_of_slot[column_slot] < 0) ++c;
  }
  return result;
}

MatrixXd Compliance::apply(const MatrixXd& forces, int refinements) const {
  const std::size_t n = vertex_count();
  if (static_cast<std::size_t>(forces.rows()) != 3 * n)
    throw InputError("forces", "have " + std::to_string(forces.rows()) + " rows for " + std::to_string(n) + " vertices",
                     "give three a vertex");
  MatrixXd at_slots = MatrixXd::Zero(static_cast<Index>(3 * impl_->slots()), forces.cols());
  for (std::size_t v = 0; v < n; ++v) {
    const std::uint32_t slot = impl_->slot_of_vertex[v];
    if (!impl_->fixed[slot])
      at_slots.middleRows<3>(static_cast<Index>(3 * slot)) = forces.middleRows<3>(static_cast<Index>(3 * v));
  }
  const MatrixXd x = impl_->apply(at_slots, refinements);
  MatrixXd result(forces.rows(), forces.cols());
  for (std::size_t v = 0; v < n; ++v)
    result.middleRows<3>(static_cast<Index>(3 * v)) = x.middleRows<3>(static_cast<Index>(3 * impl_->slot_of_vertex[v]));
  return result;
}

MatrixXd Compliance::columns(std::span<const DofId> columns) const {
  MatrixXd unit = MatrixXd::Zero(static_cast<Index>(3 * vertex_count()), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k].index() >= 3 * vertex_count())
      throw InputError("dof " + std::to_string(columns[k].value), "is not in the mesh", "numbers count from 0");
    unit(columns[k].value, static_cast<Index>(k)) = 1;
  }
  return apply(unit, 1);
}

Displacements Compliance::solve(const std::vector<PointForce>& forces) const {
  MatrixXd f = MatrixXd::Zero(static_cast<Index>(3 * vertex_count()), 1);
  for (const PointForce& force : forces) {
    if (force.vertex.index() >= vertex_count())
      throw InputError("force on vertex " + std::to_string(force.vertex.value),
                       "the mesh has " + std::to_string(vertex_count()) + " vertices", "numbers count from 0");
    f.block<3, 1>(static_cast<Index>(3 * force.vertex.index()), 0) += force.force;
  }
  const MatrixXd u = apply(f, 1);
  Displacements result(vertex_count());
  for (std::size_t v = 0; v < result.size(); ++v) result[v] = u.block<3, 1>(static_cast<Index>(3 * v), 0);
  return result;
}

std::size_t Compliance::pending_rank() const {
  return impl_->away_from_home() || impl_->base_is_stale ? impl_->base->size() : impl_->correction.rows().size();
}

void Compliance::fold() {
  if (impl_->fold.valid()) adopt_fold();
  if (pending_rank() == 0) return;
  impl_->adopt(impl_->fold_work()());
}

void Compliance::reserve_fold() {
  const std::size_t n = impl_->base->size() * impl_->base->size();
  if (backend() != Backend::dense || impl_->spare.size() >= n) return;
  require_memory(n * sizeof(double), "a second matrix to fold into");
  impl_->spare = Buffer(room_for(impl_->base->size()));
  constexpr std::size_t page = 512;  // doubles
  parallel_blocks(n, std::size_t{1} << 20, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; i += page) impl_->spare.data()[i] = 0;
  });
}

void Compliance::start_fold() {
  impl_->drop_abandoned();
  if (impl_->fold.valid() || pending_rank() == 0) return;
  impl_->fold = std::async(std::launch::async, [work = impl_->fold_work()] {
    const BackgroundLane lane;
    return work();
  });
}

bool Compliance::fold_ready() const {
  return impl_->fold.valid() && impl_->fold.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void Compliance::adopt_fold() {
  if (impl_->fold.valid()) impl_->adopt(impl_->fold.get());
}

void Compliance::refresh(Progress* progress) {
  if (impl_->fold.valid()) impl_->fold.get();
  impl_->steps_since_fold.clear();
  impl_->build(progress);
}

std::uint64_t Compliance::bytes() const {
  return impl_->base->bytes() + impl_->spare.size() * sizeof(double) + impl_->correction.bytes();
}

std::uint64_t Compliance::factor_nonzeros() const {
  const auto* sparse = dynamic_cast<const SparseBase*>(impl_->base.get());
  return sparse ? static_cast<std::uint64_t>(sparse->factor().pattern().nonzeros) : 0;
}

namespace {

std::unique_ptr<Compliance::Impl> start(const Model& model, Backend backend) {
  auto impl = std::make_unique<Compliance::Impl>();
  impl->backend = backend;
  impl->is_static = model.dynamics().is_static();
  impl->fixed = model.fixed();
  impl->dead.assign(impl->slots(), 0);
  impl->slot_of_vertex.resize(impl->slots());
  std::iota(impl->slot_of_vertex.begin(), impl->slot_of_vertex.end(), 0u);
  std::vector<std::uint8_t> used(impl->slots(), 0);
  for (const Tet& tet : model.mesh().tets)
    for (const VertexId v : tet) used[v.index()] = 1;
  for (std::size_t s = 0; s < impl->slots(); ++s) impl->dead[s] = !used[s];
  impl->stiffness = model.step_stiffness();
  return impl;
}

void require_support(const Model& model) {
  if (!model.dynamics().is_static()) return;
  const std::string free = unsupported_part(model.mesh(), model.fixed());
  if (!free.empty()) throw InputError("static model", free, "add a [[fixed]] that holds it, or set time_step > 0");
}

}  // namespace

Compliance precompute(const Model& model, const PrecomputeOptions& options, Progress* progress) {
  blas::use_one_thread();
  require_support(model);
  require_memory(precompute_memory(model, options),
                 "the compliance of " + std::to_string(model.mesh().vertex_count()) + " vertices");
  std::unique_ptr<Compliance::Impl> impl = start(model, options.backend);
  impl->build(progress);
  return Compliance(std::move(impl));
}

std::uint64_t precompute_memory(const Model& model, const PrecomputeOptions& options) {
  std::uint64_t free_vertices = 0;
  for (const std::uint8_t fixed : model.fixed()) free_vertices += !fixed;
  const std::uint64_t n = 3 * free_vertices;
  const std::uint64_t stiffness = 1500 * free_vertices;  // about 14 blocks a row and its analysis
  if (options.backend == Backend::dense) return n * n * sizeof(double) + stiffness + 8 * 200 * n;
  // `calot bench growth`, compact organ: 0.70 M non-zeros at 1,208 vertices, 425 M at 104,392, peak 1.6 times their
  // size.
  const double nonzeros = 5.5 * std::pow(static_cast<double>(n), 1.44);
  return static_cast<std::uint64_t>(1.6 * nonzeros * sizeof(double)) + stiffness;
}

Compliance Compliance::from_rows(const Model& model, const std::function<void(VertexId, std::size_t, double*)>& read) {
  blas::use_one_thread();
  std::unique_ptr<Impl> impl = start(model, Backend::dense);
  impl->start_rows(std::make_shared<FactorPattern>(analyse(impl->stiffness, active_slots(*impl))));
  const std::size_t n = 3 * impl->slot_of_row.size(), width = 3 * impl->slots();
  require_memory(n * n * sizeof(double), "the compliance");
  Buffer matrix(n * n);
  constexpr std::size_t at_once = 16;
  std::vector<double> rows(3 * at_once * width);
  for (std::size_t first = 0; first < impl->slots(); first += at_once) {
    const std::size_t count = std::min(at_once, impl->slots() - first);
    read(VertexId(first), count, rows.data());
    for (std::size_t k = 0; k < 3 * count; ++k) {
      const std::int32_t row = impl->row_of_slot[first + k / 3];
      if (row < 0) continue;
      double* to = matrix.data() + (static_cast<std::size_t>(row) + k % 3) * n;  // symmetric: a row is a column
      for (const std::uint32_t slot : impl->slot_of_row)
        to = std::copy_n(rows.data() + k * width + 3 * std::size_t{slot}, 3, to);
    }
  }
  impl->base = std::make_unique<DenseBase>(std::move(matrix), n);
  return Compliance(std::move(impl));
}

const SparseFactor* Compliance::factor() const {
  const auto* sparse = dynamic_cast<const SparseBase*>(impl_->base.get());
  return sparse && impl_->backend == Backend::sparse ? &sparse->factor() : nullptr;
}

std::vector<VertexId> Compliance::factor_vertices() const {
  std::vector<std::int64_t> vertex_of_slot(impl_->slots(), -1);
  for (std::size_t v = 0; v < vertex_count(); ++v)
    vertex_of_slot[impl_->slot_of_vertex[v]] = static_cast<std::int64_t>(v);
  std::vector<VertexId> vertices;
  for (std::size_t s = 0; s < impl_->slots(); ++s)
    if (impl_->active[s])
      vertices.push_back(vertex_of_slot[s] < 0 ? VertexId::none()
                                               : VertexId(static_cast<std::size_t>(vertex_of_slot[s])));
  return vertices;
}

namespace {

// Every entry of Â must have its place in the pattern, or the next elimination would write where there is none.
void require_room_for(const BlockMatrix& matrix, const Compliance::Impl& impl) {
  const FactorPattern& f = *impl.pattern;
  for (std::size_t s = 0; s < matrix.rows(); ++s) {
    if (impl.row_of_slot[s] < 0) continue;
    const auto p = static_cast<std::uint32_t>(impl.row_of_slot[s] / 3);
    const std::span<const std::uint32_t> rows = f.rows_of(f.super_of[p]);
    for (std::uint32_t k = matrix.row_start[s]; k < matrix.row_start[s + 1]; ++k) {
      if (impl.row_of_slot[matrix.column[k]] < 0) continue;
      const auto q = static_cast<std::uint32_t>(impl.row_of_slot[matrix.column[k]] / 3);
      if (q > p && !matrix.block[k].isZero(0) && f.super_of[q] != f.super_of[p] &&
          !std::binary_search(rows.begin(), rows.end(), q))
        throw InputError("factor", "has no place for an entry of the model's stiffness",
                         "compute it again with `calot precompute --backend sparse`");
    }
  }
}

}  // namespace

Compliance Compliance::from_factor(const Model& model, SparseFactor factor) {
  blas::use_one_thread();
  std::unique_ptr<Impl> impl = start(model, Backend::sparse);
  const std::vector<std::uint8_t> active = active_slots(*impl);
  const auto free = static_cast<std::size_t>(std::count(active.begin(), active.end(), 1));
  if (factor.pattern().vertices() != free)
    throw InputError("factor",
                     "is of " + std::to_string(factor.pattern().vertices()) + " vertices, the model has " +
                         std::to_string(free) + " free ones",
                     "compute it again with `calot precompute --backend sparse`");
  impl->start_rows(factor.shared_pattern());
  require_room_for(impl->stiffness, *impl);
  impl->base = std::make_unique<SparseBase>(std::move(factor));
  Compliance compliance(std::move(impl));
  if (const double drift = compliance.probe(); !(drift < 1e-3))
    throw InputError("factor", "is not that of the model (residual " + std::to_string(drift) + ")",
                     "compute it again with `calot precompute --backend sparse`");
  return compliance;
}

void Compliance::copy_rows(VertexId first, std::size_t count, double* out) const {
  const std::size_t width = 3 * vertex_count();
  std::fill_n(out, 3 * count * width, 0.0);
  std::vector<DofId> dofs;
  for (std::size_t k = 0; k < 3 * count; ++k) dofs.push_back(DofId(3 * first.index() + k));
  const auto* dense = dynamic_cast<const DenseBase*>(impl_->base.get());
  if (!dense || pending_rank() > 0 || !impl_->islands.empty() || dense->appended() > 0) {
    const MatrixXd found = columns(dofs);
    std::copy_n(found.data(), found.size(), out);
    return;
  }
  const std::vector<std::uint32_t> rows = impl_->rows_of(dofs);
  parallel_for(rows.size(), [&](std::size_t k) {
    if (rows[k] == no_row) return;
    const double* from = dense->column(rows[k]);
    const std::uint32_t group = impl_->group[impl_->slot_of_row[rows[k] / 3]];
    for (std::size_t v = 0; v < vertex_count(); ++v) {
      const std::uint32_t slot = impl_->slot_of_vertex[v];
      if (impl_->group[slot] == group) std::copy_n(from + impl_->row_of_slot[slot], 3, out + k * width + 3 * v);
    }
  });
}

FullCompliance Compliance::full() const {
  FullCompliance result;
  result.vertices = vertex_count();
  require_memory(result.size() * result.size() * sizeof(double), "the whole matrix");
  result.values.resize(result.size() * result.size());
  constexpr std::size_t at_once = 64;
  for (std::size_t first = 0; first < result.vertices; first += at_once)
    copy_rows(VertexId(first), std::min(at_once, result.vertices - first), result.row(3 * first));
  return result;
}

}  // namespace calot
