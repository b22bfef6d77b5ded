// Instruments and clips as a picture shows them: triangle meshes in the shapes that the simulation touches tissue with.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calot/sim/instrument.h"
#include "calot/view/snapshot.h"

namespace calot {

/// What a part is made of; the same numbers as in shaders/metal.glsl.
enum class ModelMaterial : std::uint8_t {
  brushed_steel = 0,   ///< fine lines along the grain
  polished_steel = 1,  ///< working faces, edges, wire
  insulation = 2,      ///< black plastic of shafts
  ceramic = 3,         ///< off-white collar of the hook
  titanium = 4,        ///< clips
};

/// Which of an instrument's three frames a part moves with: `articulate` has their poses.
enum class ModelFrame : std::uint8_t { shaft = 0, jaw_a = 1, jaw_b = 2 };

/// A closed mesh of one material, perhaps of several closed pieces that run into each other. In its frame, jaws closed.
/// Where normals break, vertices are doubled.
struct ModelPart {
  ModelFrame frame = ModelFrame::shaft;
  ModelMaterial material = ModelMaterial::brushed_steel;
  std::vector<Vec3f> positions;     ///< n [m]
  std::vector<Vec3f> normals;       ///< n, unit, outwards
  std::vector<Vec3f> grains;        ///< n, unit, across the normal: the way the fine lines run
  std::vector<float> openness;      ///< n, 1: open to the light; towards 0: inside a bore, a slot, a groove
  std::vector<Triangle> triangles;  ///< of vertices, counter-clockwise from outside
};

/// The parts of an instrument; at most 15,000 triangles together. Where the simulation has a shape (jaws, tips, tube),
/// the surface lies within 0.3 mm of it; the joint between shaft and jaws, within 0.8 mm.
std::vector<ModelPart> instrument_model(const InstrumentGeometry& geometry);

/// The open clip in an applier's jaws, in the shaft's frame. It changes with `opening`, the angle of the jaws [rad].
ModelPart loaded_clip_model(const InstrumentGeometry& geometry, double opening);

/// Whether instrument `index` has a clip in its jaws: an applier that is open, away from the clip that it left last.
bool shows_loaded_clip(const Snapshot& snapshot, std::size_t index);

/// A clip on tissue, in its frame; it changes while the clip closes (`shape` does).
ModelPart clip_model(const ClipSnapshot& clip);

}  // namespace calot
