// Inside this room only: how the pieces of a model are made: skins through rings, turned bodies, normals.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "calot/view/models/model.h"

namespace calot::detail {

/// A closed mesh whose vertices are shared by all triangles around them.
struct PlainMesh {
  std::vector<Vec3> positions;  ///< [m]
  std::vector<float> openness;
  std::vector<Triangle> triangles;
};

/// A ring of points. Counter-clockwise seen from where the later rings are (looking back).
using Ring = std::vector<Vec3>;
/// A section in its own plane, counter-clockwise, as the ring has it.
using Outline = std::vector<Eigen::Vector2d>;

/// A body with a skin through rings of equally many points; its ends are shut with a fan around each end ring's middle.
void add_loft(PlainMesh& mesh, std::span<const Ring> rings);
/// The same, but the last ring is followed by the first.
void add_closed_loft(PlainMesh& mesh, std::span<const Ring> rings);

/// A point of a turned body's profile: radius, and place on the axis.
struct Turned {
  double radius = 0, along = 0;
};
/// A body turned about `axis` through `origin`; the profile goes up the axis on the outside. Ends with radius 0 are
/// points, others are shut flat.
void add_turned(PlainMesh& mesh, std::span<const Turned> profile, const Vec3& origin, const Vec3& axis, int segments);
/// The profile of a ball's upper half that ends in `top`, in `steps` facets: what closes a rod.
std::vector<Turned> dome(double radius, double top, int steps);

/// A rod of this section along a path, with rings across it; x of the section points along `sideways`, as far as it is
/// across the path.
void add_rod(PlainMesh& mesh, std::span<const Vec3> path, std::span<const double> scale, const Outline& section,
             const Vec3& sideways);

/// A circle, and a rectangle with its corners cut or rounded; counter-clockwise.
Outline circle(double radius, int points);
Outline rounded_rectangle(double half_x, double half_y, double corner, int steps_per_corner);

/// Doubles vertices where triangles meet at more than `crease` [rad], and makes normals and grains. `grain` tells which
/// way the fine lines run at a point.
ModelPart finish(const PlainMesh& mesh, ModelFrame frame, ModelMaterial material, double crease,
                 const std::function<Vec3(const Vec3&)>& grain);

}  // namespace calot::detail
