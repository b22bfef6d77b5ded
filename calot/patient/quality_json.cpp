#include "calot/patient/quality_json.h"

namespace calot::detail {

Json quality_json(const Quality& q) {
  constexpr double mm = 1e-3;
  return {{"vertices", q.vertices},
          {"tets", q.tets},
          {"min_dihedral_deg", q.min_dihedral},
          {"max_dihedral_deg", q.max_dihedral},
          {"min_edge_mm", q.min_edge / mm},
          {"mean_edge_mm", q.mean_edge / mm},
          {"max_edge_mm", q.max_edge / mm},
          {"min_radius_ratio", q.min_radius_ratio},
          {"volume_ml", q.volume * 1e6}};
}

Json mesh_report(const LabelMesh& meshed, const std::string& source) {
  Json json{{"source", source},
            {"mesh", quality_json(meshed.quality)},
            {"outer_surface_closed_manifold", meshed.outer.closed_manifold()},
            {"meshes_made", meshed.tries},
            {"notes", meshed.notes},
            {"regions", Json::array()}};
  for (const MeshedRegion& region : meshed.regions) {
    Json entry{{"label", region.label},
               {"name", region.name},
               {"voxels", region.voxels},
               {"specks", region.specks},
               {"voxels_moved", region.moved_voxels},
               {"voxel_volume_ml", region.voxel_volume * 1e6},
               {"volume_error", region.quality.volume / region.voxel_volume - 1}};
    entry.update(quality_json(region.quality));
    json["regions"].push_back(entry);
  }
  return json;
}

}  // namespace calot::detail
