#include "calot/sim/warped_compliance.h"

#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/compliance/path_solve.h"

namespace calot {
namespace {

constexpr std::uint32_t none = ~0u;
using Index = Eigen::Index;

// A·B, single-threaded, on whatever the processor does best.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd c(a.rows(), b.cols());
  if (c.size() == 0) return c;
  const auto size = [](Index i) { return static_cast<std::size_t>(i); };
  if (a.cols() == 0) return Eigen::MatrixXd::Zero(a.rows(), b.cols());
  blas::gemm('N', 'N', size(a.rows()), size(b.cols()), size(a.cols()), 1.0, a.data(), size(a.rows()), b.data(),
             size(b.rows()), 0.0, c.data(), size(c.rows()));
  return c;
}

Eigen::Quaterniond mean_rotation(const VertexTets& around, std::size_t v,
                                 std::span<const Eigen::Quaterniond> rotations) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (std::uint32_t k = around.start[v]; k < around.start[v + 1]; ++k) {
    const Eigen::Vector4d& q = rotations[around.tets[k].index()].coeffs();
    if (sum.dot(q) < 0)
      sum -= q;
    else
      sum += q;
  }
  const double length = sum.norm();
  return length > 1e-12 ? Eigen::Quaterniond(Eigen::Vector4d(sum / length)) : Eigen::Quaterniond::Identity();
}

}  // namespace

std::vector<Eigen::Quaterniond> vertex_rotations(const VertexTets& around,
                                                 std::span<const Eigen::Quaterniond> of_tets) {
  std::vector<Eigen::Quaterniond> result(around.start.size() - 1);
  parallel_blocks(result.size(), 512, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t v = begin; v < end; ++v) result[v] = mean_rotation(around, v, of_tets);
  });
  return result;
}

WarpedCompliance::WarpedCompliance(const BaseRequest& request)
    : base_slots_(request.model.mesh().vertex_count()),
      fixed_(request.model.fixed()),
      tet_rotation_(request.rotations),
      slot_rotation_(vertex_rotations(vertex_tets(request.model.mesh()), request.rotations)) {
  const double young = request.model.materials().begin()->second.young;
  const Dynamics& dynamics = request.model.dynamics();
  const std::vector<double> masses = request.model.vertex_masses();
  double mass = 0;
  for (const double m : masses) mass += m;
  // Of the size of Â's diagonal: a spring across a millimetre or two of tissue, and the mean inertia.
  own_stiffness_ = young * 2e-3 + dynamics.mass_factor() * mass / static_cast<double>(masses.size());
  origin_.resize(base_slots_);
  for (std::size_t s = 0; s < base_slots_; ++s) origin_[s] = static_cast<std::uint32_t>(s);
  slot_of_vertex_ = vertex_of_slot_ = origin_;
  place_.assign(base_slots_, -1);
  pending_.place.assign(base_slots_, -1);
  damping_factor_ = 1 / dynamics.time_step;
  for (const Spring& spring : request.springs) springs_.push_back(entry_of(spring));
}

void WarpedCompliance::Change::add(std::uint32_t a, std::uint32_t b, const Mat3& value, bool leaves) {
  for (const std::uint32_t slot : {a, b})
    if (place[slot] < 0) {
      place[slot] = static_cast<std::int32_t>(slots.size());
      slots.push_back(slot);
    }
  blocks.push_back({a, b, value, leaves});
}

Eigen::MatrixXd WarpedCompliance::Change::sum(double kept) const {
  const Index width = 3 * static_cast<Index>(slots.size());
  Eigen::MatrixXd delta = Eigen::MatrixXd::Zero(width, width);
  for (const Block& block : blocks)
    delta.block<3, 3>(3 * Index{place[block.a]}, 3 * Index{place[block.b]}) +=
        block.leaves ? Mat3((1 - kept) * block.value) : block.value;
  return delta;
}

const Eigen::Quaterniond& WarpedCompliance::base_rotation(std::uint32_t slot) const {
  return slot_rotation_[origin_[slot]];
}

void WarpedCompliance::add_slots(const Remap& remap) {
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& from = remap.added_from[k];
    const std::uint32_t origin = slot_of_vertex_[(from.weight < 0.5 ? from.from : from.to).index()];
    origin_.push_back(origin_[origin]);
    fixed_.push_back(fixed_[slot_of_vertex_[from.from.index()]] && fixed_[slot_of_vertex_[from.to.index()]]);
    place_.push_back(-1);
    pending_.place.push_back(-1);
    vertex_of_slot_.push_back(none);
  }
}

void WarpedCompliance::follow(const std::vector<ElementChange>& changes, const Remap& remap) {
  mixes_parts_ =
      mixes_parts_ || std::any_of(remap.tet_to_new.begin(), remap.tet_to_new.end(), [](TetId t) { return !t.valid(); });
  const std::vector<std::uint32_t> slots_before = slot_of_vertex_;
  const auto first_new = static_cast<std::uint32_t>(origin_.size());
  add_slots(remap);
  slot_of_vertex_.assign(remap.vertex_to_old.size(), none);
  for (std::size_t v = 0; v < slot_of_vertex_.size(); ++v)
    if (remap.vertex_to_old[v].valid()) slot_of_vertex_[v] = slots_before[remap.vertex_to_old[v].index()];
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k)
    slot_of_vertex_[remap.added_vertices[k].index()] = first_new + static_cast<std::uint32_t>(k);
  std::fill(vertex_of_slot_.begin(), vertex_of_slot_.end(), none);
  for (std::size_t v = 0; v < slot_of_vertex_.size(); ++v)
    vertex_of_slot_[slot_of_vertex_[v]] = static_cast<std::uint32_t>(v);

  // A slot that comes later stands in the base with σ I alone, one that dies ends with it.
  for (std::uint32_t s = first_new; s < origin_.size(); ++s)
    if (free(s)) pending_.add(s, s, -own_stiffness_ * Mat3::Identity());
  for (const VertexId v : remap.orphaned)
    if (const std::uint32_t s = slots_before[v.index()]; free(s)) pending_.add(s, s, own_stiffness_ * Mat3::Identity());
  for (const ElementChange& change : changes) {
    const Mat3 r = tet_rotation_[change.tet.index()].toRotationMatrix();
    const std::vector<std::uint32_t>& slot_of = change.enters ? slot_of_vertex_ : slots_before;
    for (Index a = 0; a < 4; ++a)
      for (Index b = 0; b < 4; ++b) {
        const std::uint32_t sa = slot_of[change.vertices[static_cast<std::size_t>(a)].index()],
                            sb = slot_of[change.vertices[static_cast<std::size_t>(b)].index()];
        if (!free(sa) || !free(sb)) continue;
        const Mat3 block = r * change.stiffness.block<3, 3>(3 * a, 3 * b) * r.transpose();
        pending_.add(sa, sb, change.enters ? block : Mat3(-block), !change.enters);
      }
  }
  std::vector<Eigen::Quaterniond> rotations(remap.tet_to_old.size(), Eigen::Quaterniond::Identity());
  for (std::size_t t = 0; t < rotations.size(); ++t)
    if (remap.tet_to_old[t].valid()) rotations[t] = tet_rotation_[remap.tet_to_old[t].index()];
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    rotations[remap.added_tets[k].index()] = tet_rotation_[remap.added_parents[k].index()];
  tet_rotation_ = std::move(rotations);
}

void WarpedCompliance::add_spring(const SpringEntry& spring, double sign) {
  const bool a = free(spring.a), b = spring.b != none && free(spring.b);
  const bool leaves = sign < 0;
  mixes_parts_ = mixes_parts_ || (leaves && a && b);
  if (a) pending_.add(spring.a, spring.a, sign * spring.stiffness, leaves);
  if (b) pending_.add(spring.b, spring.b, sign * spring.stiffness, leaves);
  if (a && b) {
    pending_.add(spring.a, spring.b, -sign * spring.stiffness, leaves);
    pending_.add(spring.b, spring.a, -sign * spring.stiffness, leaves);
  }
}

WarpedCompliance::SpringEntry WarpedCompliance::entry_of(const Spring& spring) const {
  return {slot_of_vertex_[spring.vertex.index()], spring.other.valid() ? slot_of_vertex_[spring.other.index()] : none,
          (1 + spring.damping * damping_factor_) * spring.stiffness};
}

void WarpedCompliance::set_springs(std::span<const Spring> springs) {
  std::vector<SpringEntry> now;
  now.reserve(springs.size());
  for (const Spring& spring : springs) now.push_back(entry_of(spring));
  const auto same = [](const SpringEntry& x, const SpringEntry& y) {
    return x.a == y.a && x.b == y.b && (x.stiffness - y.stiffness).norm() <= 0.05 * y.stiffness.norm();
  };
  if (std::equal(now.begin(), now.end(), springs_.begin(), springs_.end(), same)) return;
  std::vector<std::uint8_t> kept(springs_.size(), 0);
  std::vector<SpringEntry> fresh, all;
  for (const SpringEntry& spring : now) {
    const auto old =
        std::find_if(springs_.begin(), springs_.end(), [&](const SpringEntry& s) { return same(spring, s); });
    if (old != springs_.end() && !kept[static_cast<std::size_t>(old - springs_.begin())]) {
      kept[static_cast<std::size_t>(old - springs_.begin())] = 1;
      all.push_back(*old);
    } else {
      add_spring(spring, 1);
      all.push_back(spring);
    }
  }
  for (std::size_t k = 0; k < springs_.size(); ++k)
    if (!kept[k]) add_spring(springs_[k], -1);
  springs_ = std::move(all);
}

void WarpedCompliance::set_base(std::unique_ptr<WarpedBase> base) {
  base_ = std::move(base);
  precision_ = Precision::compact;
}

std::vector<std::uint32_t> WarpedCompliance::touched_rows(const WarpedBase& base) const {
  std::vector<std::uint32_t> rows;
  for (const std::vector<std::uint32_t>* slots : {&touched_, &pending_.slots})
    for (const std::uint32_t slot : *slots)
      if (slot < base_slots_ && base.row_of_slot[slot] >= 0)
        rows.push_back(static_cast<std::uint32_t>(base.row_of_slot[slot]));
  return rows;
}

// C0 between slots; later ones are alone with 1/σ.
Eigen::MatrixXd WarpedCompliance::base_block(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const {
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(3 * static_cast<Index>(a.size()), 3 * static_cast<Index>(b.size()));
  const auto column = [&](std::uint32_t slot) {
    return slot < base_slots_ ? base_->ready.column_of(static_cast<std::uint32_t>(base_->row_of_slot[slot])) : -1;
  };
  std::vector<std::int32_t> column_a(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) column_a[i] = column(a[i]);
  for (std::size_t j = 0; j < b.size(); ++j) {
    const std::int32_t cb = column(b[j]);
    for (std::size_t i = 0; i < a.size(); ++i) {
      auto target = block.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j));
      if (column_a[i] >= 0 && cb >= 0)
        target = base_->ready.compliance().block<3, 3>(column_a[i], cb);
      else if (a[i] == b[j])
        target = Mat3::Identity() / own_stiffness_;
    }
  }
  return block;
}

// k = δ (I + C δ)⁻¹. Tissue that comes off, held by nothing but its mass, makes that matrix nearly singular, more so
// than single precision bears, and in the end double precision: then a trace of what leaves stays, until the next base.
// Stiff jaws on tissue that gives way easily make it large instead: C − C k C then loses as many digits.
Eigen::MatrixXd WarpedCompliance::middle(const Eigen::MatrixXd& compliance) {
  constexpr double most_in_compact = 2, most_cancelled_in_compact = 20;
  constexpr double most_in_single = 20, most_cancelled_in_single = 1000, most_in_double = 1e7, kept_share = 1e-6;
  double amplified = 0, cancelled = 0;
  const auto attempt = [&](double kept) {
    const Eigen::MatrixXd delta = pending_.sum(kept);
    Eigen::MatrixXd system = product(compliance, delta);
    system.diagonal().array() += 1;
    cancelled = system.cwiseAbs().maxCoeff();
    const Eigen::MatrixXd inverse =
        system.partialPivLu().solve(Eigen::MatrixXd::Identity(system.rows(), system.cols()));
    amplified = inverse.cwiseAbs().maxCoeff();
    const Eigen::MatrixXd k = product(delta, inverse);
    return Eigen::MatrixXd(0.5 * (k + k.transpose()));
  };
  Eigen::MatrixXd k = attempt(0);
  if (!(amplified < most_in_double)) k = attempt(kept_share);
  if (amplified > most_in_single || cancelled > most_cancelled_in_single)
    precision_ = Precision::twice;
  else if (amplified > most_in_compact || cancelled > most_cancelled_in_compact)
    precision_ = std::max(precision_, Precision::single);
  return k;
}

// K' = K + V k Vᵀ for the change δ on the slots U, with C' the compliance before it:
// k = δ (I + C'_UU δ)⁻¹ and C'_:U = C0_:T V, so that V = [−K C0_TU; 1 at U].
void WarpedCompliance::settle() {
  if (pending_.slots.empty()) return;
  const std::vector<std::uint32_t> slots = pending_.slots;
  std::vector<std::uint32_t> rows;
  for (const std::uint32_t slot : slots)
    if (slot < base_slots_) rows.push_back(static_cast<std::uint32_t>(base_->row_of_slot[slot]));
  base_->ready.add(base_->factor, rows);
  const Index width = 3 * static_cast<Index>(slots.size()), before = 3 * static_cast<Index>(touched_.size());
  const Eigen::MatrixXd across = base_block(touched_, slots);
  const Eigen::MatrixXd through = product(correction_, across);
  Eigen::MatrixXd compliance = base_block(slots, slots);
  if (before > 0) compliance -= product(across.transpose(), through);
  const Eigen::MatrixXd k = middle(compliance);

  for (const std::uint32_t slot : slots)
    if (place_[slot] < 0) {
      place_[slot] = static_cast<std::int32_t>(touched_.size());
      touched_.push_back(slot);
    }
  const Index after = 3 * static_cast<Index>(touched_.size());
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(after, width);
  v.topRows(before) = -through;
  for (std::size_t i = 0; i < slots.size(); ++i)
    v.block<3, 3>(3 * Index{place_[slots[i]]}, 3 * static_cast<Index>(i)) += Mat3::Identity();
  Eigen::MatrixXd grown = product(product(v, k), v.transpose());
  grown.topLeftCorner(before, before) += correction_;
  correction_ = std::move(grown);
  for (const std::uint32_t slot : slots) pending_.place[slot] = -1;
  pending_.slots.clear();
  pending_.blocks.clear();
  gather_touched();
}

void WarpedCompliance::gather_touched() {
  std::vector<std::uint32_t> positions;
  for (const std::uint32_t slot : touched_)
    if (slot < base_slots_) positions.push_back(static_cast<std::uint32_t>(base_->row_of_slot[slot] / 3));
  touched_path_ = detail::elimination_path(*base_->pattern, positions);
  if (precision_ == Precision::twice)
    double_.correction = correction_;
  else
    single_.correction = correction_.cast<float>();
}

void WarpedCompliance::turn(std::span<const Eigen::Quaterniond> vertex_rotations) {
  turn_.resize(vertex_rotations.size());
  for (std::size_t v = 0; v < turn_.size(); ++v)
    turn_[v] = (vertex_rotations[v] * base_rotation(slot_of_vertex_[v]).conjugate()).toRotationMatrix();
}

// K C0_T: f from C0 f; later slots stand alone.
template <class Real>
void WarpedCompliance::hold(Solver<Real>& solver, std::span<const Vec3> f) const {
  const std::size_t columns = 3 * touched_.size();
  solver.at_touched.resize(static_cast<Index>(columns));
  solver.answer.resize(static_cast<Index>(columns));
  for (std::size_t k = 0; k < touched_.size(); ++k) {
    const std::uint32_t slot = touched_[k];
    auto target = solver.at_touched.template segment<3>(3 * static_cast<Index>(k));
    if (slot < base_slots_) {
      for (Index i = 0; i < 3; ++i) target[i] = solver.held[static_cast<std::size_t>(base_->row_of_slot[slot] + i)];
      continue;
    }
    target.setZero();
    if (const std::uint32_t v = vertex_of_slot_[slot]; v != none)
      target = (turn_[v].transpose() * f[v] / own_stiffness_).template cast<Real>();
  }
  blas::gemv('N', columns, columns, solver.correction.data(), columns, solver.at_touched.data(), solver.answer.data());
}

// C' f = C0 (f − K C0_T: f): a solve, and along T's paths another.
template <class Real, class Factor>
void WarpedCompliance::apply_with(Solver<Real>& solver, const Factor& factor, std::span<const Vec3> f,
                                  std::span<Vec3> x) const {
  solver.x.assign(factor.size(), Real{0});
  for (std::size_t v = 0; v < f.size(); ++v) {
    const std::uint32_t slot = slot_of_vertex_[v];
    if (slot >= base_slots_ || base_->row_of_slot[slot] < 0) continue;
    const Vec3 turned = turn_[v].transpose() * f[v];
    for (int i = 0; i < 3; ++i)
      solver.x[static_cast<std::size_t>(base_->row_of_slot[slot] + i)] = static_cast<Real>(turned[i]);
  }
  detail::forward_vector(factor, solver.x.data(), solver.work);
  if (!touched_.empty()) {
    solver.held = solver.x;
    detail::backward_vector(factor, touched_path_, solver.held.data(), solver.work);
    hold(solver, f);
    std::fill(solver.held.begin(), solver.held.end(), Real{0});
    for (std::size_t k = 0; k < touched_.size(); ++k)
      for (Index i = 0; i < 3 && touched_[k] < base_slots_; ++i)
        solver.held[static_cast<std::size_t>(base_->row_of_slot[touched_[k]] + i)] =
            solver.answer[3 * static_cast<Index>(k) + i];
    detail::forward_vector(factor, touched_path_, solver.held.data(), solver.work);
    for (std::size_t i = 0; i < solver.x.size(); ++i) solver.x[i] -= solver.held[i];
  }
  detail::backward_vector(factor, solver.x.data(), solver.work);
  for (std::size_t v = 0; v < x.size(); ++v) {
    const std::uint32_t slot = slot_of_vertex_[v];
    if (!free(slot)) {
      x[v].setZero();
    } else if (slot < base_slots_) {
      const Real* from = solver.x.data() + base_->row_of_slot[slot];
      x[v] = turn_[v] * Vec3(static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2]));
    } else {
      Vec3 held = Vec3::Zero();
      if (place_[slot] >= 0) held = solver.answer.template segment<3>(3 * Index{place_[slot]}).template cast<double>();
      x[v] = (f[v] - turn_[v] * held) / own_stiffness_;
    }
  }
}

void WarpedCompliance::apply(std::span<const Vec3> f, std::span<Vec3> x, Use use) {
  if (precision_ == Precision::twice)
    apply_with(double_, base_->factor, f, x);
  else if (precision_ == Precision::single || use == Use::answer)
    apply_with(single_, base_->single, f, x);
  else
    apply_with(single_, base_->compact, f, x);
}

}  // namespace calot
