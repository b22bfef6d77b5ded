#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/compliance/path_solve.h"
#include "calot/sim/warped_compliance.h"

namespace calot {
namespace {

using Index = Eigen::Index;
constexpr std::size_t contacts_at_once = 8;

std::size_t size(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// The vertices of a contact that are rows of the base.
template <class Visit>
void WarpedCompliance::each_base_vertex(const ContactRows& contact, const Visit& visit) const {
  for (std::size_t i = 0; i < contact.count; ++i) {
    const VertexId v = contact.vertices[i];
    const std::uint32_t slot = slot_of_vertex_[v.index()];
    if (slot < base_slots_ && free(slot)) visit(v, size(base_->row_of_slot[slot]), contact.weights[i]);
  }
}

// The supernodes that L⁻¹ Jᵀ of these contacts can reach.
std::vector<std::uint32_t> WarpedCompliance::path_of(std::span<const ContactRows> contacts) const {
  std::vector<std::uint32_t> positions;
  for (const ContactRows& contact : contacts)
    each_base_vertex(
        contact, [&](VertexId, std::size_t row, double) { positions.push_back(static_cast<std::uint32_t>(row / 3)); });
  return detail::elimination_path(*base_->pattern, positions);
}

// L⁻¹ P Jᵀ, turned back into the base's frame. Contacts close to each other go together, along their own paths.
template <class Real, class Factor>
void WarpedCompliance::spread_contacts(Spread<Real>& spread, const Factor& factor,
                                       std::span<const ContactRows> contacts) {
  const FactorPattern& pattern = *base_->pattern;
  const std::size_t n = factor.size();
  path_ = path_of(contacts);
  if (spread.columns.size() < 3 * contacts.size() * n) spread.columns.resize(3 * contacts.size() * n);
  for (std::size_t k = 0; k < 3 * contacts.size(); ++k)
    for (const std::uint32_t s : path_)
      std::fill_n(spread.columns.data() + n * k + 3 * std::size_t{pattern.super_start[s]}, 3 * pattern.own(s), Real{0});
  for (std::size_t k = 0; k < contacts.size(); ++k)
    each_base_vertex(contacts[k], [&](VertexId v, std::size_t row, double weight) {
      const Mat3 turned = weight * turn_[v.index()].transpose() * contacts[k].frame;
      for (Index c = 0; c < 3; ++c)
        for (Index axis = 0; axis < 3; ++axis)
          spread.columns[n * (3 * k + size(c)) + row + size(axis)] += static_cast<Real>(turned(axis, c));
    });
  const std::size_t groups = (contacts.size() + contacts_at_once - 1) / contacts_at_once;
  spread.work.resize(std::max(groups, spread.work.size()));
  parallel_for(groups, [&](std::size_t g) {
    const std::size_t first = contacts_at_once * g, count = std::min(contacts_at_once, contacts.size() - first);
    detail::forward_on_path(factor, path_of(contacts.subspan(first, count)), spread.columns.data() + n * 3 * first, n,
                            3 * count, spread.work[g]);
  });
}

// C0_TJ, 3|T|×3k.
template <class Real>
Eigen::MatrixXd WarpedCompliance::touched_by(const Spread<Real>& spread, std::span<const ContactRows> contacts) const {
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  const std::size_t n = base_->single.size(), columns = 3 * contacts.size();
  const std::vector<std::uint32_t>& rows = base_->ready.rows();
  Matrix packed = Matrix::Zero(static_cast<Index>(rows.size()), static_cast<Index>(columns));
  std::vector<std::uint8_t> on_path(base_->pattern->supernodes(), 0);
  for (const std::uint32_t s : path_) on_path[s] = 1;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (on_path[base_->pattern->super_of[rows[i] / 3]])
      for (std::size_t k = 0; k < columns; ++k)
        packed(static_cast<Index>(i), static_cast<Index>(k)) = spread.columns[n * k + rows[i]];
  const Matrix all = base_->ready.against(packed);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * static_cast<Index>(touched_.size()), static_cast<Index>(columns));
  for (std::size_t t = 0; t < touched_.size(); ++t)
    if (touched_[t] < base_slots_)
      result.middleRows<3>(3 * static_cast<Index>(t)) =
          all.template middleRows<3>(
                 base_->ready.column_of(static_cast<std::uint32_t>(base_->row_of_slot[touched_[t]])))
              .template cast<double>();
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t i = 0; i < contacts[k].count; ++i) {
      const VertexId v = contacts[k].vertices[i];
      const std::uint32_t slot = slot_of_vertex_[v.index()];
      if (slot < base_slots_ || !free(slot) || place_[slot] < 0) continue;
      result.block<3, 3>(3 * Index{place_[slot]}, 3 * static_cast<Index>(k)) +=
          contacts[k].weights[i] / own_stiffness_ * turn_[v.index()].transpose() * contacts[k].frame;
    }
  return result;
}

// What slots that came later add by themselves: 1/σ.
void WarpedCompliance::add_later_slots(std::span<const ContactRows> contacts, Eigen::MatrixXd& w) const {
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t i = 0; i < contacts[k].count; ++i) {
      const VertexId v = contacts[k].vertices[i];
      const std::uint32_t slot = slot_of_vertex_[v.index()];
      if (slot < base_slots_ || !free(slot)) continue;
      for (std::size_t m = 0; m < contacts.size(); ++m)
        for (std::size_t j = 0; j < contacts[m].count; ++j)
          if (v == contacts[m].vertices[j])
            w.block<3, 3>(3 * static_cast<Index>(k), 3 * static_cast<Index>(m)) +=
                contacts[k].weights[i] * contacts[m].weights[j] / own_stiffness_ * contacts[k].frame.transpose() *
                contacts[m].frame;
    }
}

template <class Real, class Factor>
Eigen::MatrixXd WarpedCompliance::delassus_with(Spread<Real>& spread, const Factor& factor,
                                                std::span<const ContactRows> contacts) {
  spread_contacts(spread, factor, contacts);
  const FactorPattern& pattern = *base_->pattern;
  const std::size_t n = factor.size(), columns = 3 * contacts.size();
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix sum = Matrix::Zero(static_cast<Index>(columns), static_cast<Index>(columns));
  for (const std::uint32_t s : path_) {
    const Real* part = spread.columns.data() + 3 * std::size_t{pattern.super_start[s]};
    blas::gemm('T', 'N', columns, columns, 3 * pattern.own(s), Real{1}, part, n, part, n, Real{1}, sum.data(), columns);
  }
  Eigen::MatrixXd w = sum.template cast<double>();
  add_later_slots(contacts, w);
  if (!touched_.empty()) {
    const Eigen::MatrixXd seen = touched_by(spread, contacts);
    Eigen::MatrixXd through(seen.rows(), seen.cols());
    blas::gemm('N', 'N', size(seen.rows()), columns, size(seen.rows()), 1.0, correction_.data(), size(seen.rows()),
               seen.data(), size(seen.rows()), 0.0, through.data(), size(seen.rows()));
    blas::gemm('T', 'N', columns, columns, size(seen.rows()), -1.0, seen.data(), size(seen.rows()), through.data(),
               size(seen.rows()), 1.0, w.data(), columns);
  }
  return 0.5 * (w + w.transpose());
}

Eigen::MatrixXd WarpedCompliance::delassus(std::span<const ContactRows> contacts) {
  blas::use_one_thread();
  std::vector<std::pair<std::size_t, std::size_t>> order;  // by the first row that a contact has
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    std::size_t first = ~std::size_t{0};
    each_base_vertex(contacts[k], [&](VertexId, std::size_t row, double) { first = std::min(first, row); });
    order.emplace_back(first, k);
  }
  std::sort(order.begin(), order.end());
  std::vector<ContactRows> sorted;
  for (const auto& [row, k] : order) sorted.push_back(contacts[k]);
  const Eigen::MatrixXd w = precision_ == Precision::twice ? delassus_with(spread_double_, base_->factor, sorted)
                                                           : delassus_with(spread_single_, base_->single, sorted);
  Eigen::MatrixXd result(w.rows(), w.cols());
  for (std::size_t k = 0; k < order.size(); ++k)
    for (std::size_t m = 0; m < order.size(); ++m)
      result.block<3, 3>(3 * static_cast<Index>(order[k].second), 3 * static_cast<Index>(order[m].second)) =
          w.block<3, 3>(3 * static_cast<Index>(k), 3 * static_cast<Index>(m));
  return result;
}

}  // namespace calot
