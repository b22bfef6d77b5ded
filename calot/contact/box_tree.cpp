#include "calot/contact/box_tree.h"

#include <algorithm>
#include <numeric>

namespace calot::detail {
namespace {
constexpr std::size_t items_in_a_leaf = 4;
// Nodes below about this size part what looks different ways before what is far apart [m].
constexpr double size_of_a_turn = 0.02;
}  // namespace

double smallest_dot(const Box& a, const Box& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += std::min(std::min(a.low[k] * b.low[k], a.low[k] * b.high[k]),
                    std::min(a.high[k] * b.low[k], a.high[k] * b.high[k]));
  return sum;
}

void BoxTree::build(std::span<const Box> boxes, std::span<const Box> normals) {
  leaves_ = 1;
  while (leaves_ * items_in_a_leaf < boxes.size()) leaves_ *= 2;
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), 0u);
  places_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      places_[i][a] = boxes[i].low[a] + boxes[i].high[a];
      places_[i][3 + a] = normals.empty() ? 0 : size_of_a_turn * normals[i].low[a];
    }
  if (!boxes.empty()) split(0, 0, leaves_);
  area_when_built_ = 0;
  refit(boxes);
  for (std::size_t l = 0; l < leaves_ && !boxes.empty(); ++l) area_when_built_ += nodes_[leaves_ - 1 + l].area();
}

void BoxTree::split(std::size_t node, std::size_t first_leaf, std::size_t last_leaf) {
  if (last_leaf - first_leaf == 1) return;
  const std::size_t half = (first_leaf + last_leaf) / 2;
  const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(begin_of(first_leaf)),
             end = order_.begin() + static_cast<std::ptrdiff_t>(begin_of(last_leaf)),
             middle = order_.begin() + static_cast<std::ptrdiff_t>(begin_of(half));
  Place low, high;
  low.fill(Box::inf);
  high.fill(-Box::inf);
  for (auto it = begin; it != end; ++it)
    for (std::size_t a = 0; a < low.size(); ++a) {
      low[a] = std::min(low[a], places_[*it][a]);
      high[a] = std::max(high[a], places_[*it][a]);
    }
  std::size_t axis = 0;
  for (std::size_t a = 1; a < low.size(); ++a)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  // Equal places are told apart by number, so that the tree is the same everywhere.
  std::nth_element(begin, middle, end, [&](std::uint32_t i, std::uint32_t j) {
    const double x = places_[i][axis], y = places_[j][axis];
    return x < y || (x == y && i < j);
  });
  split(2 * node + 1, first_leaf, half);
  split(2 * node + 2, half, last_leaf);
}

double BoxTree::refit(std::span<const Box> boxes, std::span<const Box> normals) {
  boxes_.resize(order_.size());
  nodes_.resize(2 * leaves_ - 1);
  normals_.resize(normals.empty() ? 0 : nodes_.size());
  double area = 0;
  for (std::size_t l = 0; l < leaves_; ++l) {
    Box box, facing;
    for (std::size_t i = begin_of(l); i < begin_of(l + 1); ++i) {
      boxes_[i] = boxes[order_[i]];
      box.add(boxes_[i]);
      if (!normals.empty()) facing.add(normals[order_[i]]);
    }
    nodes_[leaves_ - 1 + l] = box;
    if (!normals.empty()) normals_[leaves_ - 1 + l] = facing;
    if (begin_of(l) < begin_of(l + 1)) area += box.area();
  }
  for (std::size_t i = leaves_ - 1; i-- > 0;) {
    nodes_[i] = nodes_[2 * i + 1];
    nodes_[i].add(nodes_[2 * i + 2]);
    if (normals.empty()) continue;
    normals_[i] = normals_[2 * i + 1];
    normals_[i].add(normals_[2 * i + 2]);
  }
  return area_when_built_ > 0 ? area / area_when_built_ : 1;
}

}  // namespace calot::detail
