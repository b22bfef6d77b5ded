// The tissue of a scene, ready for a world.
#pragma once
#include <map>
#include <optional>
#include <set>

#include "calot/fem/model.h"
#include "calot/patient/patient.h"
#include "calot/scene/scene.h"
#include "calot/sim/spring.h"
#include "calot/sim/tissue_properties.h"

namespace calot {

struct SceneTissue {
  Model model;  ///< its step and damping are the scene's; static regions are fixed, rigid ones stiff
  std::map<std::int32_t, TissueProperties> properties;  ///< of every region; density is the material's
  std::map<std::int32_t, BodyKind> bodies;              ///< of every region
  std::vector<Spring> ligaments;                        ///< on which regions hang
  std::set<std::int32_t> carried;                       ///< see WorldOptions::carried
  std::optional<Patient> patient;                       ///< where there is one; its mesh has moved into `model`
};

/// A liver then bends by less than a millimetre under a few newtons, and still has a compliance like all tissue.
inline constexpr double rigid_stiffening = 50;

/// Reads or makes the tissue and applies the scene's regions to it. A patient's attachments of kind "fixed" are fixed
/// vertices; the peritoneum is tissue like any other. A rigid region is made `rigid_stiffening` times as stiff, and
/// what was fixed in it hangs on ligaments, which carry it where it is. Throws InputError naming the file and line that
/// is wrong.
SceneTissue load_tissue(const Scene& scene);

/// Where the instrument's port is: the scene's own, or the patient's by name; none without. Throws InputError.
std::optional<Vec3> port_of(const SceneInstrument& instrument, const SceneTissue& tissue);

/// The triangles of a still surface [m]. Throws InputError for its file.
Surface load_surface(const SceneSurface& still);
/// All of a scene's.
std::vector<Surface> load_surfaces(const Scene& scene);

}  // namespace calot
