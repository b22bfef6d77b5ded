// A label map becomes one conforming tetrahedral mesh.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/label_map.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
#include "calot/mesh/tet_mesh.h"

namespace calot {

/// A region that gets its own edge length, or its own share of fineness.
struct Refinement {
  Label label = 0;
  double edge = 0;  ///< wanted mean edge length [m], > 0
};

struct MesherOptions {
  std::vector<Label> labels;    ///< what to mesh; empty: every label but 0
  std::size_t vertices = 2442;  ///< to be met within `tolerance`, ≥ 50
  std::size_t tets = 0;         ///< to be met instead, where not 0; ≥ 100
  double tolerance = 0.03;
  std::vector<Refinement> refine;   ///< the other regions' sizes give way to meet `vertices`
  std::vector<Refinement> weights;  ///< edges [m] that are scaled together to meet the count; others: √thickness
  double growth = 0.4;              ///< of edge lengths, per distance from smaller ones; > 0
  double smoothing = 0.5;           ///< σ of the Gaussian on the labels, in voxels, 0 … 2
  double min_dihedral = 12;         ///< wanted [°]; a mesh below it is returned only if no try was better
  double max_dihedral = 165;        ///< likewise [°]
  double max_volume_error = 0;      ///< a mesh is refused where a region is farther off, relative; 0: any is taken
  double min_dihedral_taken = 0;    ///< likewise below this [°]; 0: any
  double max_dihedral_taken = 180;  ///< and above this
  int tries = 16;                   ///< bound on meshes made in the search, ≥ 1
};

/// What became of one label.
struct MeshedRegion {
  Label label = 0;
  std::string name;                          ///< of the label map; may be empty
  std::size_t voxels = 0;                    ///< of its largest part, which was meshed
  std::size_t specks = 0, moved_voxels = 0;  ///< smaller parts, given to what surrounds them
  double voxel_volume = 0;                   ///< [m³] of `voxels`
  Quality quality;                           ///< of its tets; quality.volume compares with voxel_volume
};

struct LabelMesh {
  TetMesh mesh;                       ///< RAS [m]; region = label, names from the label map
  std::vector<MeshedRegion> regions;  ///< in the order of the labels
  Quality quality;                    ///< of the whole
  ManifoldReport outer;               ///< of the outer surface
  int tries = 0;                      ///< meshes made
  std::vector<std::string> notes;     ///< what was cleaned, and what was wanted but not reached; for the log
};

/// Meshes the largest part of each label: conforming across regions, one face-connected part a region, the outer
/// surface a closed manifold, `vertices` within `tolerance`, each region's volume near its voxels' (the smoothed
/// boundaries are moved until it is: smoothing and flat facets both make thin ducts thinner). Thin regions get smaller
/// tets than thick ones. The same input gives the same mesh. Throws InputError: a label without voxels or options out
/// of range; FailedError: no mesh met the count, the manifold condition and the bounds within `tries`, saying how near
/// it came.
LabelMesh mesh_labels(const LabelMap& map, const MesherOptions& options, Progress& progress);

/// Names and versions of the libraries behind the mesher, for provenance.
std::map<std::string, std::string> mesher_versions();

}  // namespace calot
