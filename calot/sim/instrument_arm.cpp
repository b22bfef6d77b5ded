#include "calot/sim/instrument_arm.h"

#include "calot/sim/instrument_state.h"

namespace calot {

InstrumentArm::InstrumentArm(InstrumentSetup setup)
    : setup_(std::move(setup)),
      guard_(setup_.geometry, setup_.start),
      from_(setup_.start.pose),
      to_(setup_.start.pose),
      opening_from_(setup_.start.opening),
      opening_to_(setup_.start.opening) {
  switch (setup_.geometry.kind) {
    case InstrumentKind::bowel_grasper:
    case InstrumentKind::curved_forceps:
      grasp.emplace(setup_.geometry, setup_.start.opening);
      break;
    case InstrumentKind::scissors:
      scissors.emplace(setup_.geometry, setup_.start.opening);
      break;
    default:
      break;
  }
}

void InstrumentArm::take(const std::optional<InstrumentInput>& input, double step) {
  from_ = to_;
  opening_from_ = opening_to_;
  status_before_ = guard_.status();
  const InstrumentInput& accepted = guard_.accept(input, step);
  to_ = accepted.pose;
  opening_to_ = accepted.opening;
  // After a fault the trigger counts as down, so that one that was held all along doesn't fire again.
  const bool sound = guard_.status() == InputStatus::good;
  fires_ = sound && accepted.fire && !fire_before_;
  fire_before_ = !sound || accepted.fire;
}

bool InstrumentArm::jaws_touch() const {
  if (!setup_.geometry.has_jaws() || closing() || (grasp && grasp->holding()) || held_clip >= 0 || in_cut) return false;
  // A clip applier works with its jaws around a tube.
  return setup_.geometry.kind != InstrumentKind::clip_applier || opening_to_ >= 0.9 * setup_.geometry.max_opening;
}

void InstrumentArm::add_shapes(std::vector<MovingShape>& shapes, std::vector<std::uint8_t>& parts) const {
  const ArticulatedPoses before = articulate(setup_.geometry, opening_from_),
                         after = articulate(setup_.geometry, opening_to_);
  const auto add = [&](const RigidShape& shape, const Pose& a, const Pose& b, std::uint8_t part) {
    if (shape.pieces.empty()) return;
    shapes.push_back({&shape, from_ * a, to_ * b, setup_.friction.value_or(0.1)});
    parts.push_back(part);
  };
  add(setup_.geometry.shaft, before.shaft, after.shaft, 0);
  if (!jaws_touch()) return;
  add(setup_.geometry.jaw_a, before.jaw_a, after.jaw_a, 1);
  add(setup_.geometry.jaw_b, before.jaw_b, after.jaw_b, 2);
}

void InstrumentArm::append_state(std::string& bytes) const {
  guard_.append_state(bytes);
  detail::append_bytes(bytes, to_);
  detail::append_bytes(bytes, opening_to_);
  detail::append_bytes(bytes, fire_before_);
  detail::append_bytes(bytes, in_cut);
  detail::append_bytes(bytes, held_clip);
  detail::append_bytes(bytes, clip_anchor);
  detail::append_bytes(bytes, clip_opening);
  if (grasp) grasp->append_state(bytes);
  if (scissors) scissors->append_state(bytes);
  for (const std::vector<VertexId>* list : {&stroke.front, &stroke.lips})
    for (const VertexId v : *list) detail::append_bytes(bytes, v.value);
}

}  // namespace calot
