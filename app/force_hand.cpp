#include "app/force_hand.h"

namespace calot {
namespace {

HapticOptions options_for(double period) {
  HapticOptions options;
  options.world_period = period;
  return options;
}

}  // namespace

ForceHand::ForceHand(HapticDevice& device, const InstrumentGeometry& geometry, const HandOptions& options,
                     const Pose& start, double period)
    : ported_(device, geometry, options, start),
      reach_(reach_of(geometry)),
      port_(options.port),
      loop_(ported_, options_for(period)) {}

std::optional<InstrumentInput> ForceHand::ask(const HandControls& controls) {
  ported_.set_clutch(controls.clutch);
  ported_.set_ratchet(controls.ratchet);
  const HapticOutput& output = loop_.latest();
  if (!output.has_pose) return std::nullopt;
  InstrumentInput input = output.input;
  input.pose = through_port(input.pose, reach_, port_);  // contact moves the tool aside a little
  return input;
}

void ForceHand::give(const World& world, std::size_t instrument) {
  world.haptic_constraints(instrument, loop_.next_set());
  loop_.publish_set();
}

}  // namespace calot
