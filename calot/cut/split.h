// Cutting without loss: the mesh is separated along what a blade swept, and keeps its volume.
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "calot/cut/cut.h"

namespace calot {

/// What a blade swept in one step: triangles of one nearly flat patch, in the coordinates that `current` is given in
/// [m]. The cut lies in their mean plane. Let a sweep begin a little behind the end of the one before (0.1 mm), so that
/// tissue that gave way in between is not missed.
struct Sweep {
  std::vector<std::array<Vec3, 3>> triangles;
};

/// What earlier sweeps of a stroke left, so that the next one goes on from there. Empty at the start of a stroke.
struct Stroke {
  std::vector<VertexId> front;  ///< put on the cut, single still: where the tissue stays joined; ascending
  std::vector<VertexId> lips;   ///< put on the cut and doubled since; ascending
};

struct SplitOptions {
  std::string region = "*";   ///< only tets of this region are parted (name or number; "*" is all)
  double smallest_angle = 3;  ///< dihedral angle wanted of every piece [°]
  /// How far a vertex of the cut may lie off the blade [m], where the mesh would otherwise get slivers or another
  /// outline. > 0.
  double flatness = 0.2e-3;
  double margin = 0.05e-3;         ///< the swept patch counts as wider by this all around [m], ≥ 0
  const Stroke* stroke = nullptr;  ///< SplitReport::stroke of the sweep before, brought up to date by `follow`
  std::span<const std::uint8_t> fixed = {};  ///< n, 1 where a vertex must not move; empty: all may
};

/// What a split did. Angles in degrees in the rest shape, lengths [m], volumes [m³].
struct SplitReport {
  std::size_t crossed = 0;      ///< edges that the blade crossed
  std::size_t snapped = 0;      ///< vertices that slid onto the blade along an edge
  std::size_t taken_as_on = 0;  ///< vertices within `flatness` of the blade that count as on it where they are
  std::size_t bisected = 0;     ///< edges that got a vertex on the blade
  std::size_t separated = 0;    ///< faces that opened
  std::size_t copies = 0;       ///< vertices that were doubled
  double angle_before = 180, angle_after = 180;  ///< smallest dihedral of the tets that changed, and of their pieces
  std::size_t too_sharp = 0;                     ///< pieces below `smallest_angle`
  double largest_distance = 0;                   ///< of a vertex that this sweep put on the cut, from the blade
  double volume_change = 0;                      ///< of all tets together; rounding aside, from vertices that slid
  Stroke stroke;                                 ///< for the next sweep: old numbers, n + k for the k-th added vertex
  std::vector<std::string> notes;
};

struct SplitEdit : TopologyEdit {
  SplitReport report;
};

/// Separates the mesh along a sweep. Edges that it crosses are bisected on the blade; where the crossing is near an
/// end, that end slides onto the blade instead, or, within `flatness`, counts as on it; which, and in what order, is
/// chosen so that the pieces' angles are best. Faces whose corners were all swept (now, or before: `stroke`) open; tets
/// swept in part stay joined. Sliding keeps outlines and region boundaries (bent ones to 0.03 % of the volume around).
/// @param around   vertex_tets(mesh)
/// @param current  n, where each vertex is while the blade passes (mesh.positions: the rest shape) [m]
/// @return one edit in numbers of the mesh before; empty with a note where the sweep cuts nothing. The same input gives
/// the same edit. Throws InputError for bad options, sizes that don't fit or numbers that aren't finite.
SplitEdit split(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current, const Sweep& sweep,
                const SplitOptions& options = {});

/// Separates along a whole plane or patch in the rest shape. Throws InputError as `cut` does.
SplitEdit split(const TetMesh& mesh, const Blade& blade, const SplitOptions& options = {});

/// A stroke in numbers of the mesh after an edit: of the edit that it was reported with, or of any later one.
Stroke follow(const Stroke& stroke, const Remap& remap);

}  // namespace calot
