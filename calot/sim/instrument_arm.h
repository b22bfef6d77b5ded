// One instrument in the world: its input guarded, its parts on their way through a step, what it holds and cuts.
#pragma once
#include <optional>
#include <string>

#include "calot/sim/grasp.h"
#include "calot/sim/instrument_guard.h"
#include "calot/sim/scissors.h"

namespace calot {

struct InstrumentSetup {
  std::string name;
  InstrumentGeometry geometry;
  InstrumentInput start;           ///< where it is before the first step
  std::optional<double> friction;  ///< Coulomb's coefficient against tissue; empty: the tissue's own against steel
  double power = 30;               ///< of cautery [W]
};

/// A plain value. A step: `take`, then parts, grasp and scissors as the world needs them.
class InstrumentArm {
 public:
  explicit InstrumentArm(InstrumentSetup setup);

  /// Takes what came for this step; `from` becomes what `to` was.
  void take(const std::optional<InstrumentInput>& input, double step);
  /// Where the jaws really are at the end of the step: a grasp stops them.
  void set_opening(double opening) { opening_to_ = opening; }

  [[nodiscard]] const InstrumentSetup& setup() const { return setup_; }
  [[nodiscard]] const InstrumentGeometry& geometry() const { return setup_.geometry; }
  [[nodiscard]] const InstrumentInput& input() const { return guard_.accepted(); }
  [[nodiscard]] InputStatus status() const { return guard_.status(); }
  [[nodiscard]] InputStatus status_before() const { return status_before_; }
  [[nodiscard]] const Pose& from() const { return from_; }
  [[nodiscard]] const Pose& to() const { return to_; }
  [[nodiscard]] double opening_from() const { return opening_from_; }
  [[nodiscard]] double opening_to() const { return opening_to_; }
  [[nodiscard]] bool fires() const { return fires_; }  ///< the trigger went down in this step
  [[nodiscard]] bool closing() const { return opening_to_ < opening_from_ - 1e-9; }
  /// Jaws that close on tissue are the grasp's, the clip's or the blades' business, not the contacts'.
  [[nodiscard]] bool jaws_touch() const;
  /// The parts as moving shapes: shaft, and jaws where they touch; each with its number (0 shaft, 1 jaw a, 2 jaw b).
  void add_shapes(std::vector<MovingShape>& shapes, std::vector<std::uint8_t>& parts) const;

  std::optional<Grasp> grasp;  ///< graspers and forceps
  std::optional<Scissors> scissors;
  bool in_cut = false;  ///< the blades have cut and are still in the tissue: it isn't pushed out of them
  Stroke stroke;        ///< of the scissors
  bool held_before = false, slipped_before = false, bruised_before = false;  ///< what the last step saw, for events
  std::int32_t held_clip = -1;      ///< a clip between closed jaws, by number; −1: none
  double clip_opening = 0;          ///< what the hand asked for when it took it [rad]
  Vec3 clip_anchor = Vec3::Zero();  ///< where it is held, in the instrument's frame [m]
  Vec3 clip_pull = Vec3::Zero();    ///< of the jaws on it, in the last step [N]
  Vec3 force = Vec3::Zero();        ///< of the tissue on the instrument, in the last step [N]

  void append_state(std::string& bytes) const;

 private:
  InstrumentSetup setup_;
  InstrumentGuard guard_;
  InputStatus status_before_ = InputStatus::good;
  Pose from_, to_;
  double opening_from_ = 0, opening_to_ = 0;
  bool fire_before_ = false, fires_ = false;
};

}  // namespace calot
