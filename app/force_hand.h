// A device with force that holds an instrument: its own thread feels the tissue a thousand times a second.
#pragma once
#include "calot/device/ported_device.h"
#include "calot/sim/haptic_loop.h"
#include "calot/sim/world.h"

namespace calot {

/// On the world's thread. Neither owns the device.
class ForceHand {
 public:
  /// @param period  of the world's steps [s]
  ForceHand(HapticDevice& device, const InstrumentGeometry& geometry, const HandOptions& options, const Pose& start,
            double period);

  /// What the device asks of the instrument; none before its first good sample.
  std::optional<InstrumentInput> ask(const HandControls& controls);
  /// After the step: what the tissue is to this instrument.
  void give(const World& world, std::size_t instrument);
  [[nodiscard]] HapticStatus status() { return loop_.latest().status; }

 private:
  PortedDevice ported_;
  double reach_;
  Vec3 port_;
  HapticLoop loop_;
};

}  // namespace calot
