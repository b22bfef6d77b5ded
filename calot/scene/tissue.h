// The tissue of a scene, ready for a world.
#pragma once
#include <map>
#include <optional>

#include "calot/fem/model.h"
#include "calot/patient/patient.h"
#include "calot/scene/scene.h"
#include "calot/sim/tissue_properties.h"

namespace calot {

struct SceneTissue {
  Model model;  ///< its step and damping are the scene's; static regions are fixed
  std::map<std::int32_t, TissueProperties> properties;  ///< of every region; density is the material's
  std::map<std::int32_t, BodyKind> bodies;              ///< of every region
  std::optional<Patient> patient;                       ///< where there is one; its mesh has moved into `model`
};

/// Reads or makes the tissue and applies the scene's regions to it. A patient's attachments of kind "fixed" are fixed
/// vertices; the peritoneum is tissue like any other. Throws InputError naming the file and line that is wrong.
SceneTissue load_tissue(const Scene& scene);

/// Where the instrument's port is: the scene's own, or the patient's by name; none without. Throws InputError.
std::optional<Vec3> port_of(const SceneInstrument& instrument, const SceneTissue& tissue);

/// The triangles of a still surface [m]. Throws InputError for its file.
Surface load_surface(const StillSurface& still);

}  // namespace calot
