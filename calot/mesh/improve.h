// Better angles for a finished mesh.
#pragma once
#include <cstddef>

#include "calot/mesh/tet_mesh.h"

namespace calot {

struct ImproveOptions {
  double min_dihedral = 13, max_dihedral = 163;  ///< wanted [°]
  /// How far a vertex on a boundary between regions, or on the outside, may leave its place, in mean lengths of its
  /// edges: along the boundary, and across it.
  double along = 0.3, across = 0.06;
  int passes = 12;  ///< ≥ 1; ends earlier when nothing is left to gain
};

struct Improvement {
  std::size_t moves = 0, flips = 0, collapses = 0;
  std::size_t bad_before = 0, bad_after = 0;  ///< tets outside the wanted angles
};

/// Raises the worst angles: around every tet outside the wanted angles it moves vertices, removes edges and faces
/// inside regions (flips), and pulls vertices inside regions into neighbours (collapses), each only if the worst angle
/// of the tets that it changes gets better. Boundaries between regions keep their triangles; their vertices move a
/// little. Vertices that no tet uses are dropped. The same mesh gives the same result. Source: [Freitag1997] smoothing
/// by pattern search for the worst element; [Klingner2007] edge removal.
Improvement improve(TetMesh& mesh, const ImproveOptions& options);

}  // namespace calot
