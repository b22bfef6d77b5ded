// Inside this room only: what the graphics card gets of the tissue in each picture.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "calot/view/snapshot.h"

namespace calot::detail {

/// As the vertex shader reads it: 24 bytes.
struct StreamVertex {
  std::array<float, 3> position;          ///< [m]
  std::array<std::int16_t, 4> normal;     ///< x, y, z · 32767, 0
  std::array<std::uint8_t, 4> condition;  ///< coagulated, charred, blanched, bruised · 255
};
static_assert(sizeof(StreamVertex) == 24);

/// Normals of the skin. Corners of one vertex share theirs, so that looks meet without a crease, but not across the
/// edge of a cut.
class SurfaceStream {
 public:
  void set_skin(const TissueSkin& skin);
  /// @param out  n, one for each vertex of the skin
  void pack(std::span<const Vec3f> positions, std::span<const SkinCondition> conditions, StreamVertex* out);
  [[nodiscard]] std::size_t vertex_count() const { return group_.size(); }

 private:
  std::vector<std::uint32_t> group_;          // n, of each vertex: those of a group share a normal
  std::vector<Triangle> triangles_;           // of groups
  std::vector<std::uint32_t> first_of_;       // a vertex of each group
  std::vector<Eigen::Vector4f> place_, sum_;  // of groups
};

std::array<std::int16_t, 4> packed_normal(const Eigen::Vector3f& normal);

}  // namespace calot::detail
