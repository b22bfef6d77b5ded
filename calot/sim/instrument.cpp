#include "calot/sim/instrument.h"

namespace calot {

std::string_view name_of(InstrumentKind kind) {
  switch (kind) {
    case InstrumentKind::bowel_grasper: return "bowel grasper";
    case InstrumentKind::curved_forceps: return "curved forceps";
    case InstrumentKind::clip_applier: return "clip applier";
    case InstrumentKind::scissors: return "scissors";
    case InstrumentKind::hook: return "hook";
    case InstrumentKind::suction: return "suction";
  }
  return "";
}

ArticulatedPoses articulate(const InstrumentGeometry& /*geometry*/, double opening) {
  const auto turned = [](double angle) {
    return Pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitX())), Vec3::Zero()};
  };
  return {Pose{}, turned(opening / 2), turned(-opening / 2)};
}

}  // namespace calot
