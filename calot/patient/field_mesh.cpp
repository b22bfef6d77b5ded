#include "calot/patient/field_mesh.h"

#include <algorithm>

#include "calot/base/error.h"

namespace calot {

double usual_edge(Structure s) {
  switch (s) {
    case Structure::liver:
      return 16e-3;
    case Structure::gallbladder:
      return 6e-3;
    case Structure::gallbladder_wall:
      return 4e-3;
    case Structure::gallbladder_bed:
      return 2.8e-3;
    case Structure::hepatocystic_fat:
      return 2.2e-3;
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
      return 2.4e-3;
    case Structure::right_hepatic_artery:
    case Structure::aberrant_right_duct:
      return 1.7e-3;
    case Structure::cystic_duct:
      return 1.3e-3;
    case Structure::cystic_artery:
    case Structure::second_cystic_artery:
    case Structure::none:
      break;
  }
  return 1.0e-3;
}

MesherOptions field_mesh_options(const LabelMap& labels, std::size_t tets) {
  if (tets < 4000 || tets > 2000000)
    throw InputError("tets", "aren't in 4000 … 2000000",
                     "thin ducts need a few thousand; 20000 keep the simulation in real time");
  constexpr double tolerance = 0.04;
  MesherOptions options;
  options.tolerance = tolerance;
  options.tets = static_cast<std::size_t>(static_cast<double>(tets) / (1 + tolerance));
  options.tries = 20;
  options.max_volume_error = 0.05;
  options.min_dihedral_taken = 10;
  options.max_dihedral_taken = 165;
  options.growth = 0.7;
  for (const auto& [label, count] : voxel_counts(labels)) {
    options.labels.push_back(label);
    options.weights.push_back({label, usual_edge(static_cast<Structure>(label))});
  }
  return options;
}

}  // namespace calot
