// The camera: a laparoscope with its lamp, or a free one.
#pragma once
#include <Eigen/Core>

#include "calot/contact/rigid_shape.h"

namespace calot {

/// Where a picture is taken from, and how. The axes are unit and orthogonal.
struct Camera {
  Eigen::Vector3f eye = {0, -0.1F, 0};                  ///< [m]
  Eigen::Vector3f forward = {0, 1, 0}, up = {0, 0, 1};  ///< what it looks along; up in the picture
  float field = 1.309F;                                 ///< of the round field, or of the picture's height [rad]
  bool scope = true;                                    ///< round field, lens and lamp of a laparoscope
  Eigen::Vector3f lamp = {0.0035F, 0.003F, 0};          ///< from the eye: right, up, forward [m]
  float nearest = 0.004F, farthest = 0.6F;              ///< what is seen [m]
  float exposure = 1;                                   ///< times what the meter finds, > 0

  [[nodiscard]] Eigen::Vector3f right() const { return forward.cross(up); }
};

inline constexpr float laparoscope_field = 1.309F;  ///< 75°
inline constexpr float round_field_radius = 0.56F;  ///< of the round field, in heights of the picture

/// A camera at `eye` that looks at `target`. Throws InputError where they coincide or `up` is along the view.
Camera camera_looking(const Eigen::Vector3f& eye, const Eigen::Vector3f& target, const Eigen::Vector3f& up);

/// A laparoscope: `tip`'s z axis is the shaft's, out of the tip; its optic looks `oblique` [rad] off that towards the
/// tip's y axis turned by `turn` [rad] about the shaft (the light post); the camera head keeps the picture's up along
/// the tip's y axis as well as it can.
Camera laparoscope(const Pose& tip, float oblique = 0.5236F, float turn = 0);

/// Half the picture's height and width at distance 1.
float half_height(const Camera& camera);

/// World to clip space, OpenGL's conventions, for a picture `aspect` times as wide as high.
Eigen::Matrix4f view_projection(const Camera& camera, float aspect);

/// Direction (unit) that is seen at a place of the picture: x to the right, y up, both -1 ... 1.
Eigen::Vector3f ray_through(const Camera& camera, float aspect, float x, float y);

}  // namespace calot
