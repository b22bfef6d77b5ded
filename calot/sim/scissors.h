// What closing blades sweep, and so sever.
#pragma once
#include "calot/cut/split.h"
#include "calot/sim/instrument.h"

namespace calot {

struct ScissorsFigures {
  double margin = 0.2e-3;   ///< beyond the blades' edges, up and down: tissue squeezed between them bulges [m]
  double overlap = 0.1e-3;  ///< a step's sweep begins this far behind the end of the one before [m]
  double piece = 1e-3;      ///< a sweep is made of strips no longer than this [m]
};

/// Straight blades that turn about one axis and meet in the plane x = 0. The edge of each lies `blade_offset` e beyond
/// the axis, so at the opening φ the edges cross at the distance r = e / sin(φ/2) from it: what lies there is severed.
/// As φ falls, r runs to the tips. Beyond r, the edges are 2 (r sin(φ/2) − e) / cos(φ/2) apart. Where the crossing
/// point comes in a step, everything is cut that has been between the edges since the blades began to close, as far as
/// the blades' bodies reach now: what lies behind a blade's back is not. A plain value.
class Scissors {
 public:
  explicit Scissors(const InstrumentGeometry& geometry, double opening = 0, const ScissorsFigures& figures = {});

  /// What the blades sever while they go from pose `from` to `to` and from the present opening to `opening`, as
  /// triangles in the world; none while they open, rest, or only overlap more behind the tips.
  Sweep close(const Pose& from, const Pose& to, double opening);

  [[nodiscard]] double opening() const { return opening_; }
  /// Where the edges cross, from the pivot's axis [m], 0 … jaw_length.
  [[nodiscard]] double crossing(double opening) const;
  /// The edges' distance from the plane between the blades, at r from the pivot [m]; 0 nearer than the crossing.
  [[nodiscard]] double half_gap(double r, double opening) const;
  void append_state(std::string& bytes) const;

 private:
  [[nodiscard]] double half_height(double r) const;

  InstrumentGeometry geometry_;
  ScissorsFigures figures_;
  double opening_ = 0;
  double stroke_opening_ = 0;  // where this closing stroke began
};

}  // namespace calot
