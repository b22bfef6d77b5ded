// Inside this room only: a tree of boxes over triangles, refitted each step.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot::detail {

/// An axis-parallel box; empty where low > high.
struct Box {
  std::array<double, 3> low{inf, inf, inf}, high{-inf, -inf, -inf};
  void add(const Vec3& p) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], p(a));
      high[a] = std::max(high[a], p(a));
    }
  }
  void add(const Box& b) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], b.low[a]);
      high[a] = std::max(high[a], b.high[a]);
    }
  }
  void widen(double margin) {
    for (int a = 0; a < 3; ++a) {
      low[a] -= margin;
      high[a] += margin;
    }
  }
  [[nodiscard]] bool meets(const Box& b) const {
    return low[0] <= b.high[0] && b.low[0] <= high[0] && low[1] <= b.high[1] && b.low[1] <= high[1] &&
           low[2] <= b.high[2] && b.low[2] <= high[2];
  }
  /// Of the surface, halved.
  [[nodiscard]] double area() const {
    const double x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
  [[nodiscard]] double squared_distance(const Vec3& p) const {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      const double d = std::max({low[a] - p(a), 0.0, p(a) - high[a]});
      sum += d * d;
    }
    return sum;
  }
  static constexpr double inf = std::numeric_limits<double>::infinity();
};

/// The smallest dot product that a vector of one box can have with a vector of the other.
double smallest_dot(const Box& a, const Box& b);

/// A complete binary tree, split at medians; its leaves hold a few items each. Item i has a box and, if wanted, a
/// box of normals: pairs of items whose normals can't face each other are then passed over whole subtrees at a time.
class BoxTree {
 public:
  /// @param normals  as boxes of one vector each, or empty: then items that look the same way are kept together
  void build(std::span<const Box> boxes, std::span<const Box> normals = {});
  /// New boxes for the same items. @return sum of the leaves' areas as a share of what it was when built
  double refit(std::span<const Box> boxes, std::span<const Box> normals = {});
  [[nodiscard]] std::size_t size() const { return order_.size(); }
  [[nodiscard]] const Box& whole() const { return nodes_.front(); }

  /// Calls visit(item) for each item whose box meets `box`, in the tree's order.
  template <class Visit>
  void each(const Box& box, const Visit& visit) const;
  /// Calls visit(item) in a near-first order for boxes closer than what `visit` last
  /// returned (a squared distance; it starts from `reach`).
  template <class Visit>
  void nearest(const Vec3& point, double reach, const Visit& visit) const;
  /// Calls visit(item, other's item) for all pairs with boxes that meet and normals whose dot product can be below
  /// `facing`; within one tree each pair once.
  template <class Visit>
  static void pairs(const BoxTree& a, const BoxTree& b, double facing, const Visit& visit);

 private:
  [[nodiscard]] bool is_leaf(std::size_t node) const { return node + 1 >= leaves_; }
  [[nodiscard]] std::size_t begin_of(std::size_t leaf) const { return leaf * order_.size() / leaves_; }
  using Place = std::array<double, 6>;  // twice the middle [m], and the normal as a length
  void split(std::size_t node, std::size_t first_leaf, std::size_t last_leaf);

  std::size_t leaves_ = 1;            // a power of two; leaf l is node leaves_ − 1 + l
  std::vector<std::uint32_t> order_;  // items, leaf by leaf
  std::vector<Box> nodes_, normals_;  // 2·leaves_ − 1; children of i are 2i + 1 and 2i + 2
  std::vector<Box> boxes_;            // of the items, in the tree's order
  std::vector<Place> places_;         // of the items; kept for its memory
  double area_when_built_ = 0;
};

template <class Visit>
void BoxTree::each(const Box& box, const Visit& visit) const {
  if (order_.empty()) return;
  std::array<std::size_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::size_t node = stack[--depth];
    if (!nodes_[node].meets(box)) continue;
    if (!is_leaf(node)) {
      stack[depth++] = 2 * node + 2;
      stack[depth++] = 2 * node + 1;
      continue;
    }
    const std::size_t leaf = node + 1 - leaves_;
    for (std::size_t i = begin_of(leaf); i < begin_of(leaf + 1); ++i)
      if (boxes_[i].meets(box)) visit(order_[i]);
  }
}

template <class Visit>
void BoxTree::nearest(const Vec3& point, double reach, const Visit& visit) const {
  if (order_.empty()) return;
  std::array<std::size_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::size_t node = stack[--depth];
    if (nodes_[node].squared_distance(point) > reach) continue;
    if (!is_leaf(node)) {
      const std::size_t left = 2 * node + 1;
      const bool left_first = nodes_[left].squared_distance(point) <= nodes_[left + 1].squared_distance(point);
      stack[depth++] = left_first ? left + 1 : left;
      stack[depth++] = left_first ? left : left + 1;
      continue;
    }
    const std::size_t leaf = node + 1 - leaves_;
    for (std::size_t i = begin_of(leaf); i < begin_of(leaf + 1); ++i)
      if (boxes_[i].squared_distance(point) <= reach) reach = visit(order_[i]);
  }
}

template <class Visit>
void BoxTree::pairs(const BoxTree& a, const BoxTree& b, double facing, const Visit& visit) {
  if (a.order_.empty() || b.order_.empty()) return;
  const bool same = &a == &b;
  std::array<std::array<std::uint32_t, 2>, 256> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, 0};
  while (depth > 0) {
    const auto [i, j] = stack[--depth];
    const bool itself = same && i == j;
    if (!itself && !a.nodes_[i].meets(b.nodes_[j])) continue;
    if (!a.normals_.empty() && !b.normals_.empty() && smallest_dot(a.normals_[i], b.normals_[j]) >= facing) continue;
    if (!a.is_leaf(i) && (b.is_leaf(j) || itself || a.nodes_[i].area() >= b.nodes_[j].area())) {
      if (itself) {
        stack[depth++] = {2 * i + 2, 2 * i + 2};
        stack[depth++] = {2 * i + 1, 2 * i + 2};
        stack[depth++] = {2 * i + 1, 2 * i + 1};
      } else {
        stack[depth++] = {2 * i + 2, j};
        stack[depth++] = {2 * i + 1, j};
      }
      continue;
    }
    if (!b.is_leaf(j)) {
      stack[depth++] = {i, 2 * j + 2};
      stack[depth++] = {i, 2 * j + 1};
      continue;
    }
    const std::size_t leaf_a = i + 1 - a.leaves_, leaf_b = j + 1 - b.leaves_;
    for (std::size_t x = a.begin_of(leaf_a); x < a.begin_of(leaf_a + 1); ++x)
      for (std::size_t y = itself ? x + 1 : b.begin_of(leaf_b); y < b.begin_of(leaf_b + 1); ++y)
        if (a.boxes_[x].meets(b.boxes_[y])) visit(a.order_[x], b.order_[y]);
  }
}

}  // namespace calot::detail
