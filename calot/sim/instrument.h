// Instruments as the simulation knows them: articulated rigid shapes with jaws, blades or a hook.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "calot/contact/rigid_shape.h"

namespace calot {

enum class InstrumentKind : std::uint8_t {
  bowel_grasper,   ///< two fenestrated jaws
  curved_forceps,  ///< dissector, two curved jaws
  clip_applier,    ///< two jaws that hold and close a clip
  scissors,        ///< two blades that cut what they sweep
  hook,            ///< monopolar L-hook, energy by the pedal
  suction,         ///< suction and irrigation tube
  fan_retractor,   ///< three fingers, spread, that lift a liver
};

/// What a hand, a device or a script asks of one instrument at the end of a step.
struct InstrumentInput {
  Pose pose;  ///< of the instrument's frame: origin at the jaws' pivot (or the end of tube or fingers), +z out of the
              ///< tip
  double opening = 0;   ///< angle between the jaws, 0 … geometry's max_opening [rad]
  double grip = 0;      ///< closing force wanted at the jaws, ≥ 0 [N]
  bool energy = false;  ///< pedal: cautery on
  bool fire = false;    ///< close and leave a clip (on the change from false to true)
};

/// The rigid parts of an instrument, in its frame, with the jaws closed. Jaw a turns by +opening/2 about x, which opens
/// it towards −y, jaw b by −opening/2, towards +y. The jaws' inner faces then lie in y = 0; scissors' blades cross
/// there.
struct InstrumentGeometry {
  InstrumentKind kind = InstrumentKind::bowel_grasper;
  RigidShape shaft, jaw_a, jaw_b;  ///< jaws are empty for hook, suction and retractor
  double max_opening = 0;          ///< [rad]
  double jaw_length = 0;           ///< from the pivot to the tips [m]
  double jaw_width = 0;            ///< across, along x, where the inner faces begin [m]
  double grip_stiffness = 0;   ///< how much the held tissue is pulled per displacement of the tool, all points [N/m]
  double max_grip = 0;         ///< [N]
  double usual_grip = 0;       ///< what a surgeon applies who doesn't think of it [N]
  double face_stiffness = 0;   ///< of one jaw's face against what it presses on, all points [N/m]
  double face_start = 0;       ///< from the pivot to where the inner faces begin [m]
  double tip_width = 0;        ///< across, along x, at the tips [m]
  double jaw_curve = 0;        ///< curvature of the jaws' middle line towards +x, from face_start on [1/m]
  double blade_offset = 0;     ///< scissors: how far each edge lies beyond the pivot's axis, > 0 [m]
  double blade_depth = 0;      ///< scissors: from the edge to the back, at the pivot [m]
  double blade_tip_depth = 0;  ///< scissors: the same at the tip [m]
  Vec3 hook_heel = Vec3::Zero(), hook_tip = Vec3::Zero();  ///< hook: the ends of its foot's middle line [m]
  double hook_radius = 0;                                  ///< hook: of its wire [m]

  [[nodiscard]] bool has_jaws() const { return jaw_length > 0; }
  /// x of the middle line, and width of the inner faces [m], at z from the pivot [m].
  [[nodiscard]] double middle(double z) const;
  [[nodiscard]] double width(double z) const;
};

/// From the pivot to the point on its axis where jaws, hook or tube end [m].
double reach_of(const InstrumentGeometry& geometry);

/// The usual 5 mm instruments (clip applier 10 mm). Source of each size: docs/simulation.md.
InstrumentGeometry instrument_geometry(InstrumentKind kind);
std::string_view name_of(InstrumentKind kind);

/// The three parts (shaft, jaw a, jaw b) in the instrument's frame at an opening.
struct ArticulatedPoses {
  Pose shaft, jaw_a, jaw_b;
};
ArticulatedPoses articulate(const InstrumentGeometry& geometry, double opening);

}  // namespace calot
