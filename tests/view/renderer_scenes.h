// Moments of small scenes for the renderer's tests: made from shapes, none simulated, so that pictures stay the same.
#pragma once
#include "calot/scene/scene_world.h"
#include "calot/view/renderer.h"
#include "calot/view/snapshot_maker.h"

namespace calot::test {

constexpr double millimetre = 1e-3;

/// A gallbladder on its duct along x, 56 mm long.
Scene gallbladder_scene();
/// A slab of one tissue, 40 × 40 × 8 mm, its upper face at z = 0.
Scene slab_scene(const std::string& region);
/// An instrument of this kind, its tip at `tip`, pointing along `direction`.
void add_instrument(Scene& scene, InstrumentKind kind, const Vec3& tip, const Vec3& direction, double opening);

/// The scene before its first step.
Snapshot moment_of(const Scene& scene);
/// The same after tets whose middle fulfils `gone` were removed.
Snapshot moment_after_cut(const Scene& scene, const std::function<bool(const Vec3&)>& gone);
/// Looks from above, from the front, at the origin shifted along x [mm].
Camera usual_camera(float x = 0, float distance = 70);

}  // namespace calot::test
