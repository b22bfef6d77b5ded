// Clips: left behind by the applier, they press a tube's walls together and stay there.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calot/sim/clip_section.h"
#include "calot/sim/spring.h"
#include "calot/sim/tissue_state.h"

namespace calot {

enum class ClipState : std::uint8_t {
  closing,  ///< the applier's jaws press it together
  closed,   ///< left behind
  off,      ///< came off, or there is nothing between its legs (any more)
};

/// A clip on tissue. Each step: `springs` and `loads` to the motion, then `after_step`. Its frame: origin between the
/// legs' middles, x along the tube, y the way it closes, z along the legs to their tips. Massless: what pulls on it
/// reaches the tissue in the same step. A plain value; docs/simulation.md has the equations.
class Clip {
 public:
  /// Fired by an applier with jaws at `opening`: takes what lies between the legs. State `off` if that is nothing.
  Clip(const ClipFigures& figures, const InstrumentGeometry& applier, const Pose& pose, double opening,
       const TissueSurface& surface, const TetMesh& mesh);

  /// What draws the walls together in a step of this length [s].
  void springs(double step, std::vector<Spring>& out);
  /// Something pulls on the clip in this step [N], world axes; several add up.
  void pull(const Vec3& force) { load_ += force; }
  /// Adds the pull to the forces on the tissue, one for each vertex of the mesh [N].
  void loads(std::span<Vec3> forces) const;
  /// After the step: the frame follows the tissue, and the clip comes off where it was pulled too hard.
  void after_step(std::span<const Vec3> positions);
  /// After an edit, with every vertex's position before and after it.
  void follow(const Remap& remap, std::span<const Vec3> before, std::span<const Vec3> after);

  /// Whether the clip shuts this tube: all of the region's cross-section that hangs together with what the legs hold
  /// lies between them, and the walls are together. Looks at every tet of the mesh.
  [[nodiscard]] bool closes(std::int32_t region, const TetMesh& mesh, std::span<const Vec3> positions) const;

  [[nodiscard]] ClipState state() const { return state_; }
  [[nodiscard]] const Pose& frame() const { return frame_; }
  /// Largest distance of the walls between the legs, and what it is when they are together [m].
  [[nodiscard]] double gap() const;
  [[nodiscard]] double closed_gap() const { return closed_gap_; }
  [[nodiscard]] double held_area() const;                                ///< of one wall, under the legs [m²]
  [[nodiscard]] double closing_force() const { return closing_force_; }  ///< in the last step [N]
  [[nodiscard]] double strain() const { return strain_; }  ///< share of what takes it off, in the last step
  [[nodiscard]] bool whole() const { return whole_; }      ///< took the whole cross-section when it was fired
  [[nodiscard]] bool holds(VertexId vertex) const;
  [[nodiscard]] std::vector<std::pair<VertexId, double>> held() const;    ///< who feels a pull on it; shares, sum 1
  [[nodiscard]] const std::vector<TetId>& tets() const { return tets_; }  ///< in its slab, between its legs; ascending
  [[nodiscard]] std::size_t pair_count() const { return pairs_.size(); }
  /// Two legs and the bow that joins them, in the frame, as far apart as they are now.
  [[nodiscard]] RigidShape shape() const;
  void append_state(std::string& bytes) const;

 private:
  struct Pair {  // of walls a (−y) and b (+y)
    VertexId a, b;
    double stiffness = 0;  // [N/m]
    Vec3 offset;           // b − a when fired, in the springs' frame [m]
    double closed = 0;     // y of it when closed [m]
  };
  struct Held {
    VertexId vertex;
    double weight = 0;  // share of the clip's pull; sum 1
    Vec3 place;         // in the frame [m]
  };
  void make_pairs(std::span<const Vec3> positions);
  void gather(std::span<const Vec3> positions);
  void fit(std::span<const Vec3> positions);
  void turn_springs(std::span<const Vec3> positions);
  void measure_gaps(std::span<const Vec3> positions);
  void judge_pull();
  void follow_tets(const Remap& remap);
  void come_off();
  [[nodiscard]] bool together() const;
  [[nodiscard]] bool spans(std::int32_t region, double reach, double slope, const TetMesh& mesh,
                           std::span<const Vec3> positions) const;
  [[nodiscard]] Vec3 target(const Pair& pair) const;

  ClipFigures figures_;
  ClipState state_ = ClipState::closing;
  Pose frame_;
  Eigen::Quaterniond turn_;  // of the springs: they pull without turning the tissue
  std::vector<ClipStation> stations_;
  std::vector<Pair> pairs_;  // ascending by a, then b
  std::vector<Held> held_;   // ascending by vertex
  std::vector<TetId> tets_;
  double progress_ = 0, time_ = 0;  // of closing, 0 … 1; since it was fired [s]
  double closed_gap_ = 0, closing_force_ = 0, strain_ = 0;
  bool whole_ = false;
  Vec3 load_ = Vec3::Zero();
};

double spacing(const Clip& a, const Clip& b);  ///< of their middles [m]

}  // namespace calot
