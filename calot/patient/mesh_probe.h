// Inside this room only: what lies at a point, and what a line of sight meets.
#pragma once
#include <optional>

#include "calot/mesh/surface.h"

namespace calot::detail {

class MeshProbe {
 public:
  explicit MeshProbe(const TetMesh& mesh) : mesh_(mesh), outer_(boundary_surface(mesh)) {}

  /// The region that a point [m] lies in (borders count as inside); 0 outside of all.
  [[nodiscard]] std::int32_t region_at(const Vec3& point) const;

  /// Where the segment from `from` to `to` first meets the outer surface; empty if it doesn't.
  struct Hit {
    std::int32_t region = 0;
    double distance = 0;  ///< from `from` [m]
  };
  [[nodiscard]] std::optional<Hit> first_hit(const Vec3& from, const Vec3& to) const;

  /// Distance of a point to the nearest vertex [m].
  [[nodiscard]] double nearest_vertex(const Vec3& point) const;
  [[nodiscard]] const Surface& outer() const { return outer_; }

 private:
  const TetMesh& mesh_;
  Surface outer_;
};

}  // namespace calot::detail
