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

// Jᵀ in the base's order of rows, turned back into its frame; `path` gets the supernodes that L⁻¹ Jᵀ can reach.
void WarpedCompliance::spread_contacts(std::span<const ContactRows> contacts) {
  const FactorPattern& pattern = *base_->pattern;
  std::vector<std::uint32_t> positions;
  for (const ContactRows& contact : contacts)
    for (std::size_t i = 0; i < contact.count; ++i)
      if (const std::uint32_t slot = slot_of_vertex_[contact.vertices[i].index()]; slot < base_slots_ && free(slot))
        positions.push_back(static_cast<std::uint32_t>(base_->row_of_slot[slot] / 3));
  path_ = detail::elimination_path(pattern, positions);
  const std::size_t n = base_->single.size();
  if (spread_.size() < 3 * contacts.size() * n) spread_.resize(3 * contacts.size() * n);
  for (std::size_t k = 0; k < 3 * contacts.size(); ++k)
    for (const std::uint32_t s : path_)
      std::fill_n(spread_.data() + n * k + 3 * std::size_t{pattern.super_start[s]}, 3 * pattern.own(s), 0.0f);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t i = 0; i < contacts[k].count; ++i) {
      const VertexId v = contacts[k].vertices[i];
      const std::uint32_t slot = slot_of_vertex_[v.index()];
      if (slot >= base_slots_ || !free(slot)) continue;
      const Mat3 turned = contacts[k].weights[i] * turn_[v.index()].transpose() * contacts[k].frame;
      for (Index c = 0; c < 3; ++c)
        for (Index axis = 0; axis < 3; ++axis)
          spread_[n * (3 * k + size(c)) + size(base_->row_of_slot[slot] + axis)] += static_cast<float>(turned(axis, c));
    }
}

// C0_TJ, 3|T|×3k.
Eigen::MatrixXd WarpedCompliance::touched_by(std::span<const ContactRows> contacts) const {
  const std::size_t n = base_->single.size(), columns = 3 * contacts.size();
  const std::vector<std::uint32_t>& rows = base_->ready.rows();
  Eigen::MatrixXf packed = Eigen::MatrixXf::Zero(static_cast<Index>(rows.size()), static_cast<Index>(columns));
  std::vector<std::uint8_t> on_path(base_->pattern->supernodes(), 0);
  for (const std::uint32_t s : path_) on_path[s] = 1;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (on_path[base_->pattern->super_of[rows[i] / 3]])
      for (std::size_t k = 0; k < columns; ++k)
        packed(static_cast<Index>(i), static_cast<Index>(k)) = spread_[n * k + rows[i]];
  const Eigen::MatrixXf all = base_->ready.against(packed);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * static_cast<Index>(touched_.size()), static_cast<Index>(columns));
  for (std::size_t t = 0; t < touched_.size(); ++t)
    if (touched_[t] < base_slots_)
      result.middleRows<3>(3 * static_cast<Index>(t)) =
          all.middleRows<3>(base_->ready.column_of(static_cast<std::uint32_t>(base_->row_of_slot[touched_[t]])))
              .cast<double>();
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

Eigen::MatrixXd WarpedCompliance::delassus(std::span<const ContactRows> contacts) {
  blas::use_one_thread();
  const std::size_t n = base_->single.size(), columns = 3 * contacts.size();
  spread_contacts(contacts);
  const FactorPattern& pattern = *base_->pattern;
  const std::size_t groups = (contacts.size() + contacts_at_once - 1) / contacts_at_once;
  group_work_.resize(std::max(groups, group_work_.size()));
  parallel_for(groups, [&](std::size_t g) {
    const std::size_t first = 3 * contacts_at_once * g, last = std::min(columns, first + 3 * contacts_at_once);
    detail::forward_on_path(base_->single, path_, spread_.data() + n * first, n, last - first, group_work_[g]);
  });
  Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(static_cast<Index>(columns), static_cast<Index>(columns));
  for (const std::uint32_t s : path_) {
    const float* part = spread_.data() + 3 * std::size_t{pattern.super_start[s]};
    blas::gemm('T', 'N', columns, columns, 3 * pattern.own(s), 1.0f, part, n, part, n, 1.0f, sum.data(), columns);
  }
  Eigen::MatrixXd w = sum.cast<double>();
  add_later_slots(contacts, w);
  if (!touched_.empty()) {
    const Eigen::MatrixXd seen = touched_by(contacts);
    Eigen::MatrixXd through(seen.rows(), seen.cols());
    blas::gemm('N', 'N', size(seen.rows()), columns, size(seen.rows()), 1.0, correction_.data(), size(seen.rows()),
               seen.data(), size(seen.rows()), 0.0, through.data(), size(seen.rows()));
    blas::gemm('T', 'N', columns, columns, size(seen.rows()), -1.0, seen.data(), size(seen.rows()), through.data(),
               size(seen.rows()), 1.0, w.data(), columns);
  }
  return 0.5 * (w + w.transpose());
}

}  // namespace calot
