// Typed indices: a vertex number can't be passed where a tetrahedron number is meant.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

namespace calot {

/// An index of one kind of thing, counted from 0. `none()` marks "no such thing".
template <class Tag>
struct Id {
  std::uint32_t value = std::numeric_limits<std::uint32_t>::max();

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t v) : value(v) {}
  constexpr explicit Id(std::size_t v) : value(static_cast<std::uint32_t>(v)) {}
  constexpr explicit Id(int v) : value(static_cast<std::uint32_t>(v)) {}

  static constexpr Id none() { return Id(); }
  [[nodiscard]] constexpr bool valid() const { return value != std::numeric_limits<std::uint32_t>::max(); }
  [[nodiscard]] constexpr std::size_t index() const { return value; }
  friend constexpr auto operator<=>(Id, Id) = default;
};

using VertexId = Id<struct VertexTag>;  ///< a vertex of a TetMesh
using TetId = Id<struct TetTag>;        ///< a tetrahedron of a TetMesh
using DofId = Id<struct DofTag>;        ///< a degree of freedom, 3·vertex + axis, over all vertices of the mesh

/// The degree of freedom of vertex `v` along axis 0, 1 or 2.
constexpr DofId dof_of(VertexId v, int axis) {
  return DofId(3 * v.index() + static_cast<std::size_t>(axis));
}
constexpr VertexId vertex_of(DofId d) {
  return VertexId(d.index() / 3);
}

}  // namespace calot

template <class Tag>
struct std::hash<calot::Id<Tag>> {
  std::size_t operator()(calot::Id<Tag> id) const noexcept { return std::hash<std::uint32_t>{}(id.value); }
};
