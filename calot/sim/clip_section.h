// What a clip's legs find between them.
#pragma once
#include <span>
#include <vector>

#include "calot/contact/tissue_contact.h"
#include "calot/sim/grasp_area.h"

namespace calot {

/// A titanium clip of the usual "medium-large" size. Sources: docs/simulation.md.
struct ClipFigures {
  double leg_length = 8.5e-3;            ///< [m]
  double width = 1.0e-3;                 ///< along the tube [m]
  double wire = 0.5e-3;                  ///< radius of the legs [m]
  double closed_gap = 0.8e-3;            ///< between the legs when closed: two walls pressed flat [m]; assumed
  double gap_tolerance = 0.3e-3;         ///< walls this much further apart still count as together [m]
  double most_gap = 2.0e-3;              ///< no clip with its legs further apart shuts anything [m]; assumed
  double least_thickness = 0.3;          ///< it presses tissue to this share of its thickness at most; assumed
  double closing_time = 0.15;            ///< from open to closed [s]
  double closing_force = 30;             ///< of the applier's jaws [N]; assumed
  double stiffness = 1e5;                ///< of all springs between the walls [N/m]
  double transverse = 2.2, axial = 4.4;  ///< pull that takes it off, across and along the tube [N] [Nelson1992]
  double loose_share = 0.5;              ///< of these for a clip that didn't take the whole cross-section; assumed
};

/// A line through the tissue from leg to leg: where it enters (wall a, −y) and leaves (wall b, +y).
struct ClipStation {
  SurfacePoint a, b;  ///< their tets are none
  double area = 0;    ///< that it stands for, of one wall [m²]
  double gap = 0;     ///< from a to b along the clip's y [m]
};

/// The lines between the legs of a clip in `frame`, in rows across its width, that meet tissue.
/// @param reach  half the distance of the legs at z = 0, and how it grows along z [m], [1]
std::vector<ClipStation> clip_stations(const ClipFigures& figures, const Pose& frame, double reach, double reach_slope,
                                       const TissueSurface& surface);

/// The tets of one region whose section with the plane x = 0 of `frame` hangs together with `seeds`.
struct ClipSection {
  double low_z = 0, high_z = 0;  ///< how far it reaches along the legs [m]
  double low_y = 0, high_y = 0;
  double beyond = 0;     ///< how far it reaches out over the legs, across them; < 0: it lies between them [m]
  std::size_t tets = 0;  ///< 0 where no seed of the region is cut by the plane
};
/// @param reach  as of `clip_stations`
ClipSection clip_section(const Pose& frame, double reach, double reach_slope, std::span<const TetId> seeds,
                         std::int32_t region, const TetMesh& mesh, std::span<const Vec3> positions);

/// The tets, of any region, that lie at least in part in the clip's slab and between its legs, ascending.
std::vector<TetId> clip_tets(const ClipFigures& figures, const Pose& frame, double reach, double reach_slope,
                             const TetMesh& mesh, std::span<const Vec3> positions);

Vec3 place_of(const SurfacePoint& point, std::span<const Vec3> positions);

}  // namespace calot
