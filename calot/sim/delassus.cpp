#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/sim/warped_compliance.h"

namespace calot {
namespace {

using Index = Eigen::Index;
constexpr std::size_t lanes = FloatFactor::lanes;
constexpr std::size_t contacts_in_group = lanes / 3;

// Up to five contacts whose columns go through the factor together.
struct Group {
  std::vector<float> x;              // 16 lanes a row: L⁻¹ P Jᵀ
  std::vector<std::uint32_t> path;   // supernodes where it isn't zero, ascending
  std::vector<float> work;
};

// The rows of two groups' common supernodes: Σ x_a x_bᵀ, 16×16. Sums are kept in double over short runs.
void add_products(const FactorPattern& pattern, const Group& a, const Group& b, Eigen::MatrixXd& out) {
  out.setZero(lanes, lanes);
  std::vector<std::uint32_t> common;
  std::set_intersection(a.path.begin(), a.path.end(), b.path.begin(), b.path.end(), std::back_inserter(common));
  Eigen::Matrix<float, lanes, lanes> part;
  for (const std::uint32_t s : common) {
    const Index first = 3 * Index{pattern.super_start[s]}, rows = 3 * static_cast<Index>(pattern.own(s));
    const Eigen::Map<const Eigen::Matrix<float, lanes, Eigen::Dynamic>> xa(a.x.data() + Index{lanes} * first, lanes, rows),
        xb(b.x.data() + Index{lanes} * first, lanes, rows);
    part.noalias() = xa * xb.transpose();
    out += part.cast<double>();
  }
}

}  // namespace

Eigen::MatrixXd WarpedCompliance::delassus(std::span<const ContactRows> contacts) {
  const auto size = 3 * static_cast<Index>(contacts.size());
  const FactorPattern& pattern = *base_->pattern;
  const std::size_t group_count = (contacts.size() + contacts_in_group - 1) / contacts_in_group;
  std::vector<Group> groups(group_count);
  const auto touched = 3 * static_cast<Index>(touched_.size());
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(touched, size);  // C0_TJ
  parallel_for(group_count, [&](std::size_t g) {
    Group& group = groups[g];
    group.x.assign(lanes * base_->single.size(), 0.0f);
    std::vector<std::uint32_t> starts;
    const std::size_t first = g * contacts_in_group, last = std::min(contacts.size(), first + contacts_in_group);
    for (std::size_t k = first; k < last; ++k)
      for (std::size_t i = 0; i < contacts[k].count; ++i) {
        const VertexId v = contacts[k].vertices[i];
        const std::uint32_t slot = slot_of_vertex_[v.index()];
        if (!free(slot)) continue;
        const Mat3 turned = contacts[k].weights[i] * turn_[v.index()].transpose() * contacts[k].frame;
        if (slot >= base_slots_) {
          if (place_[slot] >= 0)
            seen.block<3, 3>(3 * Index{place_[slot]}, 3 * static_cast<Index>(k)) += turned / own_stiffness_;
          continue;
        }
        const auto row = static_cast<std::size_t>(base_->row_of_slot[slot]);
        starts.push_back(pattern.super_of[row / 3]);
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (std::size_t c = 0; c < 3; ++c)
            group.x[lanes * (row + axis) + 3 * (k - first) + c] +=
                static_cast<float>(turned(static_cast<Index>(axis), static_cast<Index>(c)));
      }
    base_->single.forward_many(group.x.data(), starts, group.path, group.work);
    if (touched == 0) return;
    const std::vector<std::uint32_t>& rows = base_->ready.rows();
    Eigen::Matrix<float, lanes, Eigen::Dynamic> packed(lanes, static_cast<Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      packed.col(static_cast<Index>(i)) = Eigen::Map<const Eigen::Matrix<float, lanes, 1>>(group.x.data() + lanes * rows[i]);
    for (std::size_t t = 0; t < touched_.size(); ++t) {
      if (touched_[t] >= base_slots_) continue;
      const std::int32_t column = base_->ready.column_of(static_cast<std::uint32_t>(base_->row_of_slot[touched_[t]]));
      for (Index c = 0; c < 3; ++c) {
        const Eigen::Matrix<float, lanes, 1> value =
            packed * Eigen::Map<const Eigen::VectorXf>(base_->ready.column(column + c), packed.cols());
        for (std::size_t l = 0; l < 3 * (last - first); ++l)
          seen(3 * static_cast<Index>(t) + c, 3 * static_cast<Index>(first) + static_cast<Index>(l)) +=
              static_cast<double>(value[static_cast<Index>(l)]);
      }
    }
  });
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(size, size);
  const std::size_t pairs = group_count * (group_count + 1) / 2;
  parallel_for(pairs, [&](std::size_t index) {
    std::size_t i = 0, j = index;
    for (; j > i; ++i) j -= i + 1;
    Eigen::MatrixXd part;
    add_products(pattern, groups[i], groups[j], part);
    const Index row = 3 * static_cast<Index>(i * contacts_in_group), column = 3 * static_cast<Index>(j * contacts_in_group);
    const Index rows = std::min<Index>(3 * contacts_in_group, size - row), columns = std::min<Index>(3 * contacts_in_group, size - column);
    w.block(row, column, rows, columns) = part.topLeftCorner(rows, columns);
    if (i != j) w.block(column, row, columns, rows) = part.topLeftCorner(rows, columns).transpose();
  });
  // Later slots stand alone in the base: their own 1/σ.
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t m = 0; m < contacts.size(); ++m)
      for (std::size_t i = 0; i < contacts[k].count; ++i)
        for (std::size_t j = 0; j < contacts[m].count; ++j) {
          const VertexId v = contacts[k].vertices[i];
          const std::uint32_t slot = slot_of_vertex_[v.index()];
          if (v != contacts[m].vertices[j] || slot < base_slots_ || !free(slot)) continue;
          w.block<3, 3>(3 * static_cast<Index>(k), 3 * static_cast<Index>(m)) +=
              contacts[k].weights[i] * contacts[m].weights[j] / own_stiffness_ * contacts[k].frame.transpose() *
              contacts[m].frame;
        }
  if (touched > 0) w -= seen.transpose() * (correction_ * seen);
  return 0.5 * (w + w.transpose());
}

}  // namespace calot
