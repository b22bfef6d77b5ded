// Jaws that close on tissue: they hold it, up to what friction carries, and let it slip beyond.
#pragma once
#include "calot/sim/grasp_area.h"
#include "calot/sim/haptic_constraints.h"
#include "calot/sim/spring.h"
#include "calot/sim/tissue_state.h"

namespace calot {

struct GraspFigures {
  double friction = 5.0 / 6.0;     ///< of one serrated face: 3.0 N of grip then hold a pull of 5 N [Heijnsdijk2004]
  double damage_grip = 15;         ///< bruises from here on [N] [Heijnsdijk2004]
  double damage_pressure = 300e3;  ///< the same as a pressure [Pa]; assumed: that grip on 50 mm²
  double least_thickness = 0.4;    ///< jaws squeeze tissue to this share of its rest thickness at most; assumed
  double reach = 0.5e-3;           ///< tissue this near to a face touches it [m]
  double slack = 1.0e-3;           ///< held tissue is lost when it is this far beyond the jaws' outline [m]
};

/// One step as the jaws see it. Positions and velocities are those at its start.
struct GraspStep {
  double step = 0;     ///< its length [s], > 0
  Pose from, to;       ///< of the instrument
  double opening = 0;  ///< wanted at the end of the step [rad]
  double grip = 0;     ///< closing force wanted [N], clamped to 0 … max_grip
  TissueSurface surface;
  std::span<const Vec3> velocities, rest;  ///< of every vertex of the mesh [m/s], [m]
  bool trial = false;  ///< the step will be solved, handed to `correct`, and solved again where that says so
};

/// What one jaw does to the tissue.
struct JawReport {
  Vec3 force = Vec3::Zero();  ///< on the jaw, along world axes [N]
  double normal = 0;          ///< pressing on the tissue [N]
  double tangential = 0;      ///< size of the pull along the face [N]
  double area = 0;            ///< that it presses on [m²]
};

/// Tissue that suffered in the last step, for the injury model.
struct Bruise {
  VertexId vertex;
  double force = 0;     ///< this vertex's share of the grip [N]
  double area = 0;      ///< this vertex's share of the face [m²]
  double duration = 0;  ///< [s]
};

struct GraspReport {
  JawReport a, b;
  Vec3 pull = Vec3::Zero();   ///< of both jaws on the instrument [N]
  double grip = 0;            ///< mean normal force of the two jaws [N]
  double hold_limit = 0;      ///< the pull that friction carries at this grip [N]
  double slip = 0;            ///< in the last step, mean over what is held [m]
  double slipped = 0;         ///< since the grasp began [m]
  bool at_thickness = false;  ///< the jaws stopped because the tissue can't be squeezed thinner
};

/// One instrument's grasp. Each step: `update`, then `springs` to the motion, then `after_step` with what it gave. A
/// plain value; docs/simulation.md has the equations.
class Grasp {
 public:
  explicit Grasp(const InstrumentGeometry& geometry, double opening = 0, const GraspFigures& figures = {});

  /// Before the step: what lies between the jaws is taken hold of, how far they close, what friction carries now.
  void update(const GraspStep& step);
  /// After a trial solve: whether some of the tissue slides. Then `springs` gives plain friction there, to be solved
  /// with again. Without a trial, `springs` are softened beforehand by where the tissue would drift: exact for tissue
  /// that stays or follows; a pull that grows within a step passes the limit for that step.
  bool correct(std::span<const Vec3> trial_positions);
  /// How far all that is held would pull beyond its friction there, as a share of that.
  [[nodiscard]] double excess(std::span<const Vec3> trial_positions) const;
  /// Appends what acts on the tissue in this step.
  void springs(std::vector<Spring>& out) const;
  /// After it: slips where friction was exceeded, and reports.
  void after_step(std::span<const Vec3> positions);
  /// After an edit, with every vertex's position before and after it.
  void follow(const Remap& remap, std::span<const Vec3> before, std::span<const Vec3> after);
  void release();
  /// The same by jaws at this opening: something else is between them.
  void release(double opening);

  [[nodiscard]] bool holding() const { return !holds_.empty(); }
  [[nodiscard]] bool holds(VertexId vertex) const;
  [[nodiscard]] std::size_t held_count() const { return holds_.size(); }  ///< a vertex between both jaws counts twice
  /// Where the jaws are at the end of the step: the wanted opening, or as far as the tissue lets them.
  [[nodiscard]] double opening() const { return opening_; }
  [[nodiscard]] const GraspReport& report() const { return report_; }
  [[nodiscard]] const std::vector<Bruise>& bruises() const { return bruises_; }  ///< of the last step
  /// For the haptic loop: force and torque on the instrument about its position, and how they fall when it moves.
  [[nodiscard]] Vector6 wrench() const;
  [[nodiscard]] Matrix6 stiffness() const;
  void append_state(std::string& bytes) const;

 private:
  struct Hold {
    VertexId vertex;
    JawSide side = JawSide::a;
    Vec3 anchor = Vec3::Zero();    // in the jaw's frame
    double area = 0;               // seen by the jaw [m²]
    double limit = 0;              // friction [N]
    double depth = 0;              // of the face in the tissue, where that goes along with the jaws [m]
    double along = 0, across = 0;  // stiffness along the normal and across it, in this step [N/m]
    Vec3 pull = Vec3::Zero();      // while it slides: how far beyond the anchor the spring aims
    bool slides = false;           // in this step: pulled by `limit` towards where it was stretched to
    Vec3 place = Vec3::Zero();     // of the vertex, expected or reached at the end of the step
    Vec3 target = Vec3::Zero();    // the anchor at the end of the step, in the world
    Vec3 force = Vec3::Zero();     // on the tissue, in the last step [N]
  };
  struct Side {
    double area = 0;                // of all holds
    double pressed = 0;             // of those that the face presses on
    double normal = 0;              // force that friction counts with [N]
    Vec3 direction = Vec3::Zero();  // from the jaw's face into the mouth, in the world at the end of the step
    double level = 0;               // of the face in the jaw's frame, < 0 where it took tissue that reached behind it
    Pose pose;                      // of the jaw at the end of the step
  };

  bool begin(const GraspStep& step);
  void renew(const GraspStep& step);
  void add(const JawShare& share, const GraspStep& step);
  void close_jaws(const GraspStep& step);
  void place_jaws(const GraspStep& step);
  void aim(bool trial);
  void sum_areas();
  void press(double normal_a, double normal_b);
  void slide();
  void write_report();
  [[nodiscard]] double squeezed_to(const GraspStep& step) const;
  [[nodiscard]] double lever() const;
  [[nodiscard]] Vec3 stretch_across(const Hold& hold) const;
  [[nodiscard]] Spring spring_of(const Hold& hold) const;
  Side& side(JawSide s) { return sides_[s == JawSide::a ? 0 : 1]; }
  [[nodiscard]] const Side& side(JawSide s) const { return sides_[s == JawSide::a ? 0 : 1]; }

  InstrumentGeometry geometry_;
  GraspFigures figures_;
  double opening_ = 0, grip_ = 0, step_ = 0;
  double squeeze_ = 0;       // mean force of the faces' springs in the last step [N]
  Pose pose_;                // of the instrument at the end of the step
  std::vector<Hold> holds_;  // ascending by vertex, then side
  std::array<Side, 2> sides_;
  GraspReport report_;
  std::vector<Bruise> bruises_;
  MouthContents mouth_;  // kept for its memory only
};

}  // namespace calot
