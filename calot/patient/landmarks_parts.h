// Inside this room only: the pieces that landmarks are computed from.
#pragma once
#include <initializer_list>
#include <optional>

#include "calot/patient/abdominal_wall.h"
#include "calot/patient/landmarks.h"

namespace calot::detail {

/// Asks a label map by place.
class LabelProbe {
 public:
  explicit LabelProbe(const LabelMap& map) : map_(map), to_voxel_(map.grid.to_world.inverse()) {}

  /// The structure at a point [m]; none outside the map.
  [[nodiscard]] Structure at(const Vec3& point) const;
  /// Length [m] of a straight way that lies in liver or gallbladder, and which of them takes most of it.
  struct Blocked {
    double length = 0;
    Structure by = Structure::none;
  };
  [[nodiscard]] Blocked blocked(const Vec3& from, const Vec3& to) const;
  /// The centre of the nearest voxel that is one of these, within `reach` [m].
  [[nodiscard]] std::optional<Vec3> nearest(const Vec3& point, std::initializer_list<Structure> wanted,
                                            double reach) const;
  /// Whether an organ (anything but fat and connective tissue) is nearer than `distance`.
  [[nodiscard]] bool organ_within(const Vec3& point, double distance) const;
  [[nodiscard]] double voxel() const { return map_.grid.spacing().minCoeff(); }

 private:
  template <class Wanted>
  [[nodiscard]] std::optional<Vec3> nearest_where(const Vec3& point, double reach, const Wanted& wanted) const;

  const LabelMap& map_;
  Eigen::Affine3d to_voxel_;
};

/// What the landmarks need to know of the organs.
struct OrganPlaces {
  Vec3 fundus;        ///< the gallbladder's point farthest from its neck [m]
  Vec3 liver_middle;  ///< of the liver within 80 mm of the triangle [m]
};

/// The centreline of a structure; null without one.
const Centreline* line_of(const CompletedAnatomy& anatomy, Structure s);
/// Distance [m] of a point from a tube's surface, negative inside.
double distance_from_tube(const Centreline& line, const Vec3& point);

/// A tube from its far end (bile duct or artery) to the gallbladder, and the part of it that lies free between the two.
struct FreeTube {
  Structure tube;
  Centreline line;            ///< first point at the far end
  double begin = 0, end = 0;  ///< arc lengths [m]
};
/// Throws FailedError where the tube has no free part of at least 2 mm.
FreeTube free_tube(const CompletedAnatomy& anatomy, const LabelProbe& probe, Structure tube);

CalotTriangle find_triangle(const CompletedAnatomy& anatomy, const LabelProbe& probe, const FreeTube& duct,
                            std::vector<std::string>& notes);
/// Adds the clips and the cut of one tube.
void add_tube_sites(const FreeTube& tube, Landmarks& landmarks);
std::vector<Port> find_ports(const AbdominalWall& wall, const OrganPlaces& organs, const CalotTriangle& triangle,
                             const LabelProbe& probe, std::vector<std::string>& notes);
CameraPose find_camera(const Port& port, const OrganPlaces& organs, const CalotTriangle& triangle,
                       const LabelProbe& probe, std::vector<std::string>& notes);

inline Vec3 middle_of(const CalotTriangle& t) {
  return (t.duct_corner + t.neck_corner + t.liver_corner) / 3;
}
/// "12.3 mm"
std::string in_mm(double metres);

}  // namespace calot::detail
