// Inside this room only: quality of meshes as JSON.
#pragma once
#include <string>

#include "calot/patient/json_file.h"
#include "calot/patient/mesher.h"

namespace calot::detail {

/// Counts, angles [°], edges [mm] and volume [mL].
Json quality_json(const Quality& quality);
/// What quality.json holds: the whole mesh and each region against its voxels.
/// @param source  what was meshed
Json mesh_report(const LabelMesh& meshed, const std::string& source);

}  // namespace calot::detail
