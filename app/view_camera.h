// Where a scene is looked at from.
#pragma once
#include "calot/scene/scene_world.h"
#include "calot/view/camera.h"

namespace calot {

/// The scene's own camera; a patient's laparoscope, brought within a hand's breadth of what it looks at; else one on
/// the instruments' side, a little from below, that sees what they work on.
Camera scene_camera(const Scene& scene, const SceneRun& run);

/// Turned about what lies at `distance` ahead [m]: by `right` and `up` [rad], and `closer` times as near.
Camera orbited(const Camera& camera, float distance, float right, float up, float closer);

}  // namespace calot
