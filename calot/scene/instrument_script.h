// What an instrument does in a scene: a few moments, smooth in between.
#pragma once
#include <optional>
#include <vector>

#include "calot/sim/instrument.h"

namespace calot {

/// Where the instrument is at a moment. `tip` is on its axis, where its jaws, its hook's foot or its tube end.
struct InstrumentKey {
  double time = 0;                    ///< [s]
  Vec3 tip = Vec3::Zero();            ///< [m]
  Vec3 direction = -Vec3::UnitZ();    ///< out of the tip, unit; with a port it follows from there
  double roll = 0;                    ///< about the instrument's axis [rad]
  double opening = 0, grip = 0;       ///< [rad], [N]
  bool energy = false, fire = false;  ///< from this moment on
};

/// The same as a pose of the instrument's frame, from a recording.
struct InstrumentPoseKey {
  double time = 0;  ///< [s]
  Pose pose;
  double opening = 0, grip = 0;
  bool energy = false, fire = false;
};

/// Times ascend strictly. One of the two lists is empty.
struct InstrumentScript {
  std::vector<InstrumentKey> keys;
  std::vector<InstrumentPoseKey> poses;
  [[nodiscard]] bool empty() const { return keys.empty() && poses.empty(); }
  [[nodiscard]] double end() const;  ///< time of the last key [s]
};

/// What the script asks at a time. Before the first key it is the first, after the last the last. In between numbers
/// follow monotone cubics ([Fritsch1984]): through every key, with a continuous velocity, never beyond the two keys
/// around; a pose's rotation turns evenly. With a port the instrument's axis goes through it (4 degrees of freedom).
/// A roll of 0 is how the instrument comes at the script's beginning with its x axis level (z up); from there its axis
/// turns by the shortest way.
/// @param script  not empty
/// @param reach   from the pivot to the tip [m]
InstrumentInput input_at(const InstrumentScript& script, double reach, const std::optional<Vec3>& port, double time);

}  // namespace calot
