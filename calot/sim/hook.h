// Where an L-hook touches tissue and gives its current off.
#pragma once
#include <optional>

#include "calot/contact/tissue_contact.h"
#include "calot/sim/grasp_area.h"
#include "calot/sim/instrument.h"

namespace calot {

/// The stretch of the hook's bare foot that lies on tissue.
struct HookContact {
  Vec3 place = Vec3::Zero();                      ///< middle of the touching stretch, on the tissue [m]
  Vec3 begin = Vec3::Zero(), end = Vec3::Zero();  ///< its ends on the foot's middle line [m]
  double length = 0;                              ///< of the stretch [m]; 0 where it touches in one point
  double radius = 0;     ///< of a ball that stands for the stretch: of the wire, or half the length if that is more [m]
  SurfacePoint nearest;  ///< the tissue's point that is nearest to the foot; its tet is none
  double gap = 0;        ///< there, between wire and tissue; < 0 where the wire is in it [m]
};

/// Where the foot of a hook at `pose` is within `reach` of the tissue's surface, or nothing. One box test for each
/// triangle.
/// @param reach  between the wire's surface and the tissue; a spark jumps about that far, ≥ 0 [m]
std::optional<HookContact> hook_contact(const InstrumentGeometry& geometry, const Pose& pose,
                                        const TissueSurface& surface, double reach = 0.3e-3);

}  // namespace calot
