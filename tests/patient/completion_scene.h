// A gallbladder (a ball) in its fossa of a liver (a slab), a bile duct, a cystic duct between them, and fat: what
// completing labels must find is known by formula.
#pragma once
#include <functional>

#include "calot/patient/completion.h"

namespace calot::test {

struct Scene {
  CtImage ct;
  LabelMap labels;                ///< liver and gallbladder; others by `scene`'s choice
  std::vector<Centreline> lines;  ///< common bile duct, cystic duct
};

/// What a place [mm] of the scene is, all structures included.
Structure scene_truth(const Vec3& mm);

/// @param keep  whether a structure is in the labels
Scene make_scene(const Vec3& spacing_mm, bool oblique, const std::function<bool(Structure)>& keep);

/// Scene coordinates [mm] of a place.
Vec3 to_scene(const Vec3& world, bool oblique);
Vec3 from_scene(const Vec3& mm, bool oblique);

/// Liver and gallbladder only.
inline bool organs_only(Structure s) {
  return s == Structure::liver || s == Structure::gallbladder;
}

inline constexpr double scene_sac_radius = 14, scene_bile_radius = 3, scene_cystic_radius = 1.6;  // mm

}  // namespace calot::test
